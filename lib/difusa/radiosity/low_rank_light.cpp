#include <difusa/radiosity/low_rank_light.h>

#include <difusa/algebra/dense.h>
#include <difusa/core/memory.h>
#include <difusa/core/random.h>
#include <difusa/radiosity/reflected_transport.h>
#include <difusa/radiosity/response.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

std::vector<double> weighted_norms(const Eigen::VectorXd& weight, const Values& x) {
    DIFUSA_REQUIRE(x.rows() == weight.size());
    std::vector<double> norms;
    for (Eigen::Index c = 0; c < x.cols(); ++c) {
        norms.push_back(x.col(c).cwiseProduct(weight).norm());
    }
    return norms;
}

Eigen::MatrixXd gaussian_directions(Eigen::Index rows, Eigen::Index columns, RandomStream& stream) {
    Eigen::MatrixXd x(rows, columns);
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const double u = 1.0 - stream.uniform(); // (0, 1]
        x.data()[i] = std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * stream.uniform());
    }
    return x;
}

/// One matrix for each channel.
using ByChannel = std::vector<Eigen::MatrixXd>;

/// diag(points) L diag(1 / surfels) for all channels at once: its Euclidean norm is that of L in the norms of the area.
class WeightedLaterLight {
  public:
    WeightedLaterLight(const RadiositySystem& system, const Values& reflectance, const AreaNorms& norms,
                       const LowRankOptions& options, const Execution& execution)
        : system_(system), reflectance_(reflectance), norms_(norms), options_(options), execution_(execution),
          T_(system.discretisation(), system.transport(), reflectance) {}

    ByChannel times(const ByChannel& x) const {
        Values y;
        system_.transport().gather(together(x, norms_.surfels().cwiseInverse()), {}, y, execution_.silent());
        for (int k = 0; k < options_.bounces; ++k) {
            Values next;
            T_.apply(y, next, execution_);
            y.swap(next);
        }
        return apart(solve_for(system_, reflectance_, y, options_.solve, execution_.silent()), norms_.points());
    }

    ByChannel transposed_times(const ByChannel& x) const {
        Values y = solve_transpose_for(system_, reflectance_, together(x, norms_.points()), options_.solve,
                                       execution_.silent());
        for (int k = 0; k < options_.bounces; ++k) {
            Values next;
            T_.apply_transpose(y, next, execution_);
            y.swap(next);
        }
        Values bins;
        system_.transport().W->apply_transpose(y, bins, execution_.silent());
        return apart(bins.topRows(norms_.surfels().size()), norms_.surfels().cwiseInverse());
    }

  private:
    /// The channels of each column in turn.
    static Values together(const ByChannel& x, const Eigen::VectorXd& weight) {
        const auto channels = static_cast<Eigen::Index>(x.size());
        Values all(x[0].rows(), x[0].cols() * channels);
        for (Eigen::Index c = 0; c < channels; ++c) {
            for (Eigen::Index k = 0; k < x[0].cols(); ++k) {
                all.col(k * channels + c) = x[static_cast<std::size_t>(c)].col(k).cwiseProduct(weight);
            }
        }
        return all;
    }
    ByChannel apart(const Values& all, const Eigen::VectorXd& weight) const {
        const Eigen::Index channels = reflectance_.cols();
        ByChannel x(static_cast<std::size_t>(channels), Eigen::MatrixXd(all.rows(), all.cols() / channels));
        for (Eigen::Index k = 0; k < all.cols(); ++k) {
            x[static_cast<std::size_t>(k % channels)].col(k / channels) = all.col(k).cwiseProduct(weight);
        }
        return x;
    }

    const RadiositySystem& system_;
    const Values& reflectance_;
    const AreaNorms& norms_;
    const LowRankOptions& options_;
    const Execution& execution_;
    ReflectedTransport T_;
};

/// An upper bound of the norm of L - U Vᵀ for each channel. U, V: weighted.
std::vector<double> norm_bounds(const WeightedLaterLight& L, const ByChannel& U, const ByChannel& V,
                                std::uint64_t seed) {
    constexpr Eigen::Index vectors = 10;
    constexpr double a = 4.0; // a^-vectors = low_rank_risk
    constexpr int products = 5;
    ByChannel x;
    for (std::size_t c = 0; c < U.size(); ++c) {
        RandomStream stream(seed, "norm of what is left out", c);
        x.push_back(gaussian_directions(V[c].rows(), vectors, stream));
    }
    for (int k = 0; k < products; ++k) {
        const ByChannel &to = k % 2 == 0 ? U : V, &from = k % 2 == 0 ? V : U;
        ByChannel y = k % 2 == 0 ? L.times(x) : L.transposed_times(x);
        for (std::size_t c = 0; c < U.size(); ++c) {
            const Eigen::MatrixXd inner = from[c].transpose() * x[c];
            y[c].noalias() -= to[c] * inner;
        }
        x = std::move(y);
    }
    std::vector<double> bounds;
    for (const Eigen::MatrixXd& each : x) {
        const double largest = each.colwise().norm().maxCoeff();
        bounds.push_back(std::pow(a * std::sqrt(2.0 / std::numbers::pi) * largest, 1.0 / products));
    }
    return bounds;
}

} // namespace

