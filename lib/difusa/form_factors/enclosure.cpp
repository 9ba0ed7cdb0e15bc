#include <difusa/form_factors/enclosure.h>

#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/core/text.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace difusa {

namespace {

constexpr double largest_gap = 1e-3; ///< of a row sum to 1 without surroundings: more is an opening
constexpr double rounding = 1e-12;   ///< of a row sum

const char* const undetermined =
    "the temperatures are not determined: some surfaces exchange heat neither with a fixed temperature nor with the "
    "surroundings, but for what errors of the form factors make up; fix the temperature of one of them, or, if they do "
    "exchange some, give a smaller --tolerance";

/// What the estimated errors of a row may add to its sum.
double error_of_row_sum(const FormFactors::Row& row) {
    return std::accumulate(row.error.begin(), row.error.end(), rounding);
}

/// The unknowns are the radiosities of the surfaces and then the powers of the bodies.
class EnclosureSystem {
  public:
    EnclosureSystem(const Scene& scene, const FormFactors& F, const std::vector<Index>& material,
                    const Execution& execution)
        : scene_(scene), F_(F), material_(material), body_(scene.materials.size(), none) {
        for (const Index m : material_) {
            const std::optional<Thermal>& thermal = scene_.materials[m].thermal;
            if (thermal && thermal->given == Thermal::Given::heat && body_[m] == none) {
                body_[m] = static_cast<Index>(bodies_.size());
                bodies_.push_back(m);
            }
        }
        const double count = static_cast<double>(F_.size() + bodies_.size());
        require_memory(4.0 * sizeof(double) * count * count, execution.memory_left(),
                       "the exchange between " + std::to_string(F_.size()) + " surfaces",
                       "join faces to fewer surfaces (--surfaces material), or use bake_radiosity");
        assemble();
    }

    /// The temperatures of the bodies go to `scene`.
    Enclosure solve(Scene& scene, const std::vector<std::string>& name) {
        const Eigen::PartialPivLU<Eigen::MatrixXd> solver(matrix_);
        const Eigen::MatrixXd inverse = solver.inverse().cwiseAbs();
        // With other errors as large the matrix may be singular: |M^-1| dM has a norm of 1.
        if (!((inverse * defect_of([&](std::size_t i) {
                   return error_of_row_sum(F_.rows[i]);
               })).maxCoeff<Eigen::PropagateNaN>() < 1.0)) {
            throw InputError(undetermined);
        }
        x_ = solver.solve(right_);
        set_bodies(scene);
        errors_ = inverse * defect_of([&](std::size_t i) { return irradiation_error(i); });
        Enclosure enclosure;
        for (std::size_t i = 0; i < F_.size(); ++i) {
            enclosure.surfaces.push_back(surface(scene, i, name[i]));
            enclosure.heat += F_.area[i] * enclosure.surfaces.back().state.net_flux;
            enclosure.to_surroundings += F_.area[i] * (1.0 - F_.row_sum(i)) * x_[row(i)];
        }
        return enclosure;
    }

  private:
    static Eigen::Index row(std::size_t i) { return static_cast<Eigen::Index>(i); }
    Eigen::Index body_row(Index m) const { return row(F_.size() + body_[m]); }
    const Material& material(std::size_t i) const { return scene_.materials[material_[i]]; }

    void assemble() {
        const Eigen::Index count = row(F_.size() + bodies_.size());
        matrix_ = Eigen::MatrixXd::Identity(count, count);
        right_ = Eigen::VectorXd::Zero(count);
        std::vector<double> absorbing(scene_.materials.size(), 0.0); // area times emissivity
        for (std::size_t i = 0; i < F_.size(); ++i) {
            absorbing[material_[i]] += body_[material_[i]] != none ? F_.area[i] * material(i).thermal->emissivity : 0.0;
        }
        for (std::size_t i = 0; i < F_.size(); ++i) {
            const FormFactors::Row& factors = F_.rows[i];
            const Index m = material_[i];
            for (std::size_t e = 0; e < factors.column.size(); ++e) {
                matrix_(row(i), row(factors.column[e])) -= material(i).reflectance[0] * factors.factor[e];
            }
            if (body_[m] == none) {
                right_[row(i)] = material(i).emission[0];
                continue;
            }
            const double share = F_.area[i] * material(i).thermal->emissivity / absorbing[m];
            matrix_(row(i), body_row(m)) -= material(i).thermal->emissivity;
            for (std::size_t e = 0; e < factors.column.size(); ++e) {
                matrix_(body_row(m), row(factors.column[e])) -= share * factors.factor[e];
            }
        }
        for (const Index m : bodies_) {
            right_[body_row(m)] = scene_.materials[m].thermal->value / absorbing[m];
        }
    }

    void set_bodies(Scene& scene) const {
        for (const Index m : bodies_) {
            const auto temperature = temperature_of(x_[body_row(m)], scene.thermal->reference);
            if (!temperature) {
                throw InputError(colder_than_possible(scene.materials[m]));
            }
            set_temperature(scene, m, *temperature);
        }
    }

