#include <difusa/rays/shaft.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/mesh/shared_area.h>
#include <difusa/mesh/triangle_tree.h>
#include <difusa/rays/flat_polygon.h>
#include <difusa/rays/own_plane.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace difusa {

Shafts::Shafts(const Mesh& mesh) : mesh_(mesh), faces_(tree_of_triangles(mesh)), rounding_(plane_rounding(mesh)) {}

Shafts::Shafts(const Mesh& mesh, const std::vector<Index>& faces)
    : mesh_(mesh), faces_(tree_of_triangles(mesh, faces)), rounding_(plane_rounding(mesh)) {}

/// What lies between a point and a polygon that it sees the front of.
class Shafts::Pyramid {
  public:
    Pyramid(const Mesh& mesh, double rounding, const SurfacePoint& x, std::span<const Vec3> polygon, const Vec3& normal)
        : mesh_(mesh), rounding_(rounding), x_(x), polygon_(polygon), around_(x.position) {
        DIFUSA_REQUIRE(polygon.size() <= most_corners);
        // x sees the front, so the corners run clockwise around the pyramid's sides.
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Vec3& next = polygon[k + 1 < polygon.size() ? k + 1 : 0];
            if ((next - polygon[k]).norm() <= rounding) {
                continue; // the direction of the side is lost to rounding
            }
            add((next - x.position).cross(polygon[k] - x.position), x.position);
        }
        add(normal, polygon[0]);
        const Vec3& own = mesh.face_normal(x);
        const auto above = [&](const Vec3& corner) { return own.dot(corner - x.position) >= 0.0; };
        // Otherwise a shading normal sees below the face.
        if (x.normal == own || std::all_of(polygon.begin(), polygon.end(), above)) {
            add(own, x.position);
        }
        for (const Vec3& corner : polygon) {
            around_.extend(corner);
        }
    }

    /// False only if no face in the box may reach into it.
    bool may_meet(const BoxTree::Box& box) const {
        return around_.intersects(box) &&
               std::all_of(planes_.begin(), planes_.begin() + count_,
                           [&](const Plane& plane) { return plane.highest(box) >= -rounding_; });
    }

    /// Of a face in a box that it may meet.
    bool may_be_reached_by(Index face) const {
        if (face == x_.face) {
            return false;
        }
        const std::array<Vec3, 3> p = mesh_.corners(face);
        // A face that merely touches the pyramid from outside hides no area.
        for (std::size_t k = 0; k < count_; ++k) {
            const Plane& plane = planes_[k];
            if (std::all_of(p.begin(), p.end(), [&](const Vec3& q) { return plane.height(q) <= rounding_; })) {
                return false;
            }
        }
        // Nor does one whose plane has the whole pyramid on one side.
        const Vec3& n = mesh_.normals[face];
        const double height = n.dot(p[0]);
        double least = std::min(0.0, n.dot(x_.position) - height), most = std::max(0.0, n.dot(x_.position) - height);
        for (const Vec3& q : polygon_) {
            least = std::min(least, n.dot(q) - height);
            most = std::max(most, n.dot(q) - height);
        }
        return least < -rounding_ && most > rounding_;
    }

  private:
    void add(const Vec3& inwards, const Vec3& through) {
        const double length = inwards.norm();
        if (length > 0.0) { // otherwise the pyramid is flat there, and the plane cuts nothing off
            planes_[count_++] = {inwards / length, inwards.dot(through) / length};
        }
    }

    const Mesh& mesh_;
    double rounding_;
    const SurfacePoint& x_;
    std::span<const Vec3> polygon_;
    std::array<Plane, most_corners + 2> planes_;
    std::size_t count_ = 0;
    BoxTree::Box around_;
};

template <class Act> bool Shafts::visit(const Pyramid& pyramid, const Act& act) const {
    return faces_.visit_where([&](const BoxTree::Box& box) { return pyramid.may_meet(box); },
                              [&](Index face) { return pyramid.may_be_reached_by(face) && act(face); });
}

