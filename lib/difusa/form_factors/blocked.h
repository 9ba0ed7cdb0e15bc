// The exchange area of two polygons with others between them: exact visibility at points of one, adaptive integration
// over it.
#pragma once

#include <difusa/form_factors/blockers.h>
#include <difusa/form_factors/shadow_region.h>
#include <difusa/form_factors/unblocked.h>
#include <difusa/rays/visible_part.h>

#include <array>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

namespace difusa {

/// How much of a polygon a point sees: bits, so that what several points see can be combined.
enum class Seen : unsigned { nothing = 1, part = 2, everything = 4 };

/// The view of one polygon from the points of another, through blockers. Scratch of one thread.
class BlockedView {
  public:
    /// From points of `from` to the polygon `to`, each wholly in front of the plane of the other. Of the obstacles only
    /// what is in front of both planes counts. All calls are with the same rounding and obstacles of one set: outlines
    /// of bodies are kept.
    void set(const PolygonEnd& from, const PolygonEnd& to, std::span<const Obstacle* const> obstacles, double rounding);

    /// The form factor from the element at x, in the plane of `from` and with its normal, to the visible part of `to`.
    /// Exact to rounding, past nearly convex bodies to that of single precision: a convex blocker hides from x what
    /// lies inside all planes through x and its edges, a convex body what lies inside those through its outline; of
    /// other closed bodies only fronts count. What lies outside is at most one convex polygon for each edge; Lambert's
    /// formula is summed over those that remain (rays/lambert.h).
    double form_factor(const Vec3& x);

    /// What the last point saw.
    Seen seen() const { return seen_; }

    /// Begins with a triangle in the plane of `from`, counterclockwise as seen from the front: up to the next one,
    /// views are from its points, and blockers count whose shadow regions meet it. False if there are none.
    bool begin(const std::array<Vec3, 3>& corners);

    /// The exchange area of the triangle with `to`, if nothing is between them; `tolerance`: as of unblocked_exchange.
    Estimate unobstructed(const std::array<Vec3, 3>& corners, double tolerance) const;

    /// Whether it is remembered which blockers hide something from a point; nothing is when a triangle begins.
    void notice(bool whether) { notices_ = whether; }

    /// What may be hidden from the triangle by blockers that no point has noticed, or of whose shadow region, or its
    /// core, few points can be in, so small is it: for each of them, the area of the region within the triangle times
    /// the most that all of them hide from some points of it, an exchange area. A body counts as one; parts that
    /// together are large and have been noticed are resolved. What cannot be more than `negligible` for one of them is
    /// left out.
    double unnoticed(double negligible);

    /// `from`, divided along the lines in which blockers end on its plane or pass through it: from points on either
    /// side of such a line they hide different parts of `to`, so that the form factor jumps across it.
    std::vector<FlatPolygon> smooth_parts() const;

