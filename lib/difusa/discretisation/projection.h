// From the values of a function at points to its coefficients in a basis (T 3.2).
#pragma once

#include <difusa/algebra/sparse_rows.h>
#include <difusa/core/types.h>
#include <difusa/discretisation/basis.h>
#include <difusa/plugin/choice.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace difusa {

/// Which coefficients stand for a function of which values are known. Z_qi = phi_i(x_q) is the collocation matrix.
enum class ProjectionKind {
    natural, ///< what the basis says: b = values for interpolating and quasi-interpolating bases, else Z b = values
    interpolation, ///< Z b = values at the sites (T 3.2, 3.3)
    corrected,     ///< b = sum_{k=0..sweeps} (I - Z)^k values: residual correction of a quasi-interpolant
    least_squares, ///< ZᵀZ b = Zᵀ values, values at the sites and at further points (T 3.2.3)
    substructured, ///< in the equation, the mean of the values over the patch that an element is part of, weighted by
                   ///< their areas (Basis::substructure, L 31); in the field, the values
    galerkin ///< ZᵀWZ b = ZᵀW values: the projection in L2 (T 3.2.6), inner products by quadrature at the same
             ///< points, weights W, so that functions of the basis are reproduced exactly
};

struct ProjectionChoice {
    ProjectionKind kind = ProjectionKind::natural;
    int sweeps = 2;           ///< of `corrected`
    bool in_equation = false; ///< of `corrected`: the equation is solved with these coefficients, too; else only the
                              ///< field is evaluated with them, and the equation has those that are sure to converge
    double points = 3.0;      ///< of least_squares and galerkin: points for each element
};

/// "natural", "corrected:sweeps=3", "least-squares:points=3", ... Throws UsageError. `text` receives the choice with
/// all parameters.
ProjectionChoice parse_projection(std::string_view choice, std::string& text);

/// The same for a basis; empty: `corrected` where it is a quasi-interpolant that does not interpolate, `substructured`
/// if its patches are to be subdivided, else `natural`. Throws UsageError for `corrected` where there is no residual to
/// put back, and for `substructured` where nothing is to be subdivided.
ProjectionChoice projection_for(const Basis& basis, std::string_view choice, std::string& text,
                                bool subdivided = false);

/// Whether each coefficient follows from a few values nearby; else all do from all, by the solution of a system.
bool is_local(const ProjectionChoice& choice, const Basis& basis);

/// The points whose values `choice` projects: the sites, first, and for least_squares and galerkin
/// (points - 1) #S more, spread evenly over the surface.
std::vector<SurfacePoint> projection_points(const ProjectionChoice& choice, const Mesh& mesh, const SiteSet& sites,
                                            std::uint64_t seed);

/// Coefficients whose field has hardly a bump or dip that the values do not have: each is kept within the range of the
/// values at the sites whose elements live at its own, or a quarter of that range above or below, which the values at
/// an edge need to go on as they come; and not below 0 where no value is, unless values may have `any_sign`. With a
/// partition of unity the field is then 0
/// where no value around differs from 0, and, if no weight is negative either, keeps to the same limits.
Values limited(const Basis& basis, const SiteSet& sites, const Values& values, Values coefficients,
               const Execution& execution, bool any_sign = false);

/// `limited` for the sum of several parts, so that the parts add up to it: `values` and `coefficients` have `channels`
/// columns for each part. What the limits take from or give to a coefficient of the sum is shared by the parts in
/// proportion to their values there, so that a part which is dark at a site stays so.
Values limited_parts(const Basis& basis, const SiteSet& sites, const Values& values, Values coefficients, int channels,
                     const Execution& execution, bool any_sign = false);

/// The sum of the parts: `channels` columns.
Values sum_of_parts(const Values& values, int channels);

class Projection {
  public:
    /// `points` are those of `projection_points`; `integrals` are the A_i = ∫ phi_i dA, from which the weights of
    /// galerkin derive: each site's area is shared by the points that are nearest to it.
    /// Throws NotConverged, naming the condition number and the remedy, if the matrix is singular or so ill-conditioned
    /// (above 1e12) that coefficients would be noise.
    Projection(const Basis& basis, const SiteSet& sites, const ProjectionChoice& choice,
               std::span<const SurfacePoint> points, const std::vector<double>& integrals, const Execution& execution);

    /// The natural projection of the values at the sites.
    Projection(const Basis& basis, const SiteSet& sites, const Execution& execution)
        : Projection(basis, sites, {}, sites.points, {}, execution) {}
    ~Projection();
    Projection(Projection&&) noexcept;
    Projection& operator=(Projection&&) noexcept;

    /// True if coefficients are the values themselves.
    bool is_identity() const;

    /// True if coefficients are weighted means of the values, as the values themselves are: constants are kept, and
    /// nothing is amplified.
    bool is_mean() const;

    /// values: #points by #channels; the coefficients: #S by #channels.
    Values coefficients(const Values& values, const Execution& execution = {}) const;

    /// The same in single precision, for products of the operator with operands that have it; each column has the same
    /// bits whatever columns are beside it. Resizes `result`, and `scratch` if it is needed; both must not be `values`.
    void coefficients(const SingleValues& values, SingleValues& result, SingleValues& scratch,
                      const Execution& execution) const;

    /// Πᵀ x: #S by any number of columns to #points by the same.
    Values transposed(const Values& x) const;

    /// Π as a matrix, #S by #points, with all entries that may differ from 0; none if it is the identity or not local.
    std::optional<SparseRows> matrix() const;

    /// How many stored entries a product with one column multiplies.
    std::size_t entry_count() const;

    /// Estimate of ‖M‖₁ ‖M⁻¹‖₁ (Hager 1984), a lower bound, for the matrix M that is inverted; 1 if none is.
    double condition() const { return condition_; }

  private:
    struct Map;
    std::unique_ptr<Map> map_;
    double condition_ = 1.0;
};

} // namespace difusa
