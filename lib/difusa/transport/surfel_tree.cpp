#include <difusa/transport/surfel_tree.h>

#include <difusa/core/error.h>
#include <difusa/core/frame.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace difusa {

namespace {

constexpr double tree_rounding = 1e-9; ///< of areas, and of normals in one plane

/// The corners of the convex hull, counterclockwise around the normal. Changes the order of the points.
std::vector<Vec3> convex_hull(std::vector<Vec3>& points, const Vec3& normal) {
    Vec3 tangent, bitangent;
    tangents(normal, tangent, bitangent);
    struct Planar {
        double x, y;
        Index number;
    };
    std::vector<Planar> sorted;
    double size = 0.0;
    for (const Vec3& p : points) {
        const Vec3 way = p - points[0];
        sorted.push_back({tangent.dot(way), bitangent.dot(way), static_cast<Index>(sorted.size())});
        size = std::max(size, way.norm());
    }
    std::sort(sorted.begin(), sorted.end(), [](const Planar& a, const Planar& b) {
        return a.x != b.x ? a.x < b.x : (a.y != b.y ? a.y < b.y : a.number < b.number);
    });
    const double least = tree_rounding * size * size;
    std::vector<Planar> hull;
    const auto add_side = [&](const auto begin, const auto end) {
        const std::size_t start = hull.size();
        for (auto p = begin; p != end; ++p) {
            while (hull.size() >= start + 2) {
                const Planar &a = hull[hull.size() - 2], &b = hull.back();
                if ((b.x - a.x) * (p->y - a.y) - (b.y - a.y) * (p->x - a.x) > least) {
                    break;
                }
                hull.pop_back();
            }
            hull.push_back(*p);
        }
        hull.pop_back(); // where the other side starts
    };
    add_side(sorted.begin(), sorted.end());
    add_side(sorted.rbegin(), sorted.rend());
    std::vector<Vec3> corners;
    for (const Planar& p : hull) {
        corners.push_back(points[p.number]);
    }
    return corners;
}

double area_of(const std::vector<Vec3>& polygon, const Vec3& normal) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 2; k < polygon.size(); ++k) {
        sum += (polygon[k - 1] - polygon[0]).cross(polygon[k] - polygon[0]);
    }
    return 0.5 * normal.dot(sum);
}

/// The edges of both that are not shared in opposite directions.
std::vector<SurfelTree::Edge> united(const std::vector<SurfelTree::Edge>& a, const std::vector<SurfelTree::Edge>& b) {
    using Edge = SurfelTree::Edge;
    std::vector<Edge> all = a;
    all.insert(all.end(), b.begin(), b.end());
    const auto key = [](const Edge& edge) { return std::minmax(edge.from, edge.to); };
    std::stable_sort(all.begin(), all.end(), [&](const Edge& p, const Edge& q) { return key(p) < key(q); });
    std::vector<Edge> left;
    for (const Edge& edge : all) {
        if (!left.empty() && left.back().from == edge.to && left.back().to == edge.from) {
            left.pop_back();
        } else {
            left.push_back(edge);
        }
    }
    return left;
}

} // namespace

Values SurfelGroups::moments_of(const Values& of_surfels) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(of_surfels.rows()) >= surfels_);
    Values result(static_cast<Eigen::Index>(moments * groups_.size()), of_surfels.cols());
    for (Index g = 0; g < groups_.size(); ++g) {
        const Group& group = groups_[g];
        auto own = result.middleRows<moments>(mean_row(g));
        own.setZero();
        if (group.second == none) {
            own.row(0) = of_surfels.row(group.first);
            continue;
        }
        for (const Index half : {group.first, group.second}) {
            const auto part = result.middleRows<moments>(mean_row(half));
            const double share = groups_[half].area / group.area;
            const Vec3 way = groups_[half].centre - group.centre;
            own += share * part;
            own.bottomRows<3>() += share * way * part.row(0);
        }
    }
    return result;
}

