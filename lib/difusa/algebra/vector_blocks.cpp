#include <difusa/algebra/vector_blocks.h>

#include <cmath>

namespace difusa {

namespace {

/// Sums of squares below this one may be made of squares that underflow.
constexpr double least_square = 0x1p-900;

} // namespace

double norm(const Eigen::VectorXd& x, const Execution& execution) {
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(block_count(x.size()));
    for_blocks(x.size(), execution, [&](Eigen::Index first, Eigen::Index count, Eigen::Index block) {
        squares[block] = x.segment(first, count).squaredNorm();
    });
    const double sum = squares.sum();
    if (sum >= least_square && std::isfinite(sum)) {
        return std::sqrt(sum);
    }
    const double largest = x.size() > 0 ? x.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() : 0.0;
    if (!(largest > 0.0) || !std::isfinite(largest)) {
        return std::sqrt(sum);
    }
    // Scaled by a power of two.
    const int exponent = std::ilogb(largest);
    const Eigen::VectorXd scaled = x.unaryExpr([exponent](double each) { return std::scalbn(each, -exponent); });
    return std::scalbn(norm(scaled, execution), exponent);
}

Eigen::VectorXd orthogonalise(std::span<const Eigen::VectorXd> V, Eigen::VectorXd& w, const Execution& execution) {
    const auto size = static_cast<Eigen::Index>(V.size());
    Eigen::VectorXd total = Eigen::VectorXd::Zero(size);
    Eigen::MatrixXd dots(size, block_count(w.size()));
    for (int pass = 0; pass < 2; ++pass) {
        for_blocks(w.size(), execution, [&](Eigen::Index first, Eigen::Index count, Eigen::Index block) {
            for (Eigen::Index i = 0; i < size; ++i) {
                dots(i, block) = V[static_cast<std::size_t>(i)].segment(first, count).dot(w.segment(first, count));
            }
        });
        const Eigen::VectorXd overlap = dots.rowwise().sum();
        for_blocks(w.size(), execution, [&](Eigen::Index first, Eigen::Index count, Eigen::Index) {
            for (Eigen::Index i = 0; i < size; ++i) {
                w.segment(first, count) -= overlap[i] * V[static_cast<std::size_t>(i)].segment(first, count);
            }
        });
        total += overlap;
    }
    return total;
}

} // namespace difusa
