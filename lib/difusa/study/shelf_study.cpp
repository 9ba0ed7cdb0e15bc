#include <difusa/study/shelf_study.h>

#include <difusa/algebra/dense.h>
#include <difusa/core/text.h>
#include <difusa/form_factors/form_factors.h>
#include <difusa/study/references/form_factors.h>
#include <difusa/study/references/shelf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>

namespace difusa {

namespace {

double largest_miss(std::span<const double> got, std::span<const double> limit) {
    double most = 0.0;
    for (std::size_t i = 0; i < got.size(); ++i) {
        most = std::max(most, std::abs(got[i] / limit[i] - 1.0));
    }
    return most;
}

/// B_i = E_i + rho_i sum_j F_ij B_j of the three surfaces.
std::array<double, 3> patches_with(const FormFactors& F, const std::vector<Material>& materials) {
    Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
    Eigen::Vector3d E;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        E[row] = materials[i].emission[0];
        for (std::size_t j = 0; j < 3; ++j) {
            K(row, static_cast<Eigen::Index>(j)) -= materials[i].reflectance[0] * F.at(i, j);
        }
    }
    const Eigen::Vector3d B = solve_dense(K, E);
    return {B[0], B[1], B[2]};
}

ShelfTrial try_shelf(const Registry& registry, double length, const BakeOptions& options, const MeasureOptions& how,
                     const Execution& execution) {
    ShelfTrial trial;
    trial.length = length;
    const Judge judge(shelf_of_length(length), how, execution);
    const Scene& scene = judge.reference.scene;
    const FormFactors F =
        form_factors(scene.mesh, surfaces_by_material(scene.mesh, scene.materials), {1e-9}, execution.silent());
    trial.AB = F.at(0, 1);
    trial.AC = F.at(0, 2);
    trial.BA = F.at(1, 0);
    const ShelfFormFactors limit = shelf(1.0, 1.0);
    trial.factors_off =
        largest_miss(std::array{trial.AB, trial.AC, trial.BA}, std::array{limit.AB, limit.AC, limit.BA});
    ShelfParameters parameters;
    for (std::size_t i = 0; i < 3; ++i) {
        parameters.E[i] = scene.materials[i].emission[0];
        parameters.rho[i] = scene.materials[i].reflectance[0];
    }
    trial.patches_off = largest_miss(patches_with(F, scene.materials), shelf_patches(parameters));
    trial.middle = measure(registry, judge, options, how, execution);
    trial.bound = judge.reference.mesh_error;
    return trial;
}

double error_in_the_middle(const ShelfTrial& t) {
    return t.middle.failed ? NAN : t.middle.total.l2.relative().value_or(NAN);
}

} // namespace

std::vector<ShelfTrial> shelf_study(const Registry& registry, const std::vector<double>& lengths,
                                    const BakeOptions& options, const MeasureOptions& how, const Execution& execution,
                                    const std::function<void(const ShelfTrial&)>& tell) {
    std::vector<ShelfTrial> trials;
    for (const double length : lengths) {
        trials.push_back(try_shelf(registry, length, options, how, execution));
        tell(trials.back());
    }
    return trials;
}

std::string shelf_header() {
    return "| length | F_AB | F_AC | form factors off by | three patches off by | sites | baked, in the middle: rms "
           "error "
           "| at most, by the length |\n|---|---|---|---|---|---|---|---|\n";
}

std::string shelf_row(const ShelfTrial& t) {
    std::array<char, 192> row{};
    std::snprintf(row.data(), row.size(), "| %g | %.6f | %.6f | %.2e | %.2e ", t.length, t.AB, t.AC, t.factors_off,
                  t.patches_off);
    std::string text = row.data();
    if (t.middle.failed) {
        text += "| – | " + t.middle.failure + " ";
    } else {
        std::snprintf(row.data(), row.size(), "| %zu | %.2e ", t.middle.sites, error_in_the_middle(t));
        text += row.data();
    }
    std::snprintf(row.data(), row.size(), "| %.1e |\n", t.bound);
    return text + row.data();
}

std::string shelf_csv_header() {
    return "length,F_AB,F_AC,F_BA,factors_off,patches_off,sites,rms_error,bound\n";
}

std::string shelf_csv_row(const ShelfTrial& t) {
    std::string row;
    for (const double value : {t.length, t.AB, t.AC, t.BA, t.factors_off, t.patches_off}) {
        row += text_of(value) + ",";
    }
    return row + std::to_string(t.middle.sites) + "," + text_of(error_in_the_middle(t)) + "," + text_of(t.bound) + "\n";
}

} // namespace difusa