  private:
    /// A closed body that some pieces are a part of.
    struct Body {
        const ClosedBody* body;
        std::size_t listed = 0; ///< of its pieces
        bool outside = false;   ///< it is in front of the plane of `from`, whose points are outside of it
        bool noticed = false;   ///< some piece, from points of the current triangle
        std::optional<ShadowRegion> shadow = {}, core = {};
        ShadowRegion::Part touched = {}; ///< what of the current triangle is in its shadow region
    };
    /// A piece of the surface.
    struct Piece {
        FlatPolygon polygon;
        Plane plane;
        std::size_t body; ///< its number, or that of none
    };
    /// The line in which a blocker meets the plane of `from`.
    struct Cut {
        double length; ///< of what of it is in `from`
        Plane plane;   ///< of the blocker
    };
    /// The blockers: `wholes_`, then `pieces_`.
    std::size_t blocker_count() const { return wholes_.size() + pieces_.size(); }
    /// The body that a blocker is a piece of; null for others.
    Body* body_of(std::size_t blocker);
    /// Some corners, or, if they are many, those of their bounding box.
    std::span<const Vec3> few_corners(std::span<const Vec3> corners);
    /// Where a blocker, or the body that it is a piece of, may hide something of `to` (`core`: its centre).
    const ShadowRegion& shadow_of(std::size_t blocker, bool core = false);
    bool is_noticed(std::size_t active);
    /// What of the current triangle is in the shadow region of an active blocker; nothing if that is resolved.
    ShadowRegion::Part unresolved(std::size_t active);
    /// The most that the blockers left out hide from some points of a part.
    double most_hidden(const ShadowRegion::Part& part);
    bool hide_behind(const Vec3& x, std::size_t blocker);
    bool hides_as_a_whole(const ClosedBody& body) const;
    void add(const Blocker& blocker);
    void add_cut(const FlatPolygon& piece, const Plane& plane);
    std::size_t number_of(const ClosedBody& body);
    bool hide(const Vec3& x, const FlatPolygon& blocker, const Plane& plane);
    const std::vector<Index>* outline_of(const ClosedBody& body, const Vec3& x);
    std::optional<bool> hide_behind(const Vec3& x, const ClosedBody& body);
    bool hide_behind(const Vec3& x, const Obstacle& whole);
    std::optional<double> factor_past(const Vec3& x, const ClosedBody& body);
    double factor_of(const Vec3& x, const FlatPolygon& polygon) const;

    /// What the corners of a body are seen from.
    struct Sight {
        const ClosedBody* body;
        std::array<double, 3> x;
        bool operator==(const Sight&) const = default;
    };
    struct SightHash {
        std::size_t operator()(const Sight& sight) const;
    };

    const PolygonEnd* from_ = nullptr;
    const PolygonEnd* to_ = nullptr;
    double rounding_ = 0.0;
    Seen seen_ = Seen::everything;
    std::vector<Body> bodies_;
    std::vector<const Obstacle*> wholes_; ///< convex bodies in front of `to`, with `from` outside of them
    std::vector<Piece> pieces_;           ///< of all others
    std::vector<Cut> cuts_;               ///< the longest first
    PlaneFrame frame_;                    ///< of `from`
    std::vector<std::optional<ShadowRegion>> shadows_, cores_; ///< #blockers, of those that are no pieces of bodies
    std::array<Vec3, 8> box_;                                  ///< scratch

    // Of the current triangle:
    std::array<PlaneFrame::Point, 3> triangle_;
    double triangle_area_ = 0.0;
    std::vector<std::size_t> active_;         ///< the blockers that count; all of them before the first triangle
    std::vector<ShadowRegion::Part> touched_; ///< #active: what of it is in their shadow regions
    std::vector<char> noticed_, left_out_;    ///< #active; the latter hide nothing if `leaves_out_`
    bool notices_ = false, leaves_out_ = false;
    std::vector<ShadowRegion::Part> parts_; ///< scratch
    ClosedBody::View view_;
    std::unordered_map<Sight, std::vector<Index>, SightHash> outlines_; ///< found before: pairs have points in common
    VisiblePart visible_;                                               ///< of `to`
};

/// A_P F_PQ through blockers, with an estimated error of at most `tolerance` (an area) if `most_triangles` suffice: the
/// form factor from points of the one with the smaller radius is integrated over its smooth parts. Triangles that no
/// shadow region meets see everything: the contour integral is exact. Of others, where all of 1 + 3 inner points and
/// the corners see everything, or all of them nothing, and the rules of 1 and 3 points and of the corners agree, that
/// is the result. Else the 7-point rule is compared with the 3-point rule and with that of the centre and the corners,
/// and what the corners see with both if not all points see alike. What blockers may hide that the points do not notice
/// is added to the difference. The triangle with the largest one is divided into four until their sum is below the
/// tolerance: the kinks at which the outline of one polygon enters the shadow of another end up in small triangles.
/// Throws Interrupted.
Estimate blocked_exchange(const PolygonEnd& P, const PolygonEnd& Q, std::span<const Obstacle* const> obstacles,
                          double rounding, double tolerance, BlockedView& view, const Execution& execution,
                          std::size_t most_triangles = 20000);

} // namespace difusa
