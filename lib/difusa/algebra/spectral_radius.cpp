#include <difusa/algebra/spectral_radius.h>

#include <difusa/algebra/dense.h>
#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace difusa {

namespace {

constexpr Eigen::Index agreeing = 3; ///< further steps that must confirm an estimate

} // namespace

double spectral_radius(const LinearOperator& T, int steps, double tolerance, const Execution& execution) {
    DIFUSA_REQUIRE(T.rows() == T.columns());
    const auto n = static_cast<Eigen::Index>(T.rows());
    const auto m = std::min<Eigen::Index>(steps, n);
    std::vector<Eigen::VectorXd> V{Eigen::VectorXd::Ones(n).normalized()};
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

} // namespace difusa
