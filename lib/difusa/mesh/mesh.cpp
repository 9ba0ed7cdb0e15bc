#include <difusa/mesh/mesh.h>

#include <difusa/core/error.h>
#include <difusa/mesh/twins.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace difusa {

namespace {

/// Union-find with path halving; the smallest member represents its set.
class Sets {
  public:
    explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
    Index find(Index x) {
        while (parent_[x] != x) {
            parent_[x] = parent_[parent_[x]];
            x = parent_[x];
        }
        return x;
    }
    void unite(Index a, Index b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<Index> parent_;
};

using CornerNumbers = std::array<Index, 3>;

constexpr double derived_within = 1e-6; ///< relative deviation of what is derived, far above rounding

bool has_corners(const std::vector<Vec3>& points, const CornerNumbers& triangle) {
    return std::all_of(triangle.begin(), triangle.end(),
                       [&](Index p) { return p < points.size() && points[p].allFinite(); });
}

/// Twice the area, along the normal.
Vec3 cross_product(const std::vector<Vec3>& points, const CornerNumbers& triangle) {
    const auto [a, b, c] = triangle;
    // Of the three edges, the two shorter ones give the cross product with the smallest rounding error.
    const Vec3 ab = points[b] - points[a], bc = points[c] - points[b], ca = points[a] - points[c];
    const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
    return ab2 >= bc2 && ab2 >= ca2 ? bc.cross(ca) : bc2 >= ab2 && bc2 >= ca2 ? ca.cross(ab) : ab.cross(bc);
}

/// See Mesh::convex. Tested only if that takes well under a second; ends at the first point behind a plane.
bool is_convex(const Mesh& mesh) {
    constexpr double most_pairs = 2e8;
    if (static_cast<double>(mesh.triangles.size()) * static_cast<double>(mesh.points.size()) > most_pairs) {
        return false;
    }
    const double rounding = mesh.magnitude() * 0x1p-44;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3& n = mesh.normals[t];
        const double height = n.dot(mesh.corner(t, 0)) - rounding;
        for (const Vec3& point : mesh.points) {
            if (n.dot(point) < height) {
                return false;
            }
        }
    }
    return true;
}

} // namespace

void Mesh::turn_over(Index triangle) {
    std::swap(triangles[triangle][1], triangles[triangle][2]);
    if (!corner_reflectance.empty()) {
        std::swap(corner_reflectance[triangle][1], corner_reflectance[triangle][2]);
    }
    if (!corner_texture.empty()) {
        std::swap(corner_texture[triangle][1], corner_texture[triangle][2]);
    }
}

bool Mesh::is_derived() const {
    if (normals.size() != triangles.size() || areas.size() != triangles.size()) {
        return false;
    }
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (!has_corners(points, triangles[t])) {
            return false;
        }
        const Vec3 cross = cross_product(points, triangles[t]);
        const double length = cross.stableNorm();
        if (!(std::abs(0.5 * length - areas[t]) <= derived_within * areas[t]) ||
            !(cross.dot(normals[t]) >= (1.0 - derived_within) * length)) {
            return false;
        }
    }
    return true;
}

void Mesh::derive() {
    const std::size_t count = triangles.size();
    if (count == 0 || original_face.size() != count || material.size() != count) {
        throw InputError("a mesh needs at least one triangle, and an original face and a material for each");
    }
    normals.resize(count);
    areas.resize(count);
    area = 0.0;
    low = Vec3::Constant(std::numeric_limits<double>::infinity());
    high = -low;
    for (std::size_t t = 0; t < count; ++t) {
        if (!has_corners(points, triangles[t])) {
            throw InputError("triangle " + std::to_string(t) + " has a corner that is not among the " +
                             std::to_string(points.size()) + " points, or not finite");
        }
        const Vec3 cross = cross_product(points, triangles[t]);
        const double length = cross.stableNorm();
        if (!(length > 0.0 && std::isfinite(length))) {
            throw InputError("triangle " + std::to_string(t) + " has no area, or one that is out of range");
        }
        normals[t] = cross / length;
        areas[t] = 0.5 * length;
        area += areas[t];
        for (const Index p : triangles[t]) {
            low = low.cwiseMin(points[p]);
            high = high.cwiseMax(points[p]);
        }
    }

    twin = join_sides(points, triangles);
    Sets sets(count);
    for (std::size_t side = 0; side < twin.size(); ++side) {
        if (twin[side] != none && normals[side / 3].dot(normals[twin[side] / 3]) > perpendicular) {
            sets.unite(static_cast<Index>(side / 3), twin[side] / 3);
        }
    }
    region.assign(count, none);
    region_count = 0;
    for (std::size_t t = 0; t < count; ++t) {
        const Index root = sets.find(static_cast<Index>(t));
        region[t] = root == t ? region_count++ : region[root];
    }
    shading = ShadingNormals(*this);
    convex = !repetition.any() && is_convex(*this);
}

} // namespace difusa
