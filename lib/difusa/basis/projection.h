// From the values of a function at the sites to its coefficients in a basis (T 3.2).
#pragma once

#include <difusa/basis/basis.h>
#include <difusa/core/types.h>

#include <memory>
#include <vector>

namespace difusa {

/// Coefficients b of values y: b = y where the basis says so, else the solution of Z b = y with Z_ij = phi_j(p_i)
/// (T 3.2, 3.3), factorised once.
class Projection {
  public:
    /// Throws NotConverged, naming the condition number and the remedy, if Z is singular or so ill-conditioned
    /// (above 1e12) that coefficients would be noise.
    Projection(const Basis& basis, const SiteSet& sites, const Execution& execution);
    ~Projection();
    Projection(Projection&&) noexcept;
    Projection& operator=(Projection&&) noexcept;

    bool is_identity() const { return factor_ == nullptr; }

    /// values, coefficients: #S by #channels.
    Values coefficients(const Values& values) const;

    /// Weights w with sum_j w_j f(p_j) = ∫ (the function of the basis with the values f at the sites) dA, from the
    /// integrals A_i = ∫ phi_i dA: w = A, or the solution of Zᵀ w = A.
    std::vector<double> quadrature(const std::vector<double>& integrals) const;

    /// Estimate of ‖Z‖₁ ‖Z⁻¹‖₁ (Hager 1984), a lower bound; 1 for the identity.
    double condition() const { return condition_; }

  private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
    double condition_ = 1.0;
};

} // namespace difusa
