// The exchange area of two triangles of a surface, with what may come between them.
#pragma once

#include <difusa/form_factors/blocked.h>
#include <difusa/form_factors/blockers.h>
#include <difusa/form_factors/unblocked.h>
#include <difusa/mesh/mesh.h>

#include <cstddef>
#include <span>
#include <vector>

namespace difusa {

/// What a computation of form factors came to, counted by pairs of triangles, or of groups.
struct FormFactorCounts {
    std::size_t clear = 0;   ///< nothing in between
    std::size_t partial = 0; ///< something may be in between
    std::size_t hidden = 0;  ///< completely behind a single flat part of the surface; those found in groups count once

    FormFactorCounts& operator+=(const FormFactorCounts& other) {
        clear += other.clear;
        partial += other.partial;
        hidden += other.hidden;
        return *this;
    }
};

/// The triangles of a mesh as ends of exchanges.
std::vector<PolygonEnd> ends_of(const Mesh& mesh);

/// On which side of a plane points are.
enum class PlaneSide { behind, across, in_front };

/// Points within `rounding` of the plane count as on it; all of them on it as behind.
PlaneSide side_of(const Plane& plane, std::span<const Vec3> points, double rounding);

/// Pairs of triangles, for a search that goes down trees of them: a stack of lists of obstacles that may come between
/// what it looks at. Scratch of one thread.
class PairExchange {
  public:
    PairExchange(const std::vector<PolygonEnd>& ends, double rounding, const Execution& execution)
        : ends_(ends), rounding_(rounding), execution_(execution) {}

    /// Obstacles: each range [first, last) of the stack is a list.
    std::vector<const Obstacle*> between;

    /// Adds to the end of the stack those of [first, last) that may come between any of these points. False if one of
    /// them hides all.
    bool narrow(std::span<const Vec3> from, std::span<const Vec3> to, std::size_t first, std::size_t last);

    /// A_p F_pq of two triangles: clipped to the fronts of both planes; then `unblocked_exchange` with a thousandth of
    /// `allowed` (an area) if none of the obstacles [first, last) reaches between them, else `blocked_exchange`. Leaves
    /// the stack as it was. Throws Interrupted.
    Estimate of(Index p, Index q, std::size_t first, std::size_t last, double allowed);

    FormFactorCounts counts;

  private:
    const std::vector<PolygonEnd>& ends_;
    double rounding_;
    Execution execution_;
    PolygonEnd cut_p_, cut_q_;
    BlockedView view_;
};

} // namespace difusa
