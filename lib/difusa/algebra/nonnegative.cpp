#include <difusa/algebra/nonnegative.h>

#include <difusa/algebra/dense.h>
#include <difusa/core/error.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace difusa {

namespace {

/// The least-squares solution in which only these unknowns are not 0.
Eigen::VectorXd unconstrained(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                              const std::vector<Eigen::Index>& free) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(A.cols());
    const Eigen::MatrixXd columns = A(Eigen::all, free);
    const Eigen::VectorXd values = least_squares(columns, b);
    x(free) = values;
    return x;
}

} // namespace

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
    DIFUSA_REQUIRE(A.rows() == b.size());
    Eigen::VectorXd x = Eigen::VectorXd::Zero(A.cols());
    std::vector<Eigen::Index> free;
    std::vector<char> refused(static_cast<std::size_t>(A.cols()), 0);
    const double rounding = 64.0 * std::numeric_limits<double>::epsilon();
    for (Eigen::Index exchanges = 0;; ++exchanges) {
        if (exchanges > 30 * (A.cols() + 1)) {
            throw NotConverged("non-negative least squares went round in circles: the problem is too badly scaled");
        }
        // The unknown at 0 whose increase pays most.
        const Eigen::VectorXd residual = b - A * x;
        Eigen::Index best = -1;
        double most = 0.0;
        for (Eigen::Index k = 0; k < A.cols(); ++k) {
            const double norm = A.col(k).norm();
            const double gain = norm > 0.0 ? A.col(k).dot(residual) / norm : 0.0;
            const bool bound = std::find(free.begin(), free.end(), k) == free.end();
            if (bound && refused[static_cast<std::size_t>(k)] == 0 && gain > rounding * b.norm() && gain > most) {
                best = k;
                most = gain;
            }
        }
        if (best < 0) {
            return x;
        }
        free.push_back(best);
        Eigen::VectorXd next = unconstrained(A, b, free);
        if (!(next[best] > 0.0)) { // its gain was rounding
            free.pop_back();
            refused[static_cast<std::size_t>(best)] = 1;
            continue;
        }
        std::fill(refused.begin(), refused.end(), 0);
        while (std::any_of(free.begin(), free.end(), [&](Eigen::Index k) { return !(next[k] > 0.0); })) {
            double step = 1.0;
            for (const Eigen::Index k : free) {
                step = next[k] > 0.0 ? step : std::min(step, x[k] / (x[k] - next[k]));
            }
            x += step * (next - x);
            const double zero = rounding * std::max(1e-300, x.cwiseAbs().maxCoeff());
            free.erase(std::remove_if(free.begin(), free.end(),
                                      [&](Eigen::Index k) {
                                          const bool ends = !(x[k] > zero) && !(next[k] > 0.0);
                                          x[k] = ends ? 0.0 : x[k];
                                          return ends;
                                      }),
                       free.end());
            next = free.empty() ? Eigen::VectorXd(Eigen::VectorXd::Zero(A.cols())) : unconstrained(A, b, free);
        }
        x = next;
    }
}

} // namespace difusa