bool Shafts::may_be_blocked(const SurfacePoint& x, Index t, Index& last) const {
    const std::array<Vec3, 3> corners = mesh_.corners(t);
    const Pyramid pyramid(mesh_, rounding_, x, corners, mesh_.normals[t]);
    if (last != none && last != t && pyramid.may_meet(mesh_.box(last)) && pyramid.may_be_reached_by(last)) {
        return true;
    }
    return visit(pyramid, [&](Index face) {
        if (face == t) {
            return false;
        }
        last = face;
        return true;
    });
}

bool Shafts::may_be_blocked(const SurfacePoint& x, std::span<const Vec3> polygon, const Vec3& normal) const {
    return visit(Pyramid(mesh_, rounding_, x, polygon, normal), [](Index) { return true; });
}

bool Shafts::find_blockers(const SurfacePoint& x, std::span<const Vec3> polygon, const Vec3& normal, std::size_t most,
                           std::vector<Index>& blockers) const {
    blockers.clear();
    return !visit(Pyramid(mesh_, rounding_, x, polygon, normal), [&](Index face) {
        blockers.push_back(face);
        return blockers.size() > most;
    });
}

bool Shafts::may_reach_between(const Vec3& x, const BoxTree::Box& box) const {
    BoxTree::Box around = box;
    around.extend(x);
    return faces_.visit(around, [](Index, const BoxTree::Box&) { return true; });
}

std::vector<std::uint8_t> overlaid_faces(const Mesh& mesh, const Execution& execution) {
    const BoxTree tree = tree_of_triangles(mesh);
    const double rounding = plane_rounding(mesh);
    std::vector<std::uint8_t> overlaid(mesh.triangles.size(), 0);
    parallel_for(overlaid.size(), 256, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto t = static_cast<Index>(i);
            const std::array<Vec3, 3> corners = mesh.corners(t);
            const Vec3& n = mesh.normals[t];
            const auto lies_on = [&](Index other, const BoxTree::Box&) {
                const std::array<Vec3, 3> p = mesh.corners(other);
                return other != t && n.dot(mesh.normals[other]) > 0.0 &&
                       std::all_of(p.begin(), p.end(),
                                   [&](const Vec3& c) { return std::abs(n.dot(c - corners[0])) <= rounding; }) &&
                       share_area(corners, p, n, rounding);
            };
            overlaid[i] = tree.visit(mesh.box(t), lies_on) ? 1 : 0;
        }
    });
    return overlaid;
}

std::vector<Exposure> exposures(const Mesh& mesh, const Execution& execution) {
    std::vector<Exposure> exposures(mesh.triangles.size(), Exposure::before);
    if (mesh.convex) {
        return exposures;
    }
    const BoxTree tree = tree_of_triangles(mesh);
    const double rounding = plane_rounding(mesh);
    const auto is_above = [&](const Plane& plane) {
        return tree.visit_where([&](const BoxTree::Box& box) { return plane.highest(box) > rounding; },
                                [&](Index t) {
                                    const std::array<Vec3, 3> corners = mesh.corners(t);
                                    return std::any_of(corners.begin(), corners.end(),
                                                       [&](const Vec3& p) { return plane.height(p) > rounding; });
                                });
    };
    parallel_for(exposures.size(), 256, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto t = static_cast<Index>(i);
            const Vec3& n = mesh.normals[t];
            const double offset = n.dot(mesh.corner(t, 0));
            if (is_above({-n, -offset})) {
                exposures[i] = is_above({n, offset}) ? Exposure::both : Exposure::behind;
            }
        }
    });
    return exposures;
}

std::vector<Index> occluders(const std::vector<Exposure>& exposures) {
    std::vector<Index> faces;
    for (Index t = 0; t < exposures.size(); ++t) {
        if (exposures[t] == Exposure::both) {
            faces.push_back(t);
        }
    }
    return faces;
}

} // namespace difusa