void SurfelGroups::add_transposed(Values& of_groups, Values& of_surfels) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(of_groups.rows()) == moments * groups_.size());
    for (Index g = static_cast<Index>(groups_.size()); g-- > 0;) {
        const Group& group = groups_[g];
        const auto own = of_groups.middleRows<moments>(mean_row(g));
        if (group.second == none) {
            of_surfels.row(group.first) += own.row(0);
            continue;
        }
        for (const Index half : {group.first, group.second}) {
            auto part = of_groups.middleRows<moments>(mean_row(half));
            const double share = groups_[half].area / group.area;
            const Vec3 way = groups_[half].centre - group.centre;
            part += share * own;
            part.row(0) += share * way.transpose() * own.bottomRows<3>();
        }
    }
}

/// Builds a tree from its surfels upwards.
class SurfelTreeBuilder {
  public:
    SurfelTreeBuilder(const Mesh& mesh, const Surfels& surfels, const std::vector<Exposure>& exposures,
                      const std::vector<std::uint8_t>& overlaid, SurfelTree& tree)
        : mesh_(mesh), surfels_(surfels), tree_(tree), exposures_(exposures), overlaid_(overlaid) {}

    void build() {
        sort_surfels();
        // By region, then by plane: normals and offsets that differ by rounding may be sorted apart, which costs time.
        std::map<Index, std::map<std::array<long, 4>, std::vector<Part>>> regions;
        for (Index t = 0; t < squares_.size(); ++t) {
            if (!squares_[t].empty()) {
                regions[mesh_.region[t]][plane_of(t)].push_back(triangle(t));
            }
        }
        for (const Index s : clusters_) {
            Part part = cluster(s);
            const Index t = part.triangle;
            regions[mesh_.region[t]][part.flat ? plane_of(t) : std::array<long, 4>{}].push_back(std::move(part));
        }
        std::vector<Part> roots;
        for (auto& [region, planes] : regions) {
            std::vector<Part> parts;
            for (auto& [plane, in_plane] : planes) {
                if (in_plane.front().flat) {
                    parts.push_back(united_all(in_plane));
                } else {
                    parts.insert(parts.end(), std::make_move_iterator(in_plane.begin()),
                                 std::make_move_iterator(in_plane.end()));
                }
            }
            roots.push_back(united_all(parts));
            roots.back().whole = false; // regions do not make patches together
        }
        if (!roots.empty()) {
            united_all(roots);
        }
        tree_.groups_ = SurfelGroups(std::move(groups_), surfels_.size());
    }

  private:
    /// A group while its parent is made.
    struct Part {
        Index group = none;
        Index triangle = none; ///< one of its triangles
        bool flat = false;
        bool whole = false;                  ///< consists of whole triangles, with the outline `edges`
        Exposure exposure = Exposure::both;  ///< of all its faces
        Vec3 normal = Vec3::Zero();          ///< flat: unit
        std::vector<Vec3> hull;              ///< flat: convex, counterclockwise
        std::vector<SurfelTree::Edge> edges; ///< whole
        BoxTree::Box box;
        Vec3 centre() const { return box.center(); }
    };

    /// Those in squares by triangle, clusters of whole triangles apart; others are in no group.
    void sort_surfels() {
        squares_.resize(mesh_.triangles.size());
        std::vector<Surfels::Piece> pieces;
        for (Index s = 0; s < surfels_.size(); ++s) {
            if (!(surfels_.area(s) > 0.0)) {
                continue;
            }
            surfels_.pieces(s, pieces);
            if (std::any_of(pieces.begin(), pieces.end(),
                            [&](const Surfels::Piece& piece) { return overlaid_[piece.triangle] != 0; })) {
                continue;
            }
            if (surfels_.square(s)) {
                squares_[pieces.front().triangle].push_back({s, *surfels_.square(s)});
                continue;
            }
            double area = 0.0;
            for (const Surfels::Piece& piece : pieces) {
                area += mesh_.areas[piece.triangle];
            }
            if (std::abs(area - surfels_.area(s)) <= tree_rounding * area) {
                clusters_.push_back(s);
            }
        }
    }

