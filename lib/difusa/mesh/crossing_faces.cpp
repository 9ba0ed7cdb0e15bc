#include <difusa/mesh/crossing_faces.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace difusa {

namespace {

using Predicates = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Predicates::Point_3;
using Corners = std::array<Vec3, 3>;
using Points = std::array<Point, 3>;

/// A box for CGAL's algorithm, with its triangle.
struct TriangleBox : CGAL::Box_intersection_d::Box_d<double, 3, CGAL::Box_intersection_d::ID_NONE> {
    using Base = CGAL::Box_intersection_d::Box_d<double, 3, CGAL::Box_intersection_d::ID_NONE>;
    using ID = std::size_t;
    Index triangle = none;
    TriangleBox() = default;
    TriangleBox(const Vec3& low, const Vec3& high, Index number)
        : Base(std::array<double, 3>{low.x(), low.y(), low.z()}.data(),
               std::array<double, 3>{high.x(), high.y(), high.z()}.data()),
          triangle(number) {}
    ID id() const { return triangle; }
};

Points points_of(const Corners& corners) {
    const auto point = [](const Vec3& v) { return Point(v.x(), v.y(), v.z()); };
    return {point(corners[0]), point(corners[1]), point(corners[2])};
}

/// Rotates the corners of p so that the first is alone on its side of the plane of q, and flips q if necessary so that
/// this side is the positive one. False unless p has corners on both sides.
bool straddles(Points& p, Points& q) {
    std::array<CGAL::Orientation, 3> side{};
    int above = 0, below = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        side[k] = CGAL::orientation(q[0], q[1], q[2], p[k]);
        above += side[k] == CGAL::POSITIVE ? 1 : 0;
        below += side[k] == CGAL::NEGATIVE ? 1 : 0;
    }
    if (above == 0 || below == 0) {
        return false;
    }
    const CGAL::Orientation lone = above == 1 ? CGAL::POSITIVE : CGAL::NEGATIVE;
    const auto first = std::find(side.begin(), side.end(), lone) - side.begin();
    std::rotate(p.begin(), p.begin() + first, p.end());
    if (lone == CGAL::NEGATIVE) {
        std::swap(q[1], q[2]);
    }
    return true;
}

bool cross(Points p, Points q) {
    // Guigue and Devillers, "Fast and robust triangle-triangle overlap test using orientation predicates", 2003: each
    // triangle intersects the line common to both planes in an interval; these must share more than a point.
    if (!straddles(p, q) || !straddles(q, p)) {
        return false;
    }
    return CGAL::orientation(p[0], p[1], q[0], q[1]) == CGAL::NEGATIVE &&
           CGAL::orientation(p[0], p[2], q[2], q[0]) == CGAL::NEGATIVE;
}

/// True if triangles with a common vertex certainly meet nowhere else, as is the case for almost all around a vertex: a
/// plane through the vertex separates them. Differences of coordinates have relative errors below 2^-53, and so do the
/// products.
bool parted_at(const Vec3& vertex, const std::array<Vec3, 2>& p, const std::array<Vec3, 2>& q) {
    const std::array<Vec3, 2> a{p[0] - vertex, p[1] - vertex}, b{q[0] - vertex, q[1] - vertex};
    const Vec3 towards = (a[0].stableNormalized() + a[1].stableNormalized()).stableNormalized() -
                         (b[0].stableNormalized() + b[1].stableNormalized()).stableNormalized();
    const auto beyond = [&](const Vec3& v, double sign) {
        return sign * towards.dot(v) > 0x1p-48 * towards.cwiseAbs().dot(v.cwiseAbs());
    };
    return beyond(a[0], 1.0) && beyond(a[1], 1.0) && beyond(b[0], -1.0) && beyond(b[1], -1.0);
}

/// Tests two triangles of a mesh whose boxes overlap.
bool cross(const Mesh& mesh, Index S, Index T) {
    const auto &s = mesh.triangles[S], &t = mesh.triangles[T];
    std::size_t shared = 0, at_s = 0, at_t = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            if (s[i] == t[j]) {
                ++shared;
                at_s = i;
                at_t = j;
            }
        }
    }
    if (shared > 1) {
        return false; // at an edge: they are coplanar, or meet only in the edge
    }
    const Corners p = mesh.corners(S), q = mesh.corners(T);
    if (shared == 1 &&
        parted_at(p[at_s], {p[(at_s + 1) % 3], p[(at_s + 2) % 3]}, {q[(at_t + 1) % 3], q[(at_t + 2) % 3]})) {
        return false;
    }
    return cross(points_of(p), points_of(q));
}

} // namespace

bool triangles_cross(const Corners& p, const Corners& q) {
    return cross(points_of(p), points_of(q));
}

std::optional<std::vector<std::array<Index, 2>>> find_crossing_triangles(const Mesh& mesh, const Execution& execution) {
    std::vector<TriangleBox> boxes;
    boxes.reserve(mesh.triangles.size());
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Corners c = mesh.corners(t);
        boxes.emplace_back(c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]), t);
    }
    std::vector<std::array<Index, 2>> found;
    struct TooMany {};
    const std::size_t most = 1'000'000 + 100 * boxes.size();
    std::size_t pairs = 0;
    const auto examine = [&](const TriangleBox& a, const TriangleBox& b) {
        if (++pairs > most) {
            throw TooMany();
        }
        if (pairs % 4096 == 0) {
            execution.check();
        }
        if (cross(mesh, a.triangle, b.triangle)) {
            found.push_back({std::min(a.triangle, b.triangle), std::max(a.triangle, b.triangle)});
        }
    };
    // Below this many boxes CGAL's algorithm scans instead of dividing: for small boxes a cutoff several times its
    // default is faster.
    constexpr std::ptrdiff_t cutoff = 200;
    try {
        CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), examine, cutoff);
    } catch (const TooMany&) {
        return std::nullopt;
    }
    std::sort(found.begin(), found.end());
    return found;
}

Vec3 middle_of_crossing(const Corners& p, const Corners& q) {
    // The points where sides of either cross the plane of the other: of these four along the common line, the middle
    // two.
    const auto normal = [](const Corners& c) -> Vec3 { return (c[1] - c[0]).cross(c[2] - c[0]).stableNormalized(); };
    const Vec3 along = normal(p).cross(normal(q));
    std::vector<std::pair<double, Vec3>> met;
    for (const auto& [of, other] : {std::pair(&p, &q), std::pair(&q, &p)}) {
        const Vec3 up = normal(*other);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 &a = (*of)[k], &b = (*of)[(k + 1) % 3];
            const double at_a = up.dot(a - (*other)[0]), at_b = up.dot(b - (*other)[0]);
            if ((at_a < 0.0) != (at_b < 0.0)) {
                const Vec3 place = a + at_a / (at_a - at_b) * (b - a);
                met.emplace_back(along.dot(place - p[0]), place);
            }
        }
    }
    if (met.size() < 4) {
        return met.empty() ? p[0] : met.front().second; // flat to within rounding
    }
    std::sort(met.begin(), met.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    return 0.5 * (met[1].second + met[2].second);
}

} // namespace difusa
