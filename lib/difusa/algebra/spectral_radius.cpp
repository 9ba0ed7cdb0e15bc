#include <difusa/algebra/spectral_radius.h>

#include <difusa/algebra/dense.h>
#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/error.h>
#include <difusa/core/random.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace difusa {

namespace {

constexpr Eigen::Index agreeing = 3; ///< further steps that must confirm an estimate
constexpr double noise = 0.5;        ///< of the start, beside a constant
constexpr double near_one = 1e-3;    ///< of a radius for which it matters on which side of 1 it is

/// From one vector.
double radius_from(const Eigen::VectorXd& start, const LinearOperator& T, int steps, double tolerance,
                   const Execution& execution) {
    const Eigen::Index m = std::min<Eigen::Index>(steps, start.size());
    std::vector<Eigen::VectorXd> V{start.normalized()};
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m + 1, m);
    Eigen::Index agreed = 0;
    double radius = 0.0;
    for (Eigen::Index k = 0; k < m; ++k) {
        execution.check();
        Values y;
        T.apply(V.back(), y, execution);
        Eigen::VectorXd w = y.col(0);
        const double before = norm(w, execution);
        H.col(k).head(k + 1) = orthogonalise(V, w, execution);
        H(k + 1, k) = norm(w, execution);
        const double previous = radius;
        radius = largest_eigenvalue(H.topLeftCorner(k + 1, k + 1));
        agreed = std::abs(radius - previous) <= tolerance * radius ? agreed + 1 : 0;
        if (agreed == agreeing) {
            break;
        }
        if (H(k + 1, k) <= 1e-14 * before) {
            break; // the space is invariant: its eigenvalues are exact
        }
        V.emplace_back(w / H(k + 1, k));
    }
    return radius;
}

} // namespace

double spectral_radius(const LinearOperator& T, int steps, double tolerance, const Execution& execution) {
    DIFUSA_REQUIRE(T.rows() == T.columns());
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(T.rows()));
    Eigen::VectorXd start = ones;
    RandomStream random(0, "spectral radius");
    for (double& each : start) {
        each += noise * (2.0 * random.uniform() - 1.0);
    }
    const double radius = radius_from(start, T, steps, tolerance, execution);
    if (std::abs(radius - 1.0) > near_one) {
        return radius;
    }
    return std::max(radius, radius_from(ones, T, steps, tolerance, execution));
}

} // namespace difusa
