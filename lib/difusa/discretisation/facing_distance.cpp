#include <difusa/discretisation/facing_distance.h>

#include <difusa/discretisation/separators.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/mesh/triangle_tree.h>

#include <array>

namespace difusa {

FacingDistance::FacingDistance(const Mesh& mesh)
    : mesh_(mesh), rounding_(wall_rounding(mesh)), tree_(tree_of_triangles(mesh)) {}

double FacingDistance::of_triangle(Index triangle, const SurfacePoint& x, const Plane& tangent, double least) const {
    const FlatPolygon part = FlatPolygon(mesh_.corners(triangle)).above(tangent, rounding_);
    const Vec3& normal = mesh_.normals[triangle];
    const double before = normal.dot(x.position - mesh_.corner(triangle, 0)) < 0.0 ? -1.0 : 1.0;
    const double facing = 0.5 * (1.0 - before * normal.dot(tangent.normal)); // sin²(β/2)
    for (std::size_t k = 2; k < part.size(); ++k) {
        const std::array<double, 3> w = nearest_on_triangle(x.position, part[0], part[k - 1], part[k]);
        const Vec3 y = w[0] * part[0] + w[1] * part[k - 1] + w[2] * part[k];
        const double distance = (y - x.position).norm();
        if (distance < least * facing) {
            least = distance / facing;
        }
    }
    return least;
}

double FacingDistance::operator()(const SurfacePoint& x, double reach) const {
    double least = reach;
    const Vec3& normal = mesh_.face_normal(x); // before a shading normal lie neighbours, even of a convex surface
    const Plane tangent{normal, normal.dot(x.position)};
    const auto may_be_nearer = [&](const BoxTree::Box& box) {
        return box.squaredExteriorDistance(x.position) < least * least && tangent.highest(box) > rounding_;
    };
    tree_.visit_where(may_be_nearer, [&](Index triangle) {
        if (triangle != x.face) {
            least = of_triangle(triangle, x, tangent, least);
        }
        return false;
    });
    return least;
}

} // namespace difusa