    /// What errors of F in row i make of the irradiation: sum_j |dF_ij| |b_j|.
    double irradiation_error(std::size_t i) const {
        double sum = 0.0;
        for (std::size_t e = 0; e < F_.rows[i].column.size(); ++e) {
            sum += F_.rows[i].error[e] * std::abs(x_[row(F_.rows[i].column[e])]);
        }
        return sum;
    }

    /// What is missing from the equations if as much as `error` tells of it is missing from the irradiation of each
    /// surface.
    template <class Error> Eigen::VectorXd defect_of(const Error& error) const {
        Eigen::VectorXd defect = Eigen::VectorXd::Zero(right_.size());
        std::vector<double> absorbing(scene_.materials.size(), 0.0), missed(absorbing);
        for (std::size_t i = 0; i < F_.size(); ++i) {
            const double own = error(i);
            defect[row(i)] = material(i).reflectance[0] * own;
            if (body_[material_[i]] != none) {
                const double weight = F_.area[i] * material(i).thermal->emissivity;
                absorbing[material_[i]] += weight;
                missed[material_[i]] += weight * own;
            }
        }
        for (const Index m : bodies_) {
            defect[body_row(m)] = missed[m] / absorbing[m];
        }
        return defect;
    }

    EnclosureSurface surface(const Scene& scene, std::size_t i, const std::string& name) const {
        double h = 0.0, h_error = irradiation_error(i);
        for (std::size_t e = 0; e < F_.rows[i].column.size(); ++e) {
            h += F_.rows[i].factor[e] * x_[row(F_.rows[i].column[e])];
            h_error += F_.rows[i].factor[e] * errors_[row(F_.rows[i].column[e])];
        }
        const std::optional<ThermalState> state = thermal_state(scene, material_[i], h);
        if (!state) {
            throw InputError("more heat is drawn from surface " + name + " (material " + material(i).name +
                             ") than arrives: its net flux is " + text_of(material(i).thermal->value) +
                             " W/m^2, but even at 0 K it absorbs only " +
                             text_of(material(i).thermal->emissivity *
                                     std::max(0.0, h + excess_power(scene.thermal->reference, 0.0))) +
                             " W/m^2; draw less");
        }
        EnclosureSurface result{material_[i], F_.area[i], *state, 0.0, 0.0};
        const Thermal& thermal = *material(i).thermal;
        const Index m = material_[i];
        const double power_error = body_[m] != none ? errors_[body_row(m)] : h_error;
        if (thermal.given != Thermal::Given::net_flux) {
            result.net_flux_error = thermal.emissivity * (h_error + (body_[m] != none ? power_error : 0.0));
        }
        if (thermal.given != Thermal::Given::temperature && state->temperature > 0.0) {
            result.temperature_error = power_error / (4.0 * stefan_boltzmann * std::pow(state->temperature, 3));
        }
        return result;
    }

    const Scene& scene_;
    const FormFactors& F_;
    const std::vector<Index>& material_;
    std::vector<Index> body_;   ///< #materials: number of the body, or none
    std::vector<Index> bodies_; ///< materials
    Eigen::MatrixXd matrix_;
    Eigen::VectorXd right_, x_, errors_;
};

void check_enclosure(const Scene& scene, const FormFactors& F, const std::vector<Index>& material,
                     const std::vector<std::string>& name) {
    for (std::size_t i = 0; i < F.size(); ++i) {
        const Material& own = scene.materials[material[i]];
        if ((own.mirror > 0.0).any() || !own.thermal) {
            throw InputError("the material " + own.name +
                             " is a mirror, over which form factors do not go: use "
                             "bake_radiosity, whose rays do");
        }
        const double sum = F.row_sum(i);
        if (scene.thermal->surroundings || std::abs(1.0 - sum) <= largest_gap) {
            continue;
        }
        if (const double error = error_of_row_sum(F.rows[i]); std::abs(1.0 - sum) <= error) {
            throw InputError("the form factors of surface " + name[i] + " sum to " + text_of(sum) +
                             ", because of their errors, of " + text_of(error) +
                             " by estimate: give a smaller --tolerance, or make the sums 1 with --close");
        }
        if (sum > 1.0) {
            throw InputError("the form factors of surface " + name[i] + " sum to " + text_of(sum) +
                             ", more than their errors explain: faces that overlap are counted twice");
        }
        throw InputError("the form factors of surface " + name[i] + " sum to " + text_of(sum) +
                         ": the enclosure is open, or shows the backs of faces; say how warm the surroundings are, "
                         "\"surroundings\": {\"temperature\": 293.15}, or close it");
    }
}

} // namespace

Enclosure solve_enclosure(const Scene& scene, const FormFactors& F, const std::vector<Index>& material,
                          const std::vector<std::string>& name, const Execution& execution) {
    DIFUSA_REQUIRE(scene.thermal && material.size() == F.size() && name.size() == F.size());
    check_enclosure(scene, F, material, name);
    Scene warmed;
    warmed.materials = scene.materials;
    warmed.thermal = scene.thermal;
    return EnclosureSystem(scene, F, material, execution).solve(warmed, name);
}

} // namespace difusa
