// A small dense matrix as a linear operator, for tests of solvers.
#pragma once

#include <difusa/algebra/solver.h>
#include <difusa/core/random.h>

#include <Eigen/Core>

#include <memory>
#include <utility>

namespace difusa::test {

/// K diag(rho) with a reflectance rho for each of `channels` columns, which take turns over the columns of an operand;
/// or K itself.
class DenseOperator final : public LinearOperator {
  public:
    explicit DenseOperator(Eigen::MatrixXd K) : K_(std::move(K)), rho_(Values::Ones(K_.cols(), 1)) {}
    DenseOperator(Eigen::MatrixXd K, Values rho) : K_(std::move(K)), rho_(std::move(rho)) {}
    std::size_t rows() const override { return static_cast<std::size_t>(K_.rows()); }
    std::size_t columns() const override { return static_cast<std::size_t>(K_.cols()); }
    void apply(const Values& x, Values& y, const Execution& /*execution*/) const override {
        ++applications;
        y = K_ * reflected(x);
    }
    void apply_transpose(const Values& x, Values& y, const Execution& /*execution*/) const override {
        y = reflected(K_.transpose() * x);
    }
    Eigen::Index column_period() const override { return rho_.cols(); }
    std::size_t entry_count() const override { return static_cast<std::size_t>(K_.size()); }

    /// A = K, Q = diag(rho); each unknown stands for an area of 1.
    std::shared_ptr<const Factors> factors(const Execution& execution) const override;
    const Eigen::MatrixXd& matrix() const { return K_; }
    const Values& rho() const { return rho_; }

    mutable int applications = 0;

  private:
    Values reflected(Values x) const {
        for (Eigen::Index c = 0; c < x.cols(); ++c) {
            x.col(c) = x.col(c).cwiseProduct(rho_.col(c % rho_.cols()));
        }
        return x;
    }
    Eigen::MatrixXd K_;
    Values rho_;
};

/// Entries uniform in [0,1), with the share `density` of them not zero.
Eigen::MatrixXd random_nonnegative(Eigen::Index n, double density, RandomStream& random);

} // namespace difusa::test
