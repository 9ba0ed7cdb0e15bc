// The exchange area of two polygons with others between them: exact visibility at points of one, adaptive integration
// over it.
#pragma once

#include <difusa/form_factors/blockers.h>
#include <difusa/form_factors/unblocked.h>

#include <cstddef>
#include <vector>

namespace difusa {

/// The view of one polygon from the points of another, through blockers. Scratch of one thread.
class BlockedView {
  public:
    /// From points of `from` to the polygon `to`, each wholly in front of the plane of the other. Of the blockers only
    /// what is in front of both planes counts.
    void set(const PolygonEnd& from, const PolygonEnd& to, std::span<const Blocker* const> blockers, double rounding);

    /// The form factor from the element at x, in the plane of `from` and with its normal, to the visible part of `to`.
    /// Exact to rounding: a convex blocker hides from x what lies inside all planes through x and its edges. What lies
    /// outside is at most one convex polygon for each edge; Lambert's formula is summed over those that remain
    /// (lighting/lambert.h).
    double form_factor(const Vec3& x);

  private:
    void hide(const Vec3& x, const FlatPolygon& blocker, const Plane& plane);

    const PolygonEnd* from_ = nullptr;
    const PolygonEnd* to_ = nullptr;
    double rounding_ = 0.0;
    std::vector<FlatPolygon> blockers_;
    std::vector<Plane> planes_;              ///< of the blockers
    std::vector<FlatPolygon> pieces_, next_; ///< what is visible of `to`
    std::vector<Plane> sides_;               ///< through x and the edges of a blocker
};

/// A_P F_PQ through blockers, with an estimated error of at most `tolerance` (an area) if `most_triangles` suffice: the
/// form factor from points of the one with the smaller radius is integrated over it. The 3-point rule is accepted where
/// it agrees with the centroid, the 7-point rule where it agrees with the 3-point rule; else the triangle with the
/// largest difference is divided into four, until the sum of the differences is below the tolerance. The kinks at which
/// the outline of one polygon enters the shadow of another thus end up in small triangles.
Estimate blocked_exchange(const PolygonEnd& P, const PolygonEnd& Q, std::span<const Blocker* const> blockers,
                          double rounding, double tolerance, BlockedView& view, std::size_t most_triangles = 20000);

} // namespace difusa