AreaNorms::AreaNorms(const Discretisation& discretisation) {
    const SiteSet& sites = *discretisation.sites;
    const Surfels& surfels = *discretisation.surfels;
    points_.setOnes(static_cast<Eigen::Index>(discretisation.points.size()));
    if (discretisation.points.size() == sites.size()) {
        const double mean =
            std::accumulate(sites.area.begin(), sites.area.end(), 0.0) / static_cast<double>(sites.size());
        for (std::size_t i = 0; i < sites.size(); ++i) { // elements of some bases may have no area of their own
            points_[static_cast<Eigen::Index>(i)] = sites.area[i] > 1e-3 * mean ? sites.area[i] : mean;
        }
    }
    points_ = (points_ / points_.sum()).cwiseSqrt().eval();
    surfels_.resize(static_cast<Eigen::Index>(surfels.size()));
    double least = 0.0; // of no area at all, none would be left to divide by
    for (Index s = 0; s < surfels.size(); ++s) {
        surfels_[static_cast<Eigen::Index>(s)] = surfels.area(s);
        least += 1e-12 * surfels.area(s) / static_cast<double>(surfels.size());
    }
    surfels_ = surfels_.cwiseMax(least);
    surfels_ = (surfels_ / surfels_.sum()).cwiseSqrt().eval();
}

std::vector<double> AreaNorms::of_points(const Values& h) const {
    return weighted_norms(points_, h);
}

std::vector<double> AreaNorms::of_surfels(const Values& b) const {
    return weighted_norms(surfels_, b);
}

std::vector<LowRankLight> low_rank_light(const RadiositySystem& system, const Values& reflectance,
                                         const LowRankOptions& options, const Execution& execution) {
    const std::size_t tried = options.rank + options.more, points = system.transport().points();
    if (options.rank == 0 || tried > points) {
        throw UsageError("an operator of rank " + std::to_string(options.rank) + ", with " +
                         std::to_string(options.more) + " directions more to find it, needs at least that many of " +
                         "the " + std::to_string(points) + " points: choose a lower rank, or dense");
    }
    const double columns = static_cast<double>(tried) * static_cast<double>(reflectance.cols());
    constexpr double copies = 6.0;
    require_memory(copies * sizeof(double) * columns *
                       (static_cast<double>(points) + static_cast<double>(system.transport().surfels)),
                   execution.memory_left(), "the operator of low rank", "choose a lower rank, or give fewer --sites");
    const AreaNorms norms(system.discretisation());
    const WeightedLaterLight L(system, reflectance, norms, options, execution);
    ByChannel x;
    for (Eigen::Index c = 0; c < reflectance.cols(); ++c) {
        RandomStream stream(options.seed, "directions of low rank", static_cast<std::uint64_t>(c));
        x.push_back(gaussian_directions(norms.surfels().size(), static_cast<Eigen::Index>(tried), stream));
    }
    x = L.times(x);
    for (Eigen::MatrixXd& each : x) {
        each = orthonormal_basis(each);
    }
    const ByChannel across = L.transposed_times(x); // L ≈ Q (Lᵀ Q)ᵀ, decomposed
    const auto rank = static_cast<Eigen::Index>(options.rank);
    ByChannel U, V;
    std::vector<LowRankLight> result;
    for (std::size_t c = 0; c < x.size(); ++c) {
        const Eigen::MatrixXd Q2 = orthonormal_basis(across[c]);
        const SingularValues svd = singular_values(across[c].transpose() * Q2);
        const Eigen::VectorXd sigma = svd.sigma.head(rank), root = sigma.cwiseSqrt();
        U.emplace_back(x[c] * (svd.U.leftCols(rank) * root.asDiagonal()));
        V.emplace_back(Q2 * (svd.V.leftCols(rank) * root.asDiagonal()));
        result.emplace_back();
        result.back().singular_values.assign(sigma.data(), sigma.data() + rank);
        result.back().U = norms.points().cwiseInverse().asDiagonal() * U.back();
        result.back().V = norms.surfels().asDiagonal() * V.back();
    }
    const std::vector<double> bounds = norm_bounds(L, U, V, options.seed);
    for (std::size_t c = 0; c < result.size(); ++c) {
        result[c].error = bounds[c];
    }
    return result;
}

} // namespace difusa
