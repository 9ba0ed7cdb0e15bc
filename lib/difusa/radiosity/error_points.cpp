#include <difusa/radiosity/error_points.h>

#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/scene/sky_parts.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace difusa {

namespace {

/// The light of the total: on the surfels according to the coefficients, and its variance over the rays of each site.
struct Light {
    Values mean, square, noise;
};

Light light_of(const Solution& solution, const Execution& execution) {
    const FieldParts& parts = solution.field->parts();
    const BasisAverages& P = *parts.system->discretisation().averages;
    const Values c = sum_of_parts(parts.smooth, parts.channels);
    Light light;
    P.apply(c, light.mean, execution);
    P.apply(c.cwiseAbs2(), light.square, execution);
    P.apply(variance_of_rays(solution, light.mean, execution), light.noise, execution);
    return light;
}

} // namespace

Values variance_of_rays(const Solution& solution, const Values& irradiance, const Execution& execution) {
    const FieldParts& parts = solution.field->parts();
    const RadiositySystem& system = *parts.system;
    const SurfelLight& light = solution.light;
    Values b = irradiance;
    if (!parts.direct_in_basis) {
        b += sum_of_parts(light.direct, parts.channels);
    }
    b = sum_of_parts(light.emission, parts.channels) + light.reflectance.cwiseProduct(b);
    const Values sky = parts.scene->has_sky() ? sky_radiosity(*parts.scene, parts.channels) : Values();
    Values mean, square;
    system.transport().gather(b, sky, mean, execution);
    system.transport().gather(b.cwiseAbs2(), sky.cwiseAbs2(), square, execution);
    const auto sites = static_cast<Eigen::Index>(system.discretisation().sites->size());
    return (square - mean.cwiseAbs2()).topRows(sites).cwiseMax(0.0);
}

ErrorPoints draw_error_points(const Solution& solution, std::size_t count, std::uint64_t seed,
                              const Execution& execution) {
    const FieldParts& parts = solution.field->parts();
    const Surfels& surfels = *parts.system->discretisation().surfels;
    const Values& rho = solution.light.reflectance;
    const Light light = light_of(solution, execution);
    // Densities, to be mixed in equal parts.
    std::array<std::vector<double>, 3> density;
    density.fill(std::vector<double>(surfels.size()));
    parallel_for(surfels.size(), 4096, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t s = begin; s < end; ++s) {
            const auto row = static_cast<Eigen::Index>(s);
            const Eigen::RowVectorXd rho_2 = rho.row(row).cwiseAbs2() * surfels.area(static_cast<Index>(s));
            density[0][s] = rho_2.sum();
            density[1][s] = rho_2.dot((light.square.row(row) - light.mean.row(row).cwiseAbs2()).cwiseMax(0.0));
            density[2][s] = rho_2.dot(light.noise.row(row).cwiseMax(0.0));
        }
    });
    std::array<double, 3> part{};
    double parts_present = 0.0;
    for (std::size_t k = 0; k < density.size(); ++k) {
        part[k] = std::accumulate(density[k].begin(), density[k].end(), 0.0);
        parts_present += part[k] > 0.0 ? 1.0 : 0.0;
    }
    ErrorPoints points;
    if (!(part[0] > 0.0)) {
        return points;
    }
    for (double& sum : part) {
        sum = sum > 0.0 ? 1.0 / (sum * parts_present) : 0.0;
    }
    RandomStream stream(seed, "error points");
    double reflecting = 0.0, all_weights = 0.0; // areas
    std::vector<Surfels::Piece> pieces;
    double below = 0.0; // the density's integral over the surfels up to the current one
    double wanted = stream.uniform() / static_cast<double>(count);
    for (Index s = 0; s < surfels.size(); ++s) {
        double own = 0.0;
        for (std::size_t k = 0; k < density.size(); ++k) {
            own += part[k] * density[k][s];
        }
        below += own;
        reflecting += own > 0.0 ? surfels.area(s) : 0.0;
        bool known = false;
        while (points.size() < count && own > 0.0 && wanted < below) {
            if (!known) {
                surfels.pieces(s, pieces);
                known = true;
            }
            const double u = stream.uniform(), v = stream.uniform();
            points.place.push_back(surfels.point_on(pieces, u, v));
            points.weight.push_back(surfels.area(s) / (own * static_cast<double>(count)));
            points.surfel.push_back(s);
            all_weights += points.weight.back();
            wanted = (static_cast<double>(points.size()) + stream.uniform()) / static_cast<double>(count);
        }
    }
    for (double& weight : points.weight) {
        weight *= reflecting / all_weights; // so that constants are integrated exactly
    }
    return points;
}

} // namespace difusa
