// A small dense matrix as a linear operator, for tests of solvers.
#pragma once

#include <difusa/algebra/solver.h>
#include <difusa/core/random.h>

#include <Eigen/Core>

#include <utility>

namespace difusa::test {

class DenseOperator final : public LinearOperator {
  public:
    explicit DenseOperator(Eigen::MatrixXd K) : K_(std::move(K)) {}
    std::size_t rows() const override { return static_cast<std::size_t>(K_.rows()); }
    std::size_t columns() const override { return static_cast<std::size_t>(K_.cols()); }
    void apply(const Values& x, Values& y, const Execution& /*execution*/) const override {
        ++applications;
        y = K_ * x;
    }
    void apply_transpose(const Values& x, Values& y, const Execution& /*execution*/) const override {
        y = K_.transpose() * x;
    }
    const Eigen::MatrixXd& matrix() const { return K_; }

    mutable int applications = 0;

  private:
    Eigen::MatrixXd K_;
};

/// Entries uniform in [0,1), with the share `density` of them not zero.
Eigen::MatrixXd random_nonnegative(Eigen::Index n, double density, RandomStream& random);

/// From all eigenvalues of K.
double exact_spectral_radius(const Eigen::MatrixXd& K);

} // namespace difusa::test
