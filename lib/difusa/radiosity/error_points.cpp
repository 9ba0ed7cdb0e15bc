#include <difusa/radiosity/error_points.h>

#include <difusa/algebra/hit_lists.h>
#include <difusa/algebra/sparse_rows.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/mirrored.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

namespace difusa {

namespace {

constexpr double rounding = 1e-12;                             ///< of a variance, relative to the square of the mean
constexpr double least_followed = 0.01;                        ///< of light, beside what is cut off
constexpr double hardly_any = 1e-4;                            ///< of noise or variation, as a share
constexpr std::size_t candidates_per_point = 16;               ///< from which it is chosen
constexpr double nearest_facing = 0.05, farthest_facing = 1.0; ///< distances told apart, over the spacing

/// The irradiance of the surfels, all sets together. `smooth`: the means over them of the light in the basis.
Values irradiance_of_surfels(const Solution& solution, const Values& smooth) {
    const FieldParts& parts = solution.field->parts();
    return parts.direct_in_basis ? smooth : Values(smooth + sum_of_parts(solution.light.direct, parts.channels));
}

/// ErrorPoints::variance and variance_of_fresh. `sources`: with the light of all sets together.
void find_variances(const Solution& solution, ErrorSources& sources, const Execution& execution) {
    const FieldParts& parts = solution.field->parts();
    const RadiositySystem& system = *parts.system;
    const LinearOperator& plain = plain_part(*system.transport().W);
    const bool by_rays =
        dynamic_cast<const HitLists*>(&plain) != nullptr || dynamic_cast<const SparseRows*>(&plain) != nullptr;
    if (!by_rays || system.parts().directions->is_fixed()) {
        sources.variance.setZero(static_cast<Eigen::Index>(system.transport().points()), parts.channels);
        sources.variance_of_fresh = sources.variance;
        return;
    }
    const Values b = sum_of_parts(solution.light.emission, parts.channels) +
                     solution.light.reflectance.cwiseProduct(irradiance_of_surfels(solution, sources.light));
    const Values sky = parts.scene->has_sky() ? sky_radiosity(*parts.scene, parts.channels) : Values();
    // What a ray brings from mirrors, too, is left out: of the noise, points with mirrors in sight know a part.
    const Values all = system.transport().on_bins(b, sky, execution);
    Values mean, square;
    plain.apply(all, mean, execution);
    plain.apply(all.cwiseAbs2(), square, execution);
    sources.variance_of_fresh = (square - mean.cwiseAbs2()).cwiseMax(0.0);
    const RefinedTransport* const refined = refined_part(*system.transport().W);
    sources.variance = refined != nullptr ? refined->variance_of_rays(all, execution) : sources.variance_of_fresh;
    if (parts.sent || system.transport().openings) {
        sources.variance_of_fresh = sources.variance; // their rays are corrected, or aimed, likewise
    }
}

/// The mixture's integral over each surfel; they sum to 1, or all are 0 if nothing reflects.
std::vector<double> density_of(const Surfels& surfels, const Values& weights, const ErrorSources& sources,
                               const Execution& execution) {
    std::array<std::vector<double>, 5> parts;
    parts.fill(std::vector<double>(surfels.size()));
    parallel_for(surfels.size(), 4096, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t s = begin; s < end; ++s) {
            const auto row = static_cast<Eigen::Index>(s);
            const Eigen::RowVectorXd squared = weights.row(row).cwiseAbs2() * surfels.area(static_cast<Index>(s));
            parts[0][s] = squared.sum();
            parts[1][s] = squared.dot(sources.light.row(row).cwiseAbs2());
            parts[2][s] = squared.dot(sources.variation.row(row));
            parts[3][s] = squared.dot(sources.noise.row(row));
            parts[4][s] = squared.dot(sources.shadowed.row(row));
        }
    });
    // Variances that are rounding errors do not count.
    const double least = rounding * std::accumulate(parts[1].begin(), parts[1].end(), 0.0);
    std::array<double, 5> factor{};
    double present = 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const double sum = std::accumulate(parts[k].begin(), parts[k].end(), 0.0);
        factor[k] = sum > (k < 2 ? 0.0 : least) ? 1.0 / sum : 0.0;
        present += factor[k] > 0.0 ? 1.0 : 0.0;
    }
    std::vector<double> density(surfels.size(), 0.0);
    for (std::size_t s = 0; s < surfels.size() && factor[0] > 0.0; ++s) {
        for (std::size_t k = 0; k < parts.size(); ++k) {
            density[s] += factor[k] / present * parts[k][s];
        }
    }
    return density;
}

