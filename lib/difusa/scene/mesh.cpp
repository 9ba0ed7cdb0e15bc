#include <difusa/scene/mesh.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <numeric>
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

} // namespace

void Mesh::derive() {
    const std::size_t count = triangles.size();
    DIFUSA_REQUIRE(count > 0 && original_face.size() == count && material.size() == count);
    normals.resize(count);
    areas.resize(count);
    area = 0.0;
    low = high = corner(0, 0);
    for (std::size_t t = 0; t < count; ++t) {
        const auto [a, b, c] = triangles[t];
        // Of the three edges the two shorter ones make the cross product with the least rounding error.
        const Vec3 ab = points[b] - points[a], bc = points[c] - points[b], ca = points[a] - points[c];
        const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
        const Vec3 cross = ab2 >= bc2 && ab2 >= ca2   ? bc.cross(ca)
                           : bc2 >= ab2 && bc2 >= ca2 ? ca.cross(ab)
                                                      : ab.cross(bc);
        const double length = cross.stableNorm();
        DIFUSA_REQUIRE(length > 0.0, "triangle " + std::to_string(t));
        normals[t] = cross / length;
        areas[t] = 0.5 * length;
        area += areas[t];
        for (const Index p : {a, b, c}) {
            low = low.cwiseMin(points[p]);
            high = high.cwiseMax(points[p]);
        }
    }

    // Edges sorted by their end points bring the triangles of each edge together.
    struct Side {
        Index low, high, triangle;
        bool forward;
    };
    std::vector<Side> sides;
    sides.reserve(3 * count);
    for (std::size_t t = 0; t < count; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Index from = triangles[t][k], to = triangles[t][(k + 1) % 3];
            sides.push_back({std::min(from, to), std::max(from, to), static_cast<Index>(t), from < to});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::pair(a.low, a.high) < std::pair(b.low, b.high) ||
               (a.low == b.low && a.high == b.high && a.triangle < b.triangle);
    });
    Sets sets(count);
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) {
            ++end;
        }
        if (end == i + 2 && sides[i].forward != sides[i + 1].forward &&
            normals[sides[i].triangle].dot(normals[sides[i + 1].triangle]) > 0.0) {
            sets.unite(sides[i].triangle, sides[i + 1].triangle);
        }
        i = end;
    }
    patch.assign(count, none);
    patch_count = 0;
    for (std::size_t t = 0; t < count; ++t) {
        const Index root = sets.find(static_cast<Index>(t));
        patch[t] = root == t ? patch_count++ : patch[root];
    }
}

SurfacePoint Mesh::at(Index triangle, double u, double v) const {
    SurfacePoint x;
    x.position = (1.0 - u - v) * corner(triangle, 0) + u * corner(triangle, 1) + v * corner(triangle, 2);
    x.normal = normals[triangle];
    x.face = triangle;
    x.u = u;
    x.v = v;
    return x;
}

} // namespace difusa
