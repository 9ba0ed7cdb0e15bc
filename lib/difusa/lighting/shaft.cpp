#include <difusa/lighting/shaft.h>

#include <difusa/mesh/triangle_tree.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace difusa {

namespace {

/// Points with normal·p < offset are outside.
struct HalfSpace {
    Vec3 normal;
    double offset;
};

std::vector<Index> all_triangles(const Mesh& mesh) {
    std::vector<Index> numbers(mesh.triangles.size());
    std::iota(numbers.begin(), numbers.end(), Index{0});
    return numbers;
}

} // namespace

Shafts::Shafts(const Mesh& mesh)
    : mesh_(mesh), faces_(tree_of_triangles(mesh, all_triangles(mesh))), rounding_(mesh.magnitude() * 0x1p-44) {}

bool Shafts::may_be_blocked(const SurfacePoint& x, Index t) const {
    const Vec3 &a = mesh_.corner(t, 0), &b = mesh_.corner(t, 1), &c = mesh_.corner(t, 2);
    std::array<HalfSpace, 5> planes;
    std::size_t count = 0;
    const auto add = [&](const Vec3& inwards, const Vec3& through) {
        const double length = inwards.norm();
        if (length > 0.0) { // otherwise the tetrahedron is flat there, and the plane cuts nothing off
            planes[count++] = {inwards / length, inwards.dot(through) / length};
        }
    };
    // x sees the front of t, so its corners run clockwise around the tetrahedron's sides.
    add((b - x.position).cross(a - x.position), x.position);
    add((c - x.position).cross(b - x.position), x.position);
    add((a - x.position).cross(c - x.position), x.position);
    add(mesh_.normals[t], a);
    const Vec3& own = x.face == none ? x.normal : mesh_.normals[x.face];
    const auto above = [&](const Vec3& corner) { return own.dot(corner - x.position) >= 0.0; };
    if (x.normal == own || (above(a) && above(b) && above(c))) { // otherwise a shading normal sees below the face
        add(own, x.position);
    }
    BoxTree::Box around(x.position);
    around.extend(a);
    around.extend(b);
    around.extend(c);
    const auto reaches_in = [&](const BoxTree::Box& box) {
        if (!around.intersects(box)) {
            return false;
        }
        const Vec3 centre = box.center(), half = 0.5 * box.sizes();
        for (std::size_t k = 0; k < count; ++k) {
            const HalfSpace& plane = planes[k];
            if (plane.normal.dot(centre) + plane.normal.cwiseAbs().dot(half) < plane.offset - rounding_) {
                return false;
            }
        }
        return true;
    };
    return faces_.visit_where(reaches_in, [&](Index face) {
        if (face == t || face == x.face) {
            return false;
        }
        const std::array<Vec3, 3> p = mesh_.corners(face);
        // A face that merely touches the tetrahedron from outside hides no area.
        for (std::size_t k = 0; k < count; ++k) {
            const HalfSpace& plane = planes[k];
            if (std::all_of(p.begin(), p.end(),
                            [&](const Vec3& q) { return plane.normal.dot(q) <= plane.offset + rounding_; })) {
                return false;
            }
        }
        // Nor does one whose plane has the whole tetrahedron on one side.
        const Vec3& n = mesh_.normals[face];
        const double height = n.dot(p[0]);
        double least = 0.0, most = 0.0;
        for (const Vec3& q : {x.position, a, b, c}) {
            least = std::min(least, n.dot(q) - height);
            most = std::max(most, n.dot(q) - height);
        }
        return least < -rounding_ && most > rounding_;
    });
}

} // namespace difusa
