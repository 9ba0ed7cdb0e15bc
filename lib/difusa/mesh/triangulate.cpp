#include <difusa/mesh/triangulate.h>

#include <difusa/mesh/triangle_area.h>

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace difusa {

namespace {

using Outcome = Triangulation::Outcome;

/// Winding number of the outline around a triangle of the plane.
struct Winding {
    static constexpr int unknown = std::numeric_limits<int>::min();
    /// rise[i]: times the outline runs along the edge opposite corner i with this triangle on its left, minus the times
    /// with it on its right; this triangle's winding number exceeds its neighbour's by that much.
    std::array<int, 3> rise{};
    int number = unknown;
};

using Predicates = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Index, Predicates>;
using FaceBase = CGAL::Triangulation_face_base_with_info_2<Winding, Predicates,
                                                           CGAL::Constrained_triangulation_face_base_2<Predicates>>;
using Delaunay =
    CGAL::Constrained_Delaunay_triangulation_2<Predicates, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::No_constraint_intersection_requiring_constructions_tag>;
using Point2 = Predicates::Point_2;

/// Above this number of corners near-crossings are not searched pairwise.
constexpr std::size_t snapping_limit = 2000;

/// Plane and shape of a polygon.
struct Shape {
    Vec3 normal;  ///< Newell's: twice the vector area
    bool on_line; ///< all corners collinear to within rounding
    bool planar;  ///< see Triangulation
};

Shape measure(std::span<const Vec3> corners) {
    const std::size_t n = corners.size();
    Shape shape{Vec3::Zero(), true, true};
    // Relative to a corner, so that the distance from the origin costs no digits.
    Vec3 centre = Vec3::Zero();
    std::size_t farthest = 0;
    double magnitude = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 p = corners[i] - corners[0], q = corners[(i + 1) % n] - corners[0];
        shape.normal += p.cross(q);
        centre += p / static_cast<double>(n);
        magnitude = std::max(magnitude, corners[i].cwiseAbs().maxCoeff());
        if (p.squaredNorm() > (corners[farthest] - corners[0]).squaredNorm()) {
            farthest = i;
        }
    }
    for (std::size_t i = 0; i < n && shape.on_line; ++i) {
        shape.on_line = without_area(corners[0], corners[farthest], corners[i]);
    }
    const double length = shape.normal.stableNorm();
    if (length > 0.0) {
        double deviation = 0.0, radius = 0.0;
        for (const Vec3& corner : corners) {
            const Vec3 r = corner - corners[0] - centre;
            deviation = std::max(deviation, std::abs(r.dot(shape.normal)) / length);
            radius = std::max(radius, r.norm());
        }
        shape.planar = deviation <= 1e-6 * 2.0 * radius + 4.0 * std::numeric_limits<double>::epsilon() * magnitude;
    }
    return shape;
}

/// True if some corner turns against the others by more than rounding.
bool is_concave(std::span<const Vec3> corners, const Vec3& normal) {
    const std::size_t n = corners.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 &a = corners[i], &b = corners[(i + 1) % n], &c = corners[(i + 2) % n];
        if (twice_vector_area(a, b, c).dot(normal) < 0.0 && !without_area(a, b, c)) {
            return true;
        }
    }
    return false;
}

/// The two triangles of a quadrilateral whose corners all turn the same way by a margin beyond rounding and warp;
/// nothing for any other.
std::optional<std::vector<std::array<Index, 3>>> cut_convex_quad(std::span<const Vec3> corners, const Vec3& normal) {
    const double normal_length = normal.stableNorm();
    for (std::size_t i = 0; i < 4; ++i) {
        const Vec3 &a = corners[i], &b = corners[(i + 1) % 4], &c = corners[(i + 2) % 4];
        const Vec3 turn = twice_vector_area(a, b, c);
        if (!(turn.dot(normal) > 0.5 * turn.stableNorm() * normal_length) || // within 60° of the normal
            without_area(a, b, c)) {
            return std::nullopt;
        }
    }
    const double first = (corners[2] - corners[0]).squaredNorm(), second = (corners[3] - corners[1]).squaredNorm();
    if (first <= second * (1.0 + 2e-6)) {
        return {{{0, 1, 2}, {0, 2, 3}}};
    }
    return {{{0, 1, 3}, {1, 2, 3}}};
}

