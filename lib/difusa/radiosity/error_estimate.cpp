#include <difusa/radiosity/error_estimate.h>

#include <difusa/core/parallel.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace difusa {

double largest_reflectance(const Scene& scene, int channels) {
    const Mesh& mesh = scene.mesh;
    double largest = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Material& material = scene.materials[mesh.material[t]];
        const Rgb factor = material.reflectance_texture ? material.reflectance_texture->brightest() : Rgb(Rgb::Ones());
        if (material.vertex_colours) {
            for (const Rgb& rho : mesh.corner_reflectance[t]) {
                const Rgb product = factor * rho;
                largest = std::max(largest, channels == 1 ? product[0] : product.maxCoeff());
            }
        } else {
            const Rgb product = factor * material.reflectance;
            largest = std::max(largest, channels == 1 ? product[0] : product.maxCoeff());
        }
    }
    return largest;
}

ErrorEstimate estimate_error(const Field& field, std::size_t points, std::size_t rays, std::uint64_t seed,
                             const Execution& execution) {
    const Scene& scene = *field.parts().scene;
    ErrorEstimate estimate;
    estimate.points = points;
    estimate.place = even_points(scene.mesh, points, RandomStream(seed, "error points"));
    const Irradiance own = field.evaluate(estimate.place, seed, "error, own", execution);
    const Irradiance first = field.gather(estimate.place, rays, seed, "error, first", execution);
    const Irradiance second = field.gather(estimate.place, rays, seed, "error, second", execution);
    estimate.rays = first.rays + second.rays;
    estimate.segments = own.segments + first.segments + second.segments;

    const Values B = field.radiosity(estimate.place, own.direct + own.indirect);
    const Values r_1 = field.radiosity(estimate.place, first.direct + first.indirect) - B;
    const Values r_2 = field.radiosity(estimate.place, second.direct + second.indirect) - B;
    const auto n = static_cast<double>(points);
    double sum = 0.0, sum_of_squares = 0.0;
    for (Eigen::Index i = 0; i < B.rows(); ++i) {
        const double squared = r_1.row(i).dot(r_2.row(i));
        estimate.squared.push_back(squared);
        sum += squared;
        sum_of_squares += squared * squared;
        estimate.largest = std::max(estimate.largest, 0.5 * (r_1.row(i) + r_2.row(i)).norm());
    }
    estimate.reflected =
        std::sqrt((B - field.radiosity(estimate.place, Values::Zero(B.rows(), B.cols()))).squaredNorm() / n);
    const double mean = sum / n;
    const double deviation = std::sqrt(std::max(0.0, sum_of_squares / n - mean * mean) / std::max(1.0, n - 1.0));
    const auto root = [](double squared) { return std::sqrt(std::max(0.0, squared)); };
    estimate.rms = root(mean);
    estimate.low = root(mean - 1.96 * deviation);
    estimate.high = root(mean + 1.96 * deviation);
    estimate.largest_reflectance = largest_reflectance(scene, field.channels());
    estimate.factor = estimate.largest_reflectance < 1.0 ? 1.0 / (1.0 - estimate.largest_reflectance)
                                                         : std::numeric_limits<double>::infinity();
    const auto bound = [&](double residual) { return residual > 0.0 ? estimate.factor * residual : 0.0; };
    estimate.bound_rms = bound(estimate.high);
    estimate.bound_largest = bound(estimate.largest);
    return estimate;
}

Values spread_residual(const ErrorEstimate& estimate, const Basis& basis, std::span<const SurfacePoint> x,
                       const Execution& execution) {
    // Elements collect the points' squares and their weights; a place reads them back with its own weights.
    std::vector<double> squares(basis.size(), 0.0), weights(basis.size(), 0.0);
    BasisRow row;
    double mean = 0.0;
    for (std::size_t p = 0; p < estimate.place.size(); ++p) {
        basis.evaluate(estimate.place[p], row);
        mean += estimate.squared[p] / static_cast<double>(estimate.place.size());
        for (std::size_t k = 0; k < row.element.size(); ++k) {
            squares[row.element[k]] += std::abs(row.weight[k]) * estimate.squared[p];
            weights[row.element[k]] += std::abs(row.weight[k]);
        }
    }
    Values residual(static_cast<Eigen::Index>(x.size()), 1);
    parallel_for(x.size(), 1024, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow here;
        for (std::size_t i = begin; i < end; ++i) {
            basis.evaluate(x[i], here);
            double square = 0.0, weight = 0.0;
            for (std::size_t k = 0; k < here.element.size(); ++k) {
                square += std::abs(here.weight[k]) * squares[here.element[k]];
                weight += std::abs(here.weight[k]) * weights[here.element[k]];
            }
            const double local = weight > 0.0 ? square / weight : mean;
            residual(static_cast<Eigen::Index>(i), 0) = std::sqrt(std::max(0.0, local));
        }
    });
    return residual;
}

} // namespace difusa