/// One over the distance of each point to what it faces, as far as distances are told apart.
std::vector<double> chances(const SurfelPoints& points, const FacingDistance& facing, double spacing,
                            const Execution& execution) {
    std::vector<double> chance(points.size());
    parallel_for(points.size(), 1024, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t p = begin; p < end; ++p) {
            chance[p] = 1.0 / std::max(nearest_facing * spacing, facing(points.place[p], farthest_facing * spacing));
        }
    });
    return chance;
}

/// So that constants are integrated exactly.
void fit_weights(ErrorPoints& points, double area) {
    const double weights = std::accumulate(points.weight.begin(), points.weight.end(), 0.0);
    for (double& weight : points.weight) {
        weight *= area / weights;
    }
}

} // namespace

Values judged_weights(const Solution& solution) {
    const Values& rho = solution.light.reflectance;
    return solution.field->parts().scene->thermal ? Values(Values::Ones(rho.rows(), rho.cols())) : rho;
}

Rgb judged_weight(const Scene& scene, const SurfacePoint& x) {
    return scene.thermal ? Rgb(Rgb::Ones()) : scene.reflectance(x);
}

double largest_reflectance(const Scene& scene, int channels) {
    const Mesh& mesh = scene.mesh;
    double largest = 0.0;
    const auto add = [&](const Rgb& rho, const Rgb& specular) {
        const Rgb product =
            (rho > 0.0).select(rho / (1.0 - specular).max(rho), 0.0); // at most 1, whatever the rounding
        largest = std::max(largest, channels == 1 ? product[0] : product.maxCoeff());
    };
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Material& material = scene.materials[mesh.material[t]];
        const Rgb factor = material.reflectance_texture ? material.reflectance_texture->brightest() : Rgb(Rgb::Ones());
        if (material.vertex_colours) {
            for (const Rgb& rho : mesh.corner_reflectance[t]) {
                add(factor * rho, material.specular());
            }
        } else {
            add(factor * material.reflectance, material.specular());
        }
    }
    return largest;
}

Values cut_off_coefficients(const Solution& solution, const Execution& execution) {
    const FieldParts& parts = solution.field->parts();
    const Discretisation& discretisation = parts.system->discretisation();
    const Values& cut_off = parts.system->transport().cut_off;
    if (cut_off.rows() == 0 || cut_off.maxCoeff() == 0.0) {
        return {};
    }
    Values smooth;
    discretisation.averages->apply(sum_of_parts(parts.smooth, parts.channels), smooth, execution);
    const Values H = irradiance_of_surfels(solution, smooth);
    Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(H.cols());
    for (Index s = 0; s < discretisation.surfels->size(); ++s) {
        mean += discretisation.surfels->area(s) / parts.scene->mesh.area * H.row(static_cast<Eigen::Index>(s));
    }
    Values light(cut_off.rows(), mean.cols());
    for (Eigen::Index c = 0; c < light.cols(); ++c) {
        const Eigen::ArrayXd share = cut_off.col(c % cut_off.cols()).array();
        light.col(c) = mean[c] * share / (1.0 - share).max(least_followed); // the mean lacks as much
    }
    return discretisation.evaluation->coefficients(light, execution);
}

