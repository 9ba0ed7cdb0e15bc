#include <difusa/radiosity/error_points.h>

#include <difusa/algebra/hit_lists.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/scene/sky_parts.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

namespace difusa {

namespace {

constexpr double rounding = 1e-12; ///< of a variance, relative to the square of the mean

/// ErrorPoints::variance. `irradiance`: of the surfels, #surfels by #channels, according to the coefficients of all
/// sets together.
Values variance_of_rays(const Solution& solution, const Values& irradiance, const Execution& execution) {
    const FieldParts& parts = solution.field->parts();
    const RadiositySystem& system = *parts.system;
    const SurfelLight& light = solution.light;
    if (dynamic_cast<const HitLists*>(system.transport().W.get()) == nullptr) {
        return Values::Zero(static_cast<Eigen::Index>(system.transport().points()), parts.channels);
    }
    Values b = irradiance;
    if (!parts.direct_in_basis) {
        b += sum_of_parts(light.direct, parts.channels);
    }
    b = sum_of_parts(light.emission, parts.channels) + light.reflectance.cwiseProduct(b);
    const Values sky = parts.scene->has_sky() ? sky_radiosity(*parts.scene, parts.channels) : Values();
    Values mean, square;
    system.transport().gather(b, sky, mean, execution);
    system.transport().gather(b.cwiseAbs2(), sky.cwiseAbs2(), square, execution);
    return (square - mean.cwiseAbs2()).cwiseMax(0.0);
}

/// The mixture's integral over each surfel; they sum to 1, or all are 0 if nothing reflects. `variance` receives
/// ErrorPoints::variance.
std::vector<double> density_of(const Solution& solution, Values& variance, const Execution& execution) {
    const FieldParts& field = solution.field->parts();
    const Surfels& surfels = *field.system->discretisation().surfels;
    const BasisAverages& P = *field.system->discretisation().averages;
    const Values& rho = solution.light.reflectance;
    const Values c = sum_of_parts(field.smooth, field.channels);
    Values mean, square, noise;
    P.apply(c, mean, execution);
    P.apply(c.cwiseAbs2(), square, execution);
    variance = variance_of_rays(solution, mean, execution);
    P.apply(variance.topRows(c.rows()), noise, execution);
    std::array<std::vector<double>, 3> parts;
    parts.fill(std::vector<double>(surfels.size()));
    std::vector<double> brightness(surfels.size()); // by which variances that are rounding errors are told from others
    parallel_for(surfels.size(), 4096, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t s = begin; s < end; ++s) {
            const auto row = static_cast<Eigen::Index>(s);
            const Eigen::RowVectorXd rho_2 = rho.row(row).cwiseAbs2() * surfels.area(static_cast<Index>(s));
            const Eigen::RowVectorXd mean_2 = mean.row(row).cwiseAbs2();
            parts[0][s] = rho_2.sum();
            parts[1][s] = rho_2.dot((square.row(row) - mean_2).cwiseMax(0.0));
            parts[2][s] = rho_2.dot(noise.row(row).cwiseMax(0.0));
            brightness[s] = rho_2.dot(mean_2);
        }
    });
    const double least = rounding * std::accumulate(brightness.begin(), brightness.end(), 0.0);
    std::array<double, 3> factor{};
    double present = 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const double sum = std::accumulate(parts[k].begin(), parts[k].end(), 0.0);
        factor[k] = sum > (k == 0 ? 0.0 : least) ? 1.0 / sum : 0.0;
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

/// Of each share of [0, 1) one number for each group, in ascending order, with the groups.
std::vector<std::pair<double, Index>> places_in_shares(std::size_t shares, RandomStream& stream) {
    std::vector<std::pair<double, Index>> places;
    for (std::size_t share = 0; share < shares; ++share) {
        for (Index g = 0; g < ErrorPoints::groups; ++g) {
            places.emplace_back((static_cast<double>(share) + stream.uniform()) / static_cast<double>(shares), g);
        }
    }
    std::sort(places.begin(), places.end());
    return places;
}

} // namespace

ErrorPoints draw_error_points(const Solution& solution, std::size_t count, std::uint64_t seed,
                              const Execution& execution) {
    const Surfels& surfels = *solution.field->parts().system->discretisation().surfels;
    ErrorPoints points;
    const std::vector<double> density = density_of(solution, points.variance, execution);
    const double all = std::accumulate(density.begin(), density.end(), 0.0); // 1 up to rounding
    if (!(all > 0.0)) {
        return points;
    }
    RandomStream stream(seed, "error points");
    const std::vector<std::pair<double, Index>> places =
        places_in_shares((count + ErrorPoints::groups - 1) / ErrorPoints::groups, stream);
    std::vector<Surfels::Piece> pieces;
    double below = 0.0, area = 0.0, weights = 0.0;
    for (Index s = 0; s < surfels.size(); ++s) {
        if (!(density[s] > 0.0)) {
            continue;
        }
        below += density[s];
        area += surfels.area(s);
        bool known = false;
        while (points.size() < places.size() && places[points.size()].first * all < below) {
            if (!known) {
                surfels.pieces(s, pieces);
                known = true;
            }
            points.group.push_back(places[points.size()].second);
            const double u = stream.uniform(), v = stream.uniform();
            points.place.push_back(surfels.point_on(pieces, u, v));
            points.surfel.push_back(s);
            points.weight.push_back(surfels.area(s) / (density[s] * static_cast<double>(places.size())));
            weights += points.weight.back();
        }
    }
    DIFUSA_REQUIRE(points.size() == places.size());
    for (double& weight : points.weight) {
        weight *= area / weights; // so that constants are integrated exactly
    }
    return points;
}

} // namespace difusa
