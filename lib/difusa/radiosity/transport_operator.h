// The operator of the radiosity equation at the sites: K = S P, values to coefficients to irradiance.
#pragma once

#include <difusa/algebra/solver.h>
#include <difusa/algebra/sparse_rows.h>
#include <difusa/discretisation/projection.h>

namespace difusa {

/// (K x)_j: the irradiance at site j if the surface sends radiosity with the values x at the sites.
class TransportOperator final : public LinearOperator {
  public:
    /// Keeps references.
    TransportOperator(const SparseRows& S, const Projection& P) : S_(S), P_(P) {}
    std::size_t size() const override { return S_.rows(); }
    void apply(const Values& x, Values& y, const Execution& execution) const override {
        if (P_.is_identity()) {
            S_.multiply(x, y, execution);
        } else {
            S_.multiply(P_.coefficients(x), y, execution);
        }
    }

  private:
    const SparseRows& S_;
    const Projection& P_;
};

} // namespace difusa