ErrorSources error_sources(const Solution& solution, const Execution& execution) {
    const FieldParts& field = solution.field->parts();
    const BasisAverages& P = *field.system->discretisation().averages;
    const Values c = sum_of_parts(field.smooth, field.channels);
    ErrorSources sources;
    Values square;
    P.apply(c, sources.light, execution);
    P.apply(c.cwiseAbs2(), square, execution);
    sources.variation = (square - sources.light.cwiseAbs2()).cwiseMax(0.0);
    find_variances(solution, sources, execution);
    P.apply(sources.variance.topRows(c.rows()), sources.noise, execution);
    sources.noise = sources.noise.cwiseMax(0.0);
    sources.shadowed.setZero(sources.light.rows(), sources.light.cols());
    if (field.direct->casts_penumbras() && !field.direct_in_basis) {
        const Values direct = sum_of_parts(solution.light.direct, field.channels);
        for (Eigen::Index s = 0; s < direct.rows(); ++s) {
            if (solution.light.even[static_cast<std::size_t>(s)] == 0) {
                sources.shadowed.row(s) = direct.row(s).cwiseAbs2();
            }
        }
    }
    return sources;
}

ErrorPointSampler::ErrorPointSampler(const Solution& solution, const Execution& execution, Of errors)
    : surfels_(*solution.field->parts().system->discretisation().surfels), execution_(execution),
      weights_(judged_weights(solution)), sources_(error_sources(solution, execution)),
      facing_(solution.field->parts().scene->mesh) {
    if (errors == Of::irradiance) {
        weights_.setOnes();
    }
    density_ = density_of(surfels_, weights_, sources_, execution);
    for (Index s = 0; s < surfels_.size(); ++s) {
        area_ += density_[s] > 0.0 ? surfels_.area(s) : 0.0;
    }
}

bool ErrorPointSampler::is_blind() const {
    double light = 0.0;
    std::array<double, 2> all{}, seen{};
    for (Index s = 0; s < surfels_.size(); ++s) {
        const auto row = static_cast<Eigen::Index>(s);
        const double area = surfels_.area(s);
        light += area * sources_.light.row(row).squaredNorm();
        const std::array<double, 2> here{area * sources_.noise.row(row).sum(),
                                         area * sources_.variation.row(row).sum()};
        for (std::size_t k = 0; k < here.size(); ++k) {
            all[k] += here[k];
            seen[k] += density_[s] > 0.0 ? here[k] : 0.0;
        }
    }
    const auto hides = [&](std::size_t k) { return all[k] > rounding * light && seen[k] < hardly_any * all[k]; };
    return hides(0) || hides(1);
}

ErrorPoints ErrorPointSampler::draw(std::size_t count, std::uint64_t seed) const {
    RandomStream stream(seed, "error points");
    const std::size_t shares = (count + ErrorPoints::groups - 1) / ErrorPoints::groups;
    const SurfelPoints drawn =
        draw_surfel_points(surfels_, density_, candidates_per_point * shares, ErrorPoints::groups, stream);
    const std::vector<double> chance = chances(drawn, facing_, 2.0 * surfels_.edge(), execution_);
    ErrorPoints points{choose_points(drawn, chance, shares, ErrorPoints::groups, stream), sources_.variance,
                       sources_.variance_of_fresh};
    fit_weights(points, area_);
    return points;
}

ErrorPoints fewer_points(const ErrorPoints& points, std::size_t count, RandomStream& stream) {
    const std::size_t shares = (count + ErrorPoints::groups - 1) / ErrorPoints::groups;
    const std::size_t of_group = points.size() / ErrorPoints::groups;
    if (shares >= of_group) {
        return points;
    }
    const double step = static_cast<double>(of_group) / static_cast<double>(shares);
    std::array<double, ErrorPoints::groups> next{}; // of each group, the number of the next to be chosen
    for (double& each : next) {
        each = stream.uniform() * step;
    }
    std::array<std::size_t, ErrorPoints::groups> seen{};
    ErrorPoints fewer{{}, points.variance, points.variance_of_fresh};
    for (std::size_t p = 0; p < points.size(); ++p) {
        const Index g = points.group[p];
        const auto end = static_cast<double>(++seen[g]);
        if (next[g] < end) {
            next[g] += step;
            fewer.place.push_back(points.place[p]);
            fewer.weight.push_back(points.weight[p]);
            fewer.surfel.push_back(points.surfel[p]);
            fewer.group.push_back(g);
        }
    }
    fit_weights(fewer, std::accumulate(points.weight.begin(), points.weight.end(), 0.0));
    return fewer;
}

} // namespace difusa
