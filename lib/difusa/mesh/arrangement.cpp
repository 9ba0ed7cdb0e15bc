#include <difusa/mesh/arrangement.h>

#include <difusa/core/box_tree.h>

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace difusa {

namespace {

using Vec2 = Eigen::Vector2d;

/// Of a vertex, in Arrangement::points.
struct PointNumber {
    Index value = none;
};

using ExactPredicates = CGAL::Exact_predicates_inexact_constructions_kernel;
using NumberedVertex = CGAL::Triangulation_vertex_base_with_info_2<PointNumber, ExactPredicates>;
using Faces = CGAL::Constrained_triangulation_face_base_2<ExactPredicates>;
using Constrained = CGAL::Constrained_Delaunay_triangulation_2<
    ExactPredicates, CGAL::Triangulation_data_structure_2<NumberedVertex, Faces>, CGAL::Exact_predicates_tag>;

/// Numbers the vertices that are crossings.
void number_crossings(Constrained& delaunay, std::vector<Vec2>& points) {
    std::vector<Constrained::Vertex_handle> crossings;
    for (const Constrained::Vertex_handle vertex : delaunay.finite_vertex_handles()) {
        if (vertex->info().value == none) {
            crossings.push_back(vertex);
        }
    }
    std::sort(crossings.begin(), crossings.end(), [](const auto& a, const auto& b) { return a->point() < b->point(); });
    for (const Constrained::Vertex_handle vertex : crossings) {
        vertex->info().value = static_cast<Index>(points.size());
        points.emplace_back(vertex->point().x(), vertex->point().y());
    }
}

/// Points of the plane, found by their places.
class PointsNear {
  public:
    PointsNear(std::span<const Vec2> points, double rounding) : rounding_(rounding) {
        std::vector<BoxTree::Box> boxes;
        std::vector<Index> items(points.size());
        for (const Vec2& p : points) {
            boxes.emplace_back(Vec3(p.x(), p.y(), 0.0));
        }
        std::iota(items.begin(), items.end(), Index{0});
        tree_ = BoxTree(boxes, items);
    }

    /// Calls `act` for those in the box of a and b, with a margin.
    template <class Act> void visit(const Vec2& a, const Vec2& b, const Act& act) const {
        const Vec2 low = a.cwiseMin(b).array() - rounding_, high = a.cwiseMax(b).array() + rounding_;
        tree_.visit({Vec3(low.x(), low.y(), 0.0), Vec3(high.x(), high.y(), 0.0)}, [&](Index i, const BoxTree::Box&) {
            act(i);
            return false;
        });
    }

  private:
    double rounding_;
    BoxTree tree_;
};

/// For each point the first one that is as good as at the same place.
std::vector<Index> first_at_place(std::span<const Vec2> points, const PointsNear& near, double rounding) {
    std::vector<Index> first(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        first[i] = static_cast<Index>(i);
        near.visit(points[i], points[i], [&](Index other) {
            if (other < first[i] && first[other] == other && (points[other] - points[i]).norm() <= rounding) {
                first[i] = other;
            }
        });
    }
    return first;
}

/// The corners of a polygonal line from one point to another through those which the segment passes closely.
std::vector<Index> through_points(Index from, Index to, std::span<const Vec2> points, const std::vector<Index>& first,
                                  const PointsNear& near, double rounding) {
    const Vec2 &a = points[from], side = points[to] - a;
    const double length = side.norm();
    std::vector<std::pair<double, Index>> passed;
    near.visit(a, points[to], [&](Index other) {
        const Vec2 p = points[other] - a;
        const double along = p.dot(side) / length, beside = (p.x() * side.y() - p.y() * side.x()) / length;
        if (first[other] == other && other != from && other != to && along > 0.0 && along < length &&
            std::abs(beside) <= rounding) {
            passed.emplace_back(along, other);
        }
    });
    std::sort(passed.begin(), passed.end());
    std::vector<Index> line{from};
    for (const auto& [along, other] : passed) {
        line.push_back(other);
    }
    line.push_back(to);
    return line;
}

/// The points in which segments cross, which are neither's end. Three that cross at one place have crossings that
/// differ by rounding: they are merged like other points, before the triangulation would cross them once more.
std::vector<Vec2> crossings_of(std::span<const Vec2> points, std::span<const std::pair<Index, Index>> segments) {
    std::vector<BoxTree::Box> boxes;
    std::vector<Index> items(segments.size());
    const auto in_space = [&](Index i) { return Vec3(points[i].x(), points[i].y(), 0.0); };
    for (const auto& [from, to] : segments) {
        BoxTree::Box box(in_space(from));
        boxes.push_back(box.extend(in_space(to)));
    }
    std::iota(items.begin(), items.end(), Index{0});
    const BoxTree tree(boxes, items);
    const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
    std::vector<Vec2> crossings;
    for (Index s = 0; s < segments.size(); ++s) {
        const Vec2 &p = points[segments[s].first], side = points[segments[s].second] - p;
        std::vector<Index> others;
        tree.visit(boxes[s], [&](Index t, const BoxTree::Box&) {
            if (t > s) {
                others.push_back(t);
            }
            return false;
        });
        std::sort(others.begin(), others.end());
        for (const Index t : others) {
            const Vec2 &q = points[segments[t].first], other = points[segments[t].second] - q;
            const double sine = cross(side, other);
            const double along = cross(q - p, other) / sine, along_other = cross(q - p, side) / sine;
            if (along > 0.0 && along < 1.0 && along_other > 0.0 && along_other < 1.0) { // not if they are parallel
                crossings.emplace_back(p + along * side);
            }
        }
    }
    return crossings;
}

/// The points, and the places of crossings where none of them is.
std::vector<Vec2> with_crossings(std::span<const Vec2> points, std::span<const std::pair<Index, Index>> segments,
                                 double rounding) {
    std::vector<Vec2> all(points.begin(), points.end());
    const std::vector<Vec2> crossings = crossings_of(points, segments);
    all.insert(all.end(), crossings.begin(), crossings.end());
    const std::vector<Index> first = first_at_place(all, PointsNear(all, rounding), rounding);
    std::vector<Vec2> distinct(points.begin(), points.end());
    for (std::size_t i = points.size(); i < all.size(); ++i) {
        if (first[i] == i) {
            distinct.push_back(all[i]);
        }
    }
    return distinct;
}

} // namespace

Arrangement arrange(std::span<const Vec2> given, std::span<const std::pair<Index, Index>> segments, double rounding) {
    const std::vector<Vec2> points = with_crossings(given, segments, rounding);
    Arrangement result{points, {}};
    const PointsNear near(points, rounding);
    const std::vector<Index> first = first_at_place(points, near, rounding);
    Constrained delaunay;
    std::vector<Constrained::Vertex_handle> vertices;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (first[i] != i) {
            vertices.push_back(vertices[first[i]]);
            continue;
        }
        const Constrained::Point at(points[i].x(), points[i].y());
        vertices.push_back(vertices.empty() ? delaunay.insert(at) : delaunay.insert(at, vertices.back()->face()));
        vertices.back()->info().value = static_cast<Index>(i);
    }
    for (const auto& [from, to] : segments) {
        if (first[from] == first[to]) {
            continue;
        }
        const std::vector<Index> line = through_points(first[from], first[to], points, first, near, rounding);
        for (std::size_t k = 1; k < line.size(); ++k) {
            delaunay.insert_constraint(vertices[line[k - 1]], vertices[line[k]]);
        }
    }
    number_crossings(delaunay, result.points);
    for (const Constrained::Face_handle face : delaunay.finite_face_handles()) {
        std::array<Index, 3> triangle{face->vertex(0)->info().value, face->vertex(1)->info().value,
                                      face->vertex(2)->info().value};
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
        result.triangles.push_back(triangle);
    }
    std::sort(result.triangles.begin(), result.triangles.end()); // the order of the faces in memory is arbitrary
    return result;
}

} // namespace difusa
