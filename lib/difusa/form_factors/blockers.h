// What can come between two polygons: the surface as few, large, convex, flat pieces.
#pragma once

#include <difusa/form_factors/closed_body.h>
#include <difusa/mesh/mesh.h>
#include <difusa/rays/own_plane.h>
#include <difusa/rays/visible_part.h>

#include <memory>
#include <span>
#include <vector>

namespace difusa {

/// A convex piece of the surface. Which side is the front does not matter: both block.
struct Blocker {
    FlatPolygon polygon; ///< at most `Blocker::most_corners`, none between two others on a straight line
    Plane plane;         ///< unit normal
    Vec3 low = Vec3::Zero(), high = Vec3::Zero(); ///< bounding box
    std::shared_ptr<const ClosedBody> body = {};  ///< that it is a part of; null: it blocks by itself

    static constexpr std::size_t most_corners = VisiblePart::most_corners;
    explicit Blocker(const FlatPolygon& corners);
};

/// The flat parts of a surface: triangles in one plane that are joined across edges have the same number. Numbers are
/// in the order of their first triangles.
std::vector<Index> flat_parts(const Mesh& mesh);

/// The surface as convex polygons: each flat part as a whole if it is convex, else its triangles merged while the union
/// of two is convex. Left out: pieces that have the whole surface on one side, as the walls of an empty room, for they
/// come between no two of its points.
std::vector<Blocker> blockers_of(const Mesh& mesh, const std::vector<Index>& parts, const Execution& execution = {});

/// What blocks as one: a convex body as a whole, or a single piece of the rest of the surface.
class Obstacle {
  public:
    explicit Obstacle(std::span<const Blocker> pieces);

    std::span<const Blocker> pieces() const { return pieces_; }
    const ClosedBody* body() const { return body_; } ///< convex; null: there is one piece
    std::span<const Vec3> corners() const { return body_ != nullptr ? body_->corners() : pieces_[0].polygon.corners(); }
    const Vec3& low() const { return low_; } ///< bounding box
    const Vec3& high() const { return high_; }

    /// Whether some of it is above the plane.
    bool rises_above(const Plane& plane, double rounding) const;

    /// Whether the segment from p to q passes through it.
    bool is_crossed(const Vec3& p, const Vec3& q, double rounding) const;

  private:
    std::span<const Blocker> pieces_;
    const ClosedBody* body_;
    Vec3 low_, high_;
};

/// All that blocks on a surface.
class ObstacleSet {
  public:
    /// Those of `blockers`, with the pieces of each convex body together.
    explicit ObstacleSet(std::vector<Blocker> blockers);
    ObstacleSet(const ObstacleSet&) = delete; // they refer to their pieces
    ObstacleSet(ObstacleSet&&) = default;
    ObstacleSet& operator=(const ObstacleSet&) = delete;
    ObstacleSet& operator=(ObstacleSet&&) = default;
    ~ObstacleSet() = default;

    const std::vector<Obstacle>& all() const { return all_; }

  private:
    std::vector<Blocker> pieces_;
    std::vector<Obstacle> all_;
};

/// What a blocker does to the view between two sets of points.
enum class Obstruction {
    clear,   ///< no segment from one convex hull to the other passes through it
    partial, ///< some may
    complete ///< all do
};

/// Conservative: `clear` and `complete` are certain, up to sets of measure zero. Where the blocker's plane separates
/// the sets, the hulls' view of each other meets that plane in the convex hull of the points in which the segments
/// between the given points cross it.
Obstruction obstruction(const Blocker& blocker, std::span<const Vec3> from, std::span<const Vec3> to, double rounding);

/// Likewise: a body is `clear` if a plane is found that has the sets on one side and the body on the other.
Obstruction obstruction(const Obstacle& obstacle, std::span<const Vec3> from, std::span<const Vec3> to,
                        double rounding);

} // namespace difusa
