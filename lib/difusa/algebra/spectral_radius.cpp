#include <difusa/algebra/spectral_radius.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <vector>

namespace difusa {

double spectral_radius(const LinearOperator& K, const Values& rho, int steps, const Execution& execution) {
    const auto n = static_cast<Eigen::Index>(K.size());
    const auto m = std::min<Eigen::Index>(steps, n);
    double largest = 0.0;
    for (Eigen::Index c = 0; c < rho.cols(); ++c) {
        if (c > 0 && rho.col(c) == rho.col(0)) {
            continue;
        }
        std::vector<Eigen::VectorXd> V{Eigen::VectorXd::Ones(n).normalized()};
        Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m + 1, m);
        Eigen::Index size = 0;
        for (Eigen::Index k = 0; k < m; ++k) {
            const Values x = rho.col(c).cwiseProduct(V.back());
            Values y;
            K.apply(x, y, execution);
            Eigen::VectorXd w = y.col(0);
            const double before = w.norm();
            for (int pass = 0; pass < 2; ++pass) { // twice is enough
                for (Eigen::Index i = 0; i <= k; ++i) {
                    const double overlap = V[static_cast<std::size_t>(i)].dot(w);
                    H(i, k) += overlap;
                    w -= overlap * V[static_cast<std::size_t>(i)];
                }
            }
            size = k + 1;
            H(k + 1, k) = w.norm();
            if (H(k + 1, k) <= 1e-14 * before) {
                break; // the space is invariant: its eigenvalues are exact
            }
            V.push_back(w / H(k + 1, k));
        }
        const Eigen::VectorXcd values = H.topLeftCorner(size, size).eigenvalues();
        largest = std::max(largest, values.cwiseAbs().maxCoeff());
    }
    return largest;
}

} // namespace difusa