    std::array<long, 4> plane_of(Index t) const {
        const double unit = 1e-7;
        const Vec3& n = mesh_.normals[t];
        const double offset = n.dot(mesh_.corner(t, 0) - mesh_.low) / mesh_.diameter();
        return {std::lround(n[0] / unit), std::lround(n[1] / unit), std::lround(n[2] / unit),
                std::lround(offset / unit)};
    }

    /// Adds a group of this shape, and notes it in `part`.
    void add(const SurfelGroups::Group& group, Part& part) {
        part.group = static_cast<Index>(groups_.size());
        groups_.push_back(group);
        SurfelTree::Node node;
        node.flat = part.flat;
        node.normal = part.normal;
        node.box = part.box;
        node.exposure = part.exposure;
        if (part.flat) {
            node.offset = part.normal.dot(part.hull.front());
        }
        if (part.flat && part.hull.size() >= 3 && part.hull.size() <= most_corners &&
            std::abs(area_of(part.hull, part.normal) - group.area) <= tree_rounding * group.area) {
            node.shape = SurfelTree::Shape::polygon;
            node.begin = static_cast<Index>(tree_.corners_.size());
            tree_.corners_.insert(tree_.corners_.end(), part.hull.begin(), part.hull.end());
            node.end = static_cast<Index>(tree_.corners_.size());
        } else if (part.whole) {
            node.shape = SurfelTree::Shape::outline;
            node.begin = static_cast<Index>(tree_.edges_.size());
            tree_.edges_.insert(tree_.edges_.end(), part.edges.begin(), part.edges.end());
            node.end = static_cast<Index>(tree_.edges_.size());
        }
        tree_.nodes_.push_back(node);
    }

    /// All squares of a triangle.
    Part triangle(Index t) {
        std::vector<Square>& squares = squares_[t];
        Part part = united_squares(t, squares);
        const double area = groups_[part.group].area;
        part.whole = std::abs(area - mesh_.areas[t]) <= tree_rounding * area;
        part.edges = sides_of(t);
        return part;
    }

    std::vector<SurfelTree::Edge> sides_of(Index t) const {
        const std::array<Index, 3>& p = mesh_.triangles[t];
        return {{p[0], p[1], t}, {p[1], p[2], t}, {p[2], p[0], t}};
    }

    struct Square {
        Index surfel;
        std::array<Index, 2> at;
    };

    Part united_squares(Index t, std::span<Square> squares) {
        if (squares.size() == 1) {
            return square(t, squares[0].surfel);
        }
        std::array<std::array<Index, 2>, 2> range{squares[0].at, squares[0].at}; // least and greatest
        for (const Square& each : squares) {
            for (std::size_t axis = 0; axis < 2; ++axis) {
                range[0][axis] = std::min(range[0][axis], each.at[axis]);
                range[1][axis] = std::max(range[1][axis], each.at[axis]);
            }
        }
        const std::size_t axis = range[1][1] - range[0][1] > range[1][0] - range[0][0] ? 1 : 0;
        const Index limit = range[0][axis] + (range[1][axis] - range[0][axis] + 1) / 2;
        auto middle = std::stable_partition(squares.begin(), squares.end(),
                                            [&](const Square& each) { return each.at[axis] < limit; });
        if (middle == squares.begin() || middle == squares.end()) { // parts of one square
            middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
        }
        const auto first = static_cast<std::size_t>(middle - squares.begin());
        return united_two(united_squares(t, squares.first(first)), united_squares(t, squares.subspan(first)));
    }

    /// One surfel in a grid.
    Part square(Index t, Index s) {
        surfels_.pieces(s, pieces_);
        Part part = flat_part(t);
        const ConvexPolygon& outline = pieces_.front().outline;
        for (std::size_t k = 0; k < outline.count; ++k) {
            const Vec3 corner = mesh_.at(t, outline.corner[k][0], outline.corner[k][1]).position;
            part.box.extend(corner);
            const auto is_new = [&](const Vec3& known) {
                return (corner - known).norm() > tree_rounding * surfels_.edge();
            };
            if (std::all_of(part.hull.begin(), part.hull.end(), is_new)) {
                part.hull.push_back(corner);
            }
        }
        const Eigen::Vector2d middle = outline.centroid();
        add({s, none, surfels_.area(s), mesh_.at(t, middle[0], middle[1]).position}, part);
        return part;
    }

