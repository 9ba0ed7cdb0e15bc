// Plugin kind "basis": finite elements phi_i on the surface, representing a function as sum_i b_i phi_i(x).
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/mesh.h>

#include <set>
#include <span>
#include <string>
#include <vector>

namespace difusa {

/// The nonzero elements at a point, with their weights: phi_{element[i]}(x) = weight[i].
struct BasisRow {
    std::vector<Index> element;
    std::vector<double> weight;
    void clear() {
        element.clear();
        weight.clear();
    }
};

/// Elements that are parts of patches, which send light as a whole (substructuring, L 31): #elements each.
struct Substructure {
    std::vector<Index> patch; ///< that an element is part of; numbered from 0
    std::vector<double> area; ///< of the element
    int levels = 0;           ///< quarterings of a patch in a row, at most

    std::size_t patches() const { return std::set<Index>(patch.begin(), patch.end()).size(); }
};

class Basis {
  public:
    virtual ~Basis() = default;

    /// True if its sites may be at the centres of elements into which patches are divided (PatchElements).
    virtual bool can_be_subdivided() const { return false; }

    /// What it was bound to, if its sites are graded and it can be subdivided; else null.
    virtual const Substructure* substructure() const { return nullptr; }

    /// Name of the sampler that places the only sites which the basis can be bound to; empty: any sites will do.
    virtual std::string sampler() const { return {}; }

    /// Binds the basis to its sites (one element per site); both must outlive it. Called once. Throws UsageError if it
    /// cannot be bound to these sites.
    virtual void bind(const Mesh& mesh, const SiteSet& sites, const Execution& execution = {}) = 0;

    /// Number of elements; 0 before it is bound.
    virtual std::size_t size() const = 0;

    /// phi_i(x) >= 0 and sum_i phi_i(x) = 1 at every surface point (T 3.7, 3.8) that has an element.
    virtual bool partition_of_unity() const = 0;

    /// sum_i phi_i(x) = 1 at every surface point that has an element, whatever the signs: constants are reproduced.
    /// Points without one are those that no light can reach.
    virtual bool sums_to_one() const { return partition_of_unity(); }

    /// True if the coefficients of a function are its values at the sites, because the basis interpolates or is meant
    /// as a quasi-interpolant; false if the coefficients require solving Z b = values (T 3.2).
    virtual bool coefficients_are_values() const = 0;

    /// True if phi_i(p_j) = 1 for i = j, else 0: a function in the basis has its coefficients as values at the sites.
    virtual bool interpolates() const { return false; }

    /// Writes the elements at x; none on dark regions (SiteSet::dark), nor where what stands on the surface covers it.
    /// Thread-safe with distinct rows.
    virtual void evaluate(const SurfacePoint& x, BasisRow& row) const = 0;

    /// The same for many points, rows[i] for x[i]; a basis may override it with something faster than one point at a
    /// time.
    virtual void evaluate(std::span<const SurfacePoint> x, std::span<BasisRow> rows) const {
        for (std::size_t i = 0; i < x.size(); ++i) {
            evaluate(x[i], rows[i]);
        }
    }

    /// The weights of the coefficients at x in the field that is displayed, where these are others than those of the
    /// field in the equation: the extrapolation of patches to their vertices (L 53). Thread-safe likewise.
    virtual void display(const SurfacePoint& x, BasisRow& row) const { evaluate(x, row); }

    /// True if the weights of `display` are others than those of `evaluate`.
    virtual bool displays_otherwise() const { return false; }
};

} // namespace difusa