/// The corners projected to a plane in which the polygon keeps its orientation.
std::vector<Point2> project(std::span<const Vec3> corners, const Shape& shape) {
    Eigen::Index axis = 0;
    shape.normal.cwiseAbs().maxCoeff(&axis);
    std::vector<Point2> plane;
    plane.reserve(corners.size());
    if (shape.planar) {
        const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
        const bool upright = shape.normal[axis] >= 0.0;
        for (const Vec3& corner : corners) {
            plane.push_back(upright ? Point2(corner[u], corner[v]) : Point2(corner[v], corner[u]));
        }
    } else {
        const Vec3 n = shape.normal.stableNormalized();
        const Vec3 u = n.cross(Vec3::Unit((axis + 1) % 3)).normalized();
        const Vec3 v = n.cross(u);
        for (const Vec3& corner : corners) {
            const Vec3 r = corner - corners[0];
            plane.emplace_back(r.dot(u), r.dot(v));
        }
    }
    return plane;
}

/// For each corner the first one at the same position in the plane; nothing if corners that are apart in space coincide
/// there although the polygon is not planar.
std::optional<std::vector<Index>> vertices_of(std::span<const Vec3> corners, const std::vector<Point2>& plane,
                                              bool planar) {
    std::vector<Index> order(corners.size()), vertex(corners.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::sort(order.begin(), order.end(), [&](Index i, Index j) {
        return std::make_tuple(plane[i].x(), plane[i].y(), i) < std::make_tuple(plane[j].x(), plane[j].y(), j);
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const Index corner = order[i];
        vertex[corner] = corner;
        if (i > 0 && plane[order[i - 1]] == plane[corner]) {
            vertex[corner] = vertex[order[i - 1]];
            if (!planar && corners[vertex[corner]] != corners[corner]) {
                return std::nullopt;
            }
        }
    }
    return vertex;
}

/// The outline as a closed walk over vertices (numbers of corners).
using Walk = std::vector<Index>;

/// The walk that also stops at every corner lying on a side to within rounding; unchanged if there is none.
Walk snapped(const Walk& walk, std::span<const Vec3> corners) {
    std::vector<Index> distinct = walk;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    Walk finer;
    std::vector<std::pair<double, Index>> on_side;
    for (std::size_t k = 0; k < walk.size(); ++k) {
        const Index from = walk[k], to = walk[(k + 1) % walk.size()];
        const Vec3 side = corners[to] - corners[from];
        on_side.clear();
        for (const Index other : distinct) {
            const double t = (corners[other] - corners[from]).dot(side) / side.squaredNorm();
            if (other != from && other != to && t > 0.0 && t < 1.0 &&
                without_area(corners[from], corners[to], corners[other])) {
                on_side.emplace_back(t, other);
            }
        }
        std::sort(on_side.begin(), on_side.end());
        finer.push_back(from);
        for (const auto& [t, other] : on_side) {
            finer.push_back(other);
        }
    }
    return finer;
}

/// Gives every triangle its winding number, from 0 outside inwards.
void number_windings(Delaunay& delaunay) {
    std::vector<Delaunay::Face_handle> open{delaunay.infinite_face()};
    open.back()->info().number = 0;
    while (!open.empty()) {
        const Delaunay::Face_handle face = open.back();
        open.pop_back();
        for (int i = 0; i < 3; ++i) {
            const Delaunay::Face_handle next = face->neighbor(i);
            if (next->info().number == Winding::unknown) {
                next->info().number = face->info().number - face->info().rise[static_cast<std::size_t>(i)];
                open.push_back(next);
            }
        }
    }
}

/// Counts a side, which may be several edges in a row, as traversed once: against `direction` if that is -1.
void count_run(const Delaunay& delaunay, Delaunay::Vertex_handle here, Delaunay::Vertex_handle last, int direction) {
    while (here != last) {
        Delaunay::Vertex_handle next;
        Delaunay::Face_handle face;
        int i = 0;
        delaunay.includes_edge(here, last, next, face, i);
        const int rise = face->vertex(Delaunay::ccw(i)) == here ? direction : -direction;
        face->info().rise[static_cast<std::size_t>(i)] += rise;
        face->neighbor(i)->info().rise[static_cast<std::size_t>(delaunay.mirror_index(face, i))] -= rise;
        here = next;
    }
}

/// Winding number 1 is inside; the direction must be the same throughout.
void collect_inside(const Delaunay& delaunay, std::span<const Vec3> corners, Triangulation& result) {
    int direction = 0;
    for (const Delaunay::Face_handle face : delaunay.finite_face_handles()) {
        const int number = face->info().number;
        if (number == 0) {
            continue;
        }
        std::array<Index, 3> triangle{face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()};
        if ((number != 1 && number != -1) || (direction != 0 && number != direction)) {
            result.place = corners[triangle[0]];
            result.triangles.clear();
            return;
        }
        direction = number;
        if (number < 0) {
            std::swap(triangle[1], triangle[2]);
        }
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
        result.triangles.push_back(triangle);
    }
    // The order in which the triangulation stores its faces is arbitrary: the polygon's own order is used.
    std::sort(result.triangles.begin(), result.triangles.end());
    result.outcome = result.triangles.empty() ? Outcome::no_area : Outcome::done;
}

/// Triangulates the region enclosed by the walk. Sets the outcome and triangles of `result`, and its place on a
/// crossing.
void triangulate_walk(const Walk& walk, const std::vector<Point2>& plane, std::span<const Vec3> corners,
                      Triangulation& result) {
    const std::size_t n = walk.size();
    result.outcome = Outcome::crosses_itself;
    result.triangles.clear();

    // 1. The distinct corners, and where each of them is in the triangulation.
    std::vector<std::pair<Point2, Index>> points;
    std::vector<Index> visits(corners.size(), 0);
    for (const Index vertex : walk) {
        if (visits[vertex]++ == 0) {
            points.emplace_back(plane[vertex], vertex);
        }
    }
    Delaunay delaunay;
    delaunay.insert(points.begin(), points.end());
    std::vector<Delaunay::Vertex_handle> handle(corners.size());
    for (const Delaunay::Vertex_handle vertex : delaunay.finite_vertex_handles()) {
        handle[vertex->info()] = vertex;
    }

    // The triangulation visits all neighbours of a side's first end: the end shared by fewer sides goes first, so that
    // a corner visited n times does not cost n² visits.
    const auto side = [&](std::size_t k) {
        const Index from = walk[k], to = walk[(k + 1) % n];
        const bool forward = visits[from] <= visits[to];
        return std::make_tuple(handle[forward ? from : to], handle[forward ? to : from], forward ? 1 : -1);
    };

    // 2. The sides as constraints. Stops here if a side meets the interior of another.
    for (std::size_t k = 0; k < n; ++k) {
        const auto [first, last, direction] = side(k);
        try {
            if (first != last) {
                delaunay.insert_constraint(first, last);
            }
        } catch (const Delaunay::Intersection_of_constraints_exception&) {
            result.place = corners[walk[k]];
            return;
        }
    }
    if (delaunay.dimension() < 2) {
        result.place = corners[walk[0]];
        return;
    }

    // 3. How often and in which direction each edge is traversed, and thus what is inside.
    for (std::size_t k = 0; k < n; ++k) {
        const auto [first, last, direction] = side(k);
        count_run(delaunay, first, last, direction);
    }
    number_windings(delaunay);
    collect_inside(delaunay, corners, result);
}

/// True if rounding may have moved a corner across a side it lies on, or so far away from it that a zero-area triangle
/// fills the gap.
bool touches_itself(const Triangulation& result, std::span<const Vec3> corners) {
    return result.outcome == Outcome::crosses_itself ||
           std::any_of(result.triangles.begin(), result.triangles.end(), [&](const std::array<Index, 3>& t) {
               return without_area(corners[t[0]], corners[t[1]], corners[t[2]]);
           });
}

} // namespace

Triangulation triangulate(std::span<const Vec3> corners) {
    Triangulation result;
    if (corners.size() <= 3) {
        if (corners.size() < 3 || without_area(corners[0], corners[1], corners[2])) {
            result.outcome = Outcome::no_area;
        } else {
            result.triangles = {{0, 1, 2}};
        }
        return result;
    }
    const Shape shape = measure(corners);
    if (shape.on_line) {
        result.outcome = Outcome::no_area;
        return result;
    }
    result.planar = shape.planar;
    if (corners.size() == 4) {
        if (auto triangles = cut_convex_quad(corners, shape.normal)) {
            result.triangles = std::move(*triangles);
            return result;
        }
    }
    result.concave = is_concave(corners, shape.normal);
    const std::vector<Point2> plane = project(corners, shape);
    std::optional<std::vector<Index>> vertices = vertices_of(corners, plane, shape.planar);
    if (!vertices) {
        result.outcome = Outcome::crosses_itself;
        result.place = corners[0];
        return result;
    }
    const Walk walk = std::move(*vertices);
    triangulate_walk(walk, plane, corners, result);
    if (touches_itself(result, corners) && corners.size() <= snapping_limit) {
        const Walk finer = snapped(walk, corners);
        if (finer.size() > walk.size()) {
            triangulate_walk(finer, plane, corners, result);
        }
    }
    return result;
}

} // namespace difusa
