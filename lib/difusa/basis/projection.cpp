#include <difusa/basis/projection.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <cmath>
#include <sstream>

namespace difusa {

struct Projection::Factor {
    Eigen::SparseLU<Eigen::SparseMatrix<double>> lu;
};

namespace {

constexpr double largest_condition = 1e12;

Eigen::SparseMatrix<double> collocation(const Basis& basis, const SiteSet& sites, const Execution& execution) {
    std::vector<BasisRow> rows(sites.size());
    parallel_for(sites.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            basis.evaluate(sites.points[i], rows[i]);
        }
    });
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        for (std::size_t k = 0; k < rows[i].element.size(); ++k) {
            entries.emplace_back(static_cast<int>(i), static_cast<int>(rows[i].element[k]), rows[i].weight[k]);
        }
    }
    const auto n = static_cast<Eigen::Index>(sites.size());
    Eigen::SparseMatrix<double> Z(n, n);
    Z.setFromTriplets(entries.begin(), entries.end());
    Z.makeCompressed();
    return Z;
}

double norm_1(const Eigen::SparseMatrix<double>& Z) {
    double largest = 0.0;
    for (Eigen::Index column = 0; column < Z.outerSize(); ++column) {
        largest = std::max(largest, Z.col(column).cwiseAbs().sum());
    }
    return largest;
}

/// Hager's estimate of ‖Z⁻¹‖₁ by a few solves with Z and its transpose.
template <class LU> double inverse_norm_1(LU& lu, Eigen::Index n) {
    Eigen::VectorXd x = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n));
    double estimate = 0.0;
    for (int step = 0; step < 5; ++step) {
        const Eigen::VectorXd y = lu.solve(x);
        estimate = std::max(estimate, y.cwiseAbs().sum());
        const Eigen::VectorXd sign = y.unaryExpr([](double v) { return v < 0.0 ? -1.0 : 1.0; });
        const Eigen::VectorXd z = lu.transpose().solve(sign);
        Eigen::Index j = 0;
        if (z.cwiseAbs().maxCoeff(&j) <= z.dot(x)) {
            break;
        }
        x = Eigen::VectorXd::Unit(n, j);
    }
    return estimate;
}

} // namespace

Projection::Projection(const Basis& basis, const SiteSet& sites, const Execution& execution) {
    if (basis.coefficients_are_values()) {
        return;
    }
    const Eigen::SparseMatrix<double> Z = collocation(basis, sites, execution);
    factor_ = std::make_unique<Factor>();
    factor_->lu.compute(Z);
    const bool singular = factor_->lu.info() != Eigen::Success;
    condition_ = singular ? std::numeric_limits<double>::infinity() : norm_1(Z) * inverse_norm_1(factor_->lu, Z.rows());
    if (!(condition_ <= largest_condition)) {
        std::ostringstream message;
        message << "the elements of the basis overlap so much that their coefficients cannot be determined: condition "
                << condition_ << ", at most " << largest_condition
                << " is usable. Give the basis a smaller width, or use a partition of unity "
                   "(--basis normalized-radial or shepard)";
        throw NotConverged(message.str());
    }
}

Projection::~Projection() = default;
Projection::Projection(Projection&&) noexcept = default;
Projection& Projection::operator=(Projection&&) noexcept = default;

Values Projection::coefficients(const Values& values) const {
    if (is_identity()) {
        return values;
    }
    Values b(values.rows(), values.cols());
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
        const Eigen::VectorXd column = values.col(c);
        // Into a vector of its own: SparseLU takes its target for contiguous, which a column of row-major values is
        // not.
        const Eigen::VectorXd solution = factor_->lu.solve(column);
        b.col(c) = solution;
    }
    return b;
}

std::vector<double> Projection::quadrature(const std::vector<double>& integrals) const {
    if (is_identity()) {
        return integrals;
    }
    const Eigen::VectorXd A =
        Eigen::Map<const Eigen::VectorXd>(integrals.data(), static_cast<Eigen::Index>(integrals.size()));
    const Eigen::VectorXd w = factor_->lu.transpose().solve(A);
    return {w.data(), w.data() + w.size()};
}

} // namespace difusa
