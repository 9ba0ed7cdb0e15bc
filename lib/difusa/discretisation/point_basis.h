// Common part of bases whose elements are defined by points (T 3.3.1). A plugin derives from PointBasis and defines how
// far an element reaches and its weight; this class finds the elements, normalises, and handles points not covered by
// any support.
#pragma once

#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/separators.h>
#include <difusa/discretisation/support_grid.h>

#include <memory>
#include <span>

namespace difusa {

/// The elements whose support may contain a point x, as parallel arrays of equal length.
struct Neighbourhood {
    std::span<const Index> site;
    std::span<const double> distance; ///< Euclidean distance |x - p_i|
    std::span<const double> cosine;   ///< n_x·n_i > 0; site distance (T 4.1) = distance / cosine
    std::span<const double> radius;   ///< r_i
};

class PointBasis : public Basis {
  public:
    PointBasis();
    ~PointBasis() override;
    PointBasis(const PointBasis&) = delete;
    PointBasis& operator=(const PointBasis&) = delete;
    void bind(const Mesh& mesh, const SiteSet& sites, const Execution& execution = {}) final;
    std::size_t size() const final;

    /// Elements at x; those of sites that are out of its sight (separators.h) vanish. If a basis that sums to one has
    /// no support there, all weight goes to the nearest site of the region: of the 16 nearest in space, the one at the
    /// smallest site distance, or the nearest in space if all face away. Where something may come between, it has to be
    /// in sight; up to 64 sites are looked at. There is no element where none of these is: under what stands on the
    /// surface. On a region without sites it is the nearest of all sites.
    void evaluate(const SurfacePoint& x, BasisRow& row) const final;
    void evaluate(std::span<const SurfacePoint> x, std::span<BasisRow> rows) const final;

    /// False if no site of the region is in sight of x, as far as `evaluate` looks.
    bool reaches(const SurfacePoint& x) const { return nearest(x) != none; }

  protected:
    /// Called by `bind` before any evaluation, to precompute what the basis derives from all of its sites.
    virtual void prepare(const SiteSet& /*sites*/) {}

    /// Euclidean radius beyond which an element of radius r vanishes: finite and above 0, else `bind` throws
    /// UsageError.
    virtual double support(double r) const = 0;

    /// Writes the mother function's value Psi_i(x) for each neighbour. If the basis sums to one, only their ratios
    /// matter (phi_i = Psi_i / sum Psi_j, T 3.10; no support if the sum is not positive), otherwise phi_i = Psi_i. They
    /// are non-negative if it is a partition of unity.
    virtual void weigh(const SurfacePoint& x, const Neighbourhood& near, std::span<double> weight) const = 0;

  private:
    struct NearestSite;
    Index nearest(const SurfacePoint& x) const; ///< or none
    void evaluate_among(const SurfacePoint& x, std::span<const Index> candidates, BasisRow& row) const;
    const Mesh* mesh_ = nullptr;
    const SiteSet* sites_ = nullptr;
    bool normalise_ = false;
    SupportGrid grid_;
    Separators separators_;
    std::unique_ptr<NearestSite> nearest_;
};

} // namespace difusa
