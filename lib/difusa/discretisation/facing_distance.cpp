#include <difusa/discretisation/facing_distance.h>

#include <difusa/discretisation/separators.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/mesh/triangle_tree.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace difusa {

namespace {

BoxTree tree_of_all_triangles(const Mesh& mesh) {
    std::vector<Index> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), Index{0});
    return tree_of_triangles(mesh, all);
}

/// The part of a triangle that lies above a plane: a convex polygon of at most four corners.
struct PartAbove {
    std::array<Vec3, 4> corner;
    std::size_t count = 0;

    /// `height`: of the corners above the plane.
    PartAbove(const std::array<Vec3, 3>& corners, const std::array<double, 3>& height) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t next = (k + 1) % 3;
            if (height[k] >= 0.0) {
                corner[count++] = corners[k];
            }
            if ((height[k] >= 0.0) != (height[next] >= 0.0)) {
                corner[count++] = corners[k] + (corners[next] - corners[k]) * (height[k] / (height[k] - height[next]));
            }
        }
    }
};

} // namespace

FacingDistance::FacingDistance(const Mesh& mesh)
    : mesh_(mesh), rounding_(wall_rounding(mesh)), tree_(tree_of_all_triangles(mesh)) {}

double FacingDistance::of_triangle(Index triangle, const SurfacePoint& x, double least) const {
    std::array<Vec3, 3> corners;
    std::array<double, 3> height{};
    for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = mesh_.points[mesh_.triangles[triangle][k]];
        height[k] = x.normal.dot(corners[k] - x.position);
    }
    if (*std::max_element(height.begin(), height.end()) <= rounding_) {
        return least;
    }
    const Vec3& normal = mesh_.normals[triangle];
    const double before = normal.dot(x.position - corners[0]) < 0.0 ? -1.0 : 1.0;
    const double facing = 0.5 * (1.0 - before * normal.dot(x.normal)); // sin²(β/2)
    const PartAbove part(corners, height);
    for (std::size_t k = 2; k < part.count; ++k) {
        const std::array<double, 3> w =
            nearest_on_triangle(x.position, part.corner[0], part.corner[k - 1], part.corner[k]);
        const Vec3 y = w[0] * part.corner[0] + w[1] * part.corner[k - 1] + w[2] * part.corner[k];
        const double distance = (y - x.position).norm();
        if (distance < least * facing) {
            least = distance / facing;
        }
    }
    return least;
}

double FacingDistance::operator()(const SurfacePoint& x, double reach) const {
    double least = reach;
    const double plane = x.normal.dot(x.position) + rounding_;
    const auto may_be_nearer = [&](const BoxTree::Box& box) {
        return box.squaredExteriorDistance(x.position) < least * least &&
               x.normal.dot(box.center()) + 0.5 * x.normal.cwiseAbs().dot(box.sizes()) > plane;
    };
    tree_.visit_where(may_be_nearer, [&](Index triangle) {
        if (triangle != x.face) {
            least = of_triangle(triangle, x, least);
        }
        return false;
    });
    return least;
}

} // namespace difusa
