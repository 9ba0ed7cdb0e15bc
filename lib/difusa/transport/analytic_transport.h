// Gathered transport in which surface that a point sees whole has its exact form factor. Rays serve the rest.
#pragma once

#include <difusa/algebra/hit_lists.h>
#include <difusa/algebra/sparse_rows.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/light_transport.h>
#include <difusa/transport/mirrored.h>
#include <difusa/transport/surfel_tree.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace difusa {

/// W = F M + diag(s) R: M are means and first moments over groups of surfels, F the form factors of those that points
/// see whole, and the slopes of their kernels (analytic_factors.h), R the rays that end elsewhere, and s makes what
/// they carry add up to 1 with F.
class AnalyticTransport final : public RefinedTransport {
  public:
    /// `scale`: s of each row.
    AnalyticTransport(std::shared_ptr<const HitLists> by_rays, std::shared_ptr<const HitLists> rest,
                      std::vector<double> scale, SparseRows factors, SurfelGroups groups);

    const HitLists& by_rays() const override { return *by_rays_; }

    /// What of the irradiance at point j has exact form factors, of a whole of 1.
    double exact_share(std::size_t j) const;

    std::size_t rows() const override { return by_rays_->rows(); }
    std::size_t columns() const override { return by_rays_->columns(); }
    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_single(const SingleValues& x, Values& y, const Execution& execution) const override;
    bool prefers_single() const override { return true; }
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;
    std::size_t entry_count() const override;
    Values variance_of_rays(const Values& x, const Execution& execution) const override;

    /// The mean over the points of what has exact form factors, of a whole of 1.
    double share() const;

    /// Bytes beside those of `by_rays`.
    std::size_t bytes() const;

  private:
    template <class Operand> void apply_any(const Operand& x, Values& y, const Execution& execution) const;

    std::shared_ptr<const HitLists> by_rays_, rest_;
    std::vector<double> scale_;
    SparseRows factors_; ///< columns: SurfelGroups::moments_of
    SurfelGroups groups_;
};

/// When to look for surface that is seen whole.
enum class AnalyticUse {
    automatic, ///< if a sample of the points shows that it pays
    always,
    never
};

/// The transport with exact form factors, at the points that its rows belong to. Unchanged if they are of no use: with
/// rows that are no HitLists, mirrors, symmetry planes or periods.
LightTransport with_analytic_factors(LightTransport transport, const Mesh& mesh, std::span<const SurfacePoint> points,
                                     const Surfels& surfels, AnalyticUse use, const Execution& execution);

class AnalyticFactors;

/// The exact form factors of some points, found once, for any of their rays.
class FactorsOfPoints {
  public:
    /// `rays`: the number whose noise the errors of linear kernels are to stay below. Keeps references.
    FactorsOfPoints(const Mesh& mesh, std::span<const SurfacePoint> points, const Surfels& surfels, std::size_t rays,
                    const Execution& execution);
    ~FactorsOfPoints();

    /// As `with_analytic_factors` (AnalyticUse::always): of a transport to these points with rows of HitLists.
    LightTransport refine(LightTransport transport, const Execution& execution) const;

  private:
    std::unique_ptr<AnalyticFactors> factors_;
    std::vector<std::vector<GroupFactor>> found_; ///< of each point
};

} // namespace difusa
