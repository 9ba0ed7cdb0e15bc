// Whether anything can occlude a polygon seen from a point.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// Faces of a mesh, found by the pyramids they may reach into.
class Shafts {
  public:
    /// All faces. Keeps a reference.
    explicit Shafts(const Mesh& mesh);

    /// These faces.
    Shafts(const Mesh& mesh, const std::vector<Index>& faces);

    bool any() const { return !faces_.empty(); }
    const Mesh& mesh() const { return mesh_; }
    double rounding() const { return rounding_; } ///< heights above planes within this count as 0

    /// False only if no face hides any part of triangle t from x, for rays that start at x and end on t and are exempt
    /// from the planes of these two faces (rays/own_plane.h). True if a face may reach into the tetrahedron between
    /// them. `last`: a face to try first, which changes nothing but the time; then the one that was found, if any.
    bool may_be_blocked(const SurfacePoint& x, Index t, Index& last) const;

    /// The same for a convex polygon of at most `most_corners`, counterclockwise around its unit normal, whose front
    /// faces x. Faces in its plane do not count.
    bool may_be_blocked(const SurfacePoint& x, std::span<const Vec3> polygon, const Vec3& normal) const;
    static constexpr std::size_t most_corners = 16;

    /// Those that may hide parts of it, at most `most`, in `blockers`; false if there are more.
    bool find_blockers(const SurfacePoint& x, std::span<const Vec3> polygon, const Vec3& normal, std::size_t most,
                       std::vector<Index>& blockers) const;

    /// False only if no face reaches into the smallest box around x and this one.
    bool may_reach_between(const Vec3& x, const BoxTree::Box& box) const;

  private:
    class Pyramid;

    /// Calls `act(face)` for each face that may reach into the pyramid, until it returns true. True if it did.
    template <class Act> bool visit(const Pyramid& pyramid, const Act& act) const;

    const Mesh& mesh_;
    BoxTree faces_;
    double rounding_;
};

/// Where the surface is, as seen from a face: on both sides of its plane, or, as for the walls of a convex room, before
/// it or in it, or behind it or in it. Faces of which all is on one side never come between two points of the surface.
enum class Exposure : std::uint8_t { both, before, behind };

/// #T
std::vector<Exposure> exposures(const Mesh& mesh, const Execution& execution);

/// The others: those that may come between two points of the surface.
std::vector<Index> occluders(const std::vector<Exposure>& exposures);

/// The faces that share area with another one in the same plane that faces the same way: which of them a ray meets is
/// left to chance. #T, 1 or 0.
std::vector<std::uint8_t> overlaid_faces(const Mesh& mesh, const Execution& execution);

} // namespace difusa