    Part flat_part(Index t) const {
        Part part;
        part.triangle = t;
        part.flat = true;
        part.normal = mesh_.normals[t];
        part.exposure = exposures_[t];
        return part;
    }

    /// One surfel of whole triangles.
    Part cluster(Index s) {
        surfels_.pieces(s, pieces_);
        std::vector<Part> parts;
        SurfelGroups::Group group{s, none, surfels_.area(s), Vec3::Zero()};
        for (const Surfels::Piece& piece : pieces_) {
            group.centre += piece.area / group.area * mesh_.at(piece.triangle, 1.0 / 3.0, 1.0 / 3.0).position;
            Part part = flat_part(piece.triangle);
            part.whole = true;
            part.edges = sides_of(piece.triangle);
            const std::array<Vec3, 3> corners = mesh_.corners(piece.triangle);
            part.hull.assign(corners.begin(), corners.end());
            part.box = mesh_.box(piece.triangle);
            parts.push_back(std::move(part));
        }
        while (parts.size() > 1) {
            Part last = std::move(parts.back());
            parts.pop_back();
            parts.back() = shape_of_both(std::move(parts.back()), std::move(last));
        }
        add(group, parts.front());
        return std::move(parts.front());
    }

    Part united_two(Part a, Part b) {
        const SurfelGroups::Group &first = groups_[a.group], &second = groups_[b.group];
        SurfelGroups::Group group{a.group, b.group, first.area + second.area, first.centre};
        group.centre += second.area / group.area * (second.centre - first.centre);
        Part both = shape_of_both(std::move(a), std::move(b));
        add(group, both);
        return both;
    }

    static Part shape_of_both(Part a, Part b) {
        Part both;
        both.triangle = a.triangle;
        both.box = a.box.merged(b.box);
        both.flat = a.flat && b.flat && (a.normal - b.normal).norm() <= 1e-7 &&
                    std::abs(a.normal.dot(b.hull.front() - a.hull.front())) <= 1e-7 * both.box.diagonal().norm();
        both.whole = a.whole && b.whole;
        both.exposure = a.exposure == b.exposure ? a.exposure : Exposure::both;
        if (both.flat) {
            both.normal = a.normal;
            both.hull = std::move(a.hull);
            both.hull.insert(both.hull.end(), b.hull.begin(), b.hull.end());
            both.hull = convex_hull(both.hull, both.normal);
        }
        if (both.whole) {
            both.edges = united(a.edges, b.edges);
        }
        return both;
    }

    Part united_all(std::span<Part> parts) {
        if (parts.size() == 1) {
            return std::move(parts[0]);
        }
        BoxTree::Box centres;
        for (const Part& part : parts) {
            centres.extend(part.centre());
        }
        Eigen::Index axis = 0;
        centres.sizes().maxCoeff(&axis);
        std::stable_sort(parts.begin(), parts.end(),
                         [axis](const Part& a, const Part& b) { return a.centre()[axis] < b.centre()[axis]; });
        const std::size_t half = parts.size() / 2;
        Part first = united_all(parts.first(half)), second = united_all(parts.subspan(half));
        return united_two(std::move(first), std::move(second));
    }

    static constexpr std::size_t most_corners =
        12; ///< of a polygon: of more, the edges are no more than those of the hull

    const Mesh& mesh_;
    const Surfels& surfels_;
    SurfelTree& tree_;
    const std::vector<Exposure>& exposures_;
    const std::vector<std::uint8_t>& overlaid_;
    std::vector<std::vector<Square>> squares_; ///< by triangle
    std::vector<Index> clusters_;
    std::vector<SurfelGroups::Group> groups_;
    std::vector<Surfels::Piece> pieces_;
};

SurfelTree::SurfelTree(const Mesh& mesh, const Surfels& surfels, const std::vector<Exposure>& exposures,
                       const std::vector<std::uint8_t>& overlaid) {
    SurfelTreeBuilder(mesh, surfels, exposures, overlaid, *this).build();
}

} // namespace difusa
