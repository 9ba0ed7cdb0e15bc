#include <difusa/mesh/nearest_surface.h>

#include <difusa/mesh/mesh.h>
#include <difusa/mesh/triangle_area.h>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace difusa {

namespace {

using Cartesian = CGAL::Simple_cartesian<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Surface {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    std::vector<Vec3> normals;  ///< #T, unit, or zero for zero-area triangles
    std::vector<Index> numbers; ///< of the triangles with nonzero area
    double magnitude = 0.0;     ///< largest absolute coordinate

    const Vec3& corner(Index t, std::size_t k) const { return points[triangles[t][k]]; }
};

/// A triangle by its number; the coordinates remain in the surface.
class Primitive {
  public:
    using Id = Index;
    using Point = Cartesian::Point_3;
    using Datum = Cartesian::Triangle_3;
    using Shared_data = const Surface*;

    Primitive(std::vector<Index>::const_iterator number, const Surface* /*surface*/) : id_(*number) {}
    const Id& id() const { return id_; }
    static Shared_data construct_shared_data(const Surface* surface) { return surface; }
    Datum datum(const Surface* surface) const {
        return {reference_point(surface), point(surface->corner(id_, 1)), point(surface->corner(id_, 2))};
    }
    Point reference_point(const Surface* surface) const { return point(surface->corner(id_, 0)); }

  private:
    static Point point(const Vec3& p) { return {p[0], p[1], p[2]}; }
    Id id_;
};

using Traits = CGAL::AABB_traits<Cartesian, Primitive>;
using Node = CGAL::AABB_node<Traits>;
using Place = NearestSurface::Place;
using Query = NearestSurface::Query;

double distance_to(const CGAL::Bbox_3& box, const Vec3& p) {
    Vec3 outside;
    for (int axis = 0; axis < 3; ++axis) {
        outside[axis] = std::max({0.0, (box.min)(axis)-p[axis], p[axis] - (box.max)(axis)});
    }
    return outside.norm();
}

/// CGAL's traversal traits: collects all triangles facing the query's way that are as near as the nearest.
class Search {
  public:
    using Priority = double;
    Search(const Surface& surface, const Query& query)
        : surface_(surface), query_(query), slack_(64.0 * std::numeric_limits<double>::epsilon() *
                                                   std::max(surface.magnitude, query.position.cwiseAbs().maxCoeff())) {}

    bool go_further() const { return true; }
    bool do_intersect(const Query& query, const Node& node) const {
        return distance_to(node.bbox(), query.position) <= least_ + slack_;
    }
    std::pair<bool, Priority> do_intersect_with_priority(const Query& query, const Node& node) const {
        const double distance = distance_to(node.bbox(), query.position);
        return {distance <= least_ + slack_, -distance};
    }
    void intersection(const Query& query, const Primitive& primitive) {
        const Index t = primitive.id();
        if (query.normal != Vec3::Zero() && !(surface_.normals[t].dot(query.normal) > perpendicular)) {
            return;
        }
        const auto [point, weight] = nearest_on(t, query.position);
        const double distance = (point - query.position).norm();
        if (distance <= least_ + slack_) {
            candidates_.push_back({t, distance, weight});
            least_ = std::min(least_, distance);
        }
    }

    Place best() const {
        // Rounding decides nothing: among triangles equally near, and equally far from the requested side, the number
        // decides.
        std::vector<std::pair<double, const Place*>> level;
        double least_aside = infinity;
        for (const Place& place : candidates_) {
            if (place.distance <= least_ + slack_) { // the others were nearest only until now
                level.emplace_back((nearest_on(place.triangle, query_.toward).first - query_.toward).norm(), &place);
                least_aside = std::min(least_aside, level.back().first);
            }
        }
        Place best;
        for (const auto& [aside, place] : level) {
            if (aside <= least_aside + slack_ && place->triangle < best.triangle) {
                best = *place;
            }
        }
        return best;
    }

  private:
    std::pair<Vec3, std::array<double, 3>> nearest_on(Index t, const Vec3& p) const {
        const Vec3 &a = surface_.corner(t, 0), &b = surface_.corner(t, 1), &c = surface_.corner(t, 2);
        const std::array<double, 3> w = nearest_on_triangle(p, a, b, c);
        return {w[0] * a + w[1] * b + w[2] * c, w};
    }

    const Surface& surface_;
    const Query& query_;
    double slack_;
    double least_ = infinity;
    std::vector<Place> candidates_;
};

} // namespace

struct NearestSurface::Tree {
    Surface surface;
    CGAL::AABB_tree<Traits> tree;
};

NearestSurface::NearestSurface(std::vector<Vec3> points, std::vector<std::array<Index, 3>> triangles)
    : tree_(std::make_unique<Tree>()) {
    Surface& surface = tree_->surface;
    surface.points = std::move(points);
    surface.triangles = std::move(triangles);
    for (const Vec3& p : surface.points) {
        surface.magnitude = std::max(surface.magnitude, p.cwiseAbs().maxCoeff());
    }
    surface.normals.reserve(surface.triangles.size());
    for (Index t = 0; t < surface.triangles.size(); ++t) {
        const Vec3 &a = surface.corner(t, 0), &b = surface.corner(t, 1), &c = surface.corner(t, 2);
        const bool area = !without_area(a, b, c);
        surface.normals.push_back(area ? twice_vector_area(a, b, c).stableNormalized() : Vec3(Vec3::Zero()));
        if (area) {
            surface.numbers.push_back(t);
        }
    }
    tree_->tree.insert(surface.numbers.cbegin(), surface.numbers.cend(), &surface);
    tree_->tree.build();
}

NearestSurface::~NearestSurface() = default;
NearestSurface::NearestSurface(NearestSurface&&) noexcept = default;
NearestSurface& NearestSurface::operator=(NearestSurface&&) noexcept = default;

NearestSurface::Place NearestSurface::nearest(const Query& query) const {
    Search search(tree_->surface, query);
    if (!tree_->tree.empty()) {
        tree_->tree.traversal_with_priority(query, search);
    }
    return search.best();
}

std::array<double, 3> nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const std::array<Vec3, 3> corner{a - p, b - p, c - p};
    const double unit =
        std::max({(b - a).cwiseAbs().maxCoeff(), (c - a).cwiseAbs().maxCoeff(), std::numeric_limits<double>::min()});
    const std::array<Vec3, 3> edge{(c - b) / unit, (a - c) / unit, (b - a) / unit}; // opposite of each corner
    const Vec3 normal = twice_vector_area(Vec3::Zero(), (b - a) / unit, (c - a) / unit);
    // Projecting to the inside: areas of the triangles that p forms with the edges.
    std::array<double, 3> weight{};
    double sum = 0.0;
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
        weight[k] = normal.dot(edge[k].cross(corner[(k + 2) % 3] / -unit));
        inside = inside && weight[k] >= 0.0;
        sum += weight[k];
    }
    if (inside && sum > 0.0) {
        return {weight[0] / sum, weight[1] / sum, weight[2] / sum};
    }
    // Otherwise the nearest point of the outline.
    double least = infinity;
    std::array<double, 3> best{};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t from = (k + 1) % 3, to = (k + 2) % 3;
        const double length2 = edge[k].squaredNorm();
        const double t = length2 > 0.0 ? std::clamp(-corner[from].dot(edge[k]) / unit / length2, 0.0, 1.0) : 0.0;
        const double distance = (corner[from] + t * unit * edge[k]).norm();
        if (distance < least) {
            least = distance;
            best = {};
            best[from] = 1.0 - t;
            best[to] = t;
        }
    }
    return best;
}

} // namespace difusa
