// Closed parts of a surface, such as a ball or a crate: whoever is outside of one sees only its fronts, and one that is
// convex hides what lies behind its outline.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>
#include <difusa/rays/flat_polygon.h>

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace difusa {

/// A closed surface whose fronts face outwards, and which does not pass through itself: on the way from a point outside
/// of it, a front is met before any back.
class ClosedBody {
  public:
    /// From triangles that make up such a surface; `faces`: #T, those in one plane have the same number. Testing for
    /// convexity takes from `comparisons` as many of a face with a corner as it needs.
    ClosedBody(const Mesh& mesh, const std::vector<Index>& triangles, const std::vector<Index>& faces,
               std::size_t& comparisons);

    /// All corners are in or behind the plane of each face, up to the rounding of coordinates in single precision, but
    /// at most a millionth of the body's extent. False without a test if too few comparisons are left.
    bool convex() const { return convex_; }

    std::span<const Vec3> corners() const { return corners_; } ///< those on edges between faces
    std::size_t face_count() const { return planes_.size(); }

    /// Of a convex body: whether the segment from p to q passes through its surface, deeper than `rounding`.
    bool is_crossed(const Vec3& p, const Vec3& q, double rounding) const;

    /// Of a convex body: true only if it hides all points of the convex hull of `to` from all of that of `from`. That
    /// is so if one of the hulls is outside of it and all segments between the given points cross it: the points from
    /// which it hides a point are a convex set.
    bool hides(std::span<const Vec3> from, std::span<const Vec3> to, double rounding) const;

    /// Of a convex body: true only if some plane has the body on one side and all points on the other, up to
    /// `rounding`. The plane is searched for as E. G. Gilbert does (1966), in few steps: false if it is not found.
    bool is_apart(std::span<const Vec3> points, std::span<const Vec3> others, double rounding) const;

    /// What a point sees of a convex body. Scratch of one thread.
    struct View {
        std::vector<char> front;    ///< #faces: whether the point is before it
        std::vector<Index> next;    ///< #corners: the one that follows on the outline, or none
        std::vector<Index> outline; ///< numbers of corners, counterclockwise as seen from the point
    };

    /// Finds the outline of a convex body as seen from a point x outside of it: the edges between faces that x is
    /// before, by more than `rounding`, and others. False if they are not one simple convex loop, where rounding
    /// decides.
    bool find_outline(const Vec3& x, double rounding, View& view) const;

  private:
    bool is_convex(std::size_t& comparisons) const;
    void prepare_convex();
    Index lowest_corner(const Vec3& direction, Index start) const;
    Index low_corner(const Vec3& direction) const;

    struct Edge {
        Index from, to, left, right; ///< corners; and faces, as seen from before the left one with `to` above `from`
    };
    std::vector<Vec3> corners_;
    std::vector<Plane> planes_; ///< #faces, of the first triangle of each
    std::vector<Edge> edges_;
    bool convex_ = false;
    Vec3 centre_ = Vec3::Zero();           ///< of a ball inside of a convex body, and of one around it
    double inner_ = 0.0, outer_ = 0.0;     ///< their radii
    std::array<Index, 6> poles_{};         ///< its lowest and highest corners along each axis
    Eigen::MatrixX3d columns_;             ///< the corners of a convex body once more
    std::vector<Index> neighbour_, first_; ///< corners at the other ends of its edges, those of each corner in turn
};

/// #T: the body that the triangle is a part of, or null. `parts`: #T, the flat parts (blockers.h). None are found if it
/// would take too long to test for self-intersections (mesh/crossing_faces.h), nor such as are thinner than rounding in
/// single precision: sheets with both sides. Throws Interrupted.
std::vector<std::shared_ptr<const ClosedBody>> closed_bodies(const Mesh& mesh, const std::vector<Index>& parts,
                                                             const Execution& execution = {});

} // namespace difusa
