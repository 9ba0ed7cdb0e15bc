#include <difusa/repair/covered_parts.h>

#include <difusa/mesh/arrangement.h>
#include <difusa/mesh/repetition.h>
#include <difusa/mesh/triangle_tree.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <utility>

namespace difusa {

namespace {

using Vec2 = Eigen::Vector2d;

constexpr double most_slivers = 1e-4; ///< of the area

/// A plane seen along a coordinate axis.
struct PlaneView {
    Vec3 origin, normal;
    int dropped = 0;

    PlaneView(const Mesh& mesh, Index triangle) : origin(mesh.corner(triangle, 0)), normal(mesh.normals[triangle]) {
        normal.cwiseAbs().maxCoeff(&dropped);
    }

    Vec2 flat(const Vec3& p) const { return {p[(dropped + 1) % 3], p[(dropped + 2) % 3]}; }

    Vec3 in_space(const Vec2& p) const {
        Vec3 result = Vec3::Zero();
        result[(dropped + 1) % 3] = p[0];
        result[(dropped + 2) % 3] = p[1];
        result[dropped] = normal.dot(origin - result) / normal[dropped];
        return result;
    }
};

double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// Weights of the corners of a triangle in the plane at p.
Vec3 weights_at(const std::array<Vec2, 3>& corners, const Vec2& p) {
    const auto& [a, b, c] = corners;
    return Vec3(twice_area(p, b, c), twice_area(a, p, c), twice_area(a, b, p)) / twice_area(a, b, c);
}

/// A piece of a triangle.
struct Piece {
    std::array<Index, 3> corners;
    std::array<Vec3, 3> weights; ///< of the triangle's corners, at each of these
};

/// Cuts triangles of flat patches of a mesh.
class Cutter {
  public:
    Cutter(const Mesh& mesh, double rounding) : mesh_(mesh), rounding_(rounding), points_(mesh.points) {}

    /// Leaves out what the triangles `covers` cover of these of a patch, both sorted. They overlap, so that they are in
    /// one plane, although the patch may turn away from it; that of the largest is known best.
    void cut(const std::vector<Index>& patch, const std::vector<Index>& covers) {
        const auto is_smaller = [&](Index t, Index u) { return mesh_.areas[t] < mesh_.areas[u]; };
        const PlaneView plane(mesh_, std::max(*std::max_element(patch.begin(), patch.end(), is_smaller),
                                              *std::max_element(covers.begin(), covers.end(), is_smaller), is_smaller));
        std::map<Index, Index> number; // of a point of the mesh in the plane
        std::vector<Index> points;
        std::vector<Vec2> flat;
        std::vector<std::pair<Index, Index>> sides;
        const auto at = [&](Index point) {
            const auto [found, is_new] = number.try_emplace(point, static_cast<Index>(points.size()));
            if (is_new) {
                points.push_back(point);
                flat.push_back(plane.flat(mesh_.points[point]));
            }
            return found->second;
        };
        for (const std::vector<Index>* const triangles : {&patch, &covers}) {
            for (const Index t : *triangles) {
                const auto& [a, b, c] = mesh_.triangles[t];
                for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
                    sides.emplace_back(std::minmax(at(p), at(q)));
                }
            }
        }
        std::sort(sides.begin(), sides.end());
        sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
        const Arrangement all = arrange(flat, sides, rounding_);
        for (std::size_t i = flat.size(); i < all.points.size(); ++i) {
            points.push_back(static_cast<Index>(points_.size()));
            points_.push_back(plane.in_space(all.points[i]));
        }
        for (const Index t : patch) {
            pieces_[t]; // none yet
        }
        const BoxTree tree = tree_of_triangles(mesh_, both(patch, covers));
        for (const std::array<Index, 3>& triangle : all.triangles) {
            keep(triangle, all, points, plane, tree, covers);
        }
    }

    /// The mesh of what remains, not derived.
    Mesh result() const {
        Mesh cut = mesh_;
        for (std::vector<Index>* const list :
             {&cut.original_face, &cut.material, &cut.mirrors.of_face, &cut.glossy.of_face}) {
            list->clear();
        }
        cut.triangles.clear();
        cut.corner_reflectance.clear();
        cut.corner_texture.clear();
        const std::array<Vec3, 3> whole{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
        for (Index t = 0; t < mesh_.triangles.size(); ++t) {
            if (const auto found = pieces_.find(t); found == pieces_.end()) {
                append(cut, t, {mesh_.triangles[t], whole});
            } else {
                for (const Piece& piece : found->second) {
                    append(cut, t, piece);
                }
            }
        }
        keep_used_points(cut);
        return cut;
    }

  private:
    static std::vector<Index> both(const std::vector<Index>& a, const std::vector<Index>& b) {
        std::vector<Index> all;
        std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
        return all;
    }

    std::array<Vec2, 3> flattened(Index t, const PlaneView& plane) const {
        return {plane.flat(mesh_.corner(t, 0)), plane.flat(mesh_.corner(t, 1)), plane.flat(mesh_.corner(t, 2))};
    }

    /// Appends a piece of a triangle.
    void append(Mesh& to, Index t, const Piece& piece) const {
        to.triangles.push_back(piece.corners);
        to.original_face.push_back(mesh_.original_face[t]);
        to.material.push_back(mesh_.material[t]);
        if (mesh_.mirrors.any()) {
            to.mirrors.of_face.push_back(mesh_.mirrors.of_face[t]);
        }
        if (mesh_.glossy.any()) {
            to.glossy.of_face.push_back(mesh_.glossy.of_face[t]);
        }
        const auto append_mean = [&](const auto& from, auto& values) {
            if (from.empty()) {
                return;
            }
            values.push_back(from[t]);
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3& weight = piece.weights[k];
                values.back()[k] = weight[0] * from[t][0] + weight[1] * from[t][1] + weight[2] * from[t][2];
            }
        };
        append_mean(mesh_.corner_reflectance, to.corner_reflectance);
        append_mean(mesh_.corner_texture, to.corner_texture);
    }

    void keep_used_points(Mesh& cut) const {
        std::vector<Index> number(points_.size(), none);
        for (const std::array<Index, 3>& triangle : cut.triangles) {
            for (const Index point : triangle) {
                number[point] = 0;
            }
        }
        cut.points.clear();
        for (std::size_t i = 0; i < points_.size(); ++i) {
            if (number[i] != none) {
                number[i] = static_cast<Index>(cut.points.size());
                cut.points.push_back(points_[i]);
            }
        }
        for (std::array<Index, 3>& triangle : cut.triangles) {
            for (Index& point : triangle) {
                point = number[point];
            }
        }
    }

    /// Keeps a triangle of the arrangement if it belongs to the patch, and nothing covers it.
    void keep(const std::array<Index, 3>& triangle, const Arrangement& all, const std::vector<Index>& points,
              const PlaneView& plane, const BoxTree& tree, const std::vector<Index>& covers) {
        const Vec2 &a = all.points[triangle[0]], &b = all.points[triangle[1]], &c = all.points[triangle[2]];
        const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
        if (!(twice_area(a, b, c) > rounding_ * longest)) {
            return;
        }
        const Vec2 middle = (a + b + c) / 3.0;
        Index own = none;
        bool is_covered = false;
        BoxTree::Box column(plane.in_space(middle));
        column.min().array() -= rounding_;
        column.max().array() += rounding_;
        column.min()[plane.dropped] = mesh_.low[plane.dropped];
        column.max()[plane.dropped] = mesh_.high[plane.dropped];
        tree.visit(column, [&](Index t, const BoxTree::Box&) {
            if (weights_at(flattened(t, plane), middle).minCoeff() > 0.0) {
                is_covered = std::binary_search(covers.begin(), covers.end(), t);
                own = t;
            }
            return is_covered;
        });
        if (own == none || is_covered) {
            return;
        }
        const std::array<Vec2, 3> corners = flattened(own, plane);
        Piece piece{{points[triangle[0]], points[triangle[1]], points[triangle[2]]},
                    {weights_at(corners, a), weights_at(corners, b), weights_at(corners, c)}};
        if (mesh_.normals[own][plane.dropped] < 0.0) {
            std::swap(piece.corners[1], piece.corners[2]);
            std::swap(piece.weights[1], piece.weights[2]);
        }
        pieces_[own].push_back(piece);
    }

    const Mesh& mesh_;
    const double rounding_;
    std::vector<Vec3> points_;
    std::map<Index, std::vector<Piece>> pieces_;
};

} // namespace

CoveredParts leave_out_covered(Mesh& mesh, const Execution& execution) {
    CoveredParts result;
    const CoplanarDistances distances(mesh);
    const std::optional<std::vector<Overlap>> overlaps = find_overlaps(mesh, distances.rounding(), execution);
    result.given_up = !overlaps;
    if (!overlaps || overlaps->empty()) {
        return result;
    }
    const CoplanarLayers layers(mesh, distances, *overlaps);
    std::vector<std::vector<Index>> covers(layers.patch_count()), patches(layers.patch_count());
    std::map<Index, CoplanarFace> cut; // by the number of the face in the file
    double overlapping = 0.0;
    const auto covered = [&](Index t, Index by, const Overlap& overlap) {
        covers[layers.patch(t)].push_back(by);
        patches[layers.patch(t)].push_back(t);
        overlapping += overlap.area;
        const Index face = mesh.original_face[t];
        cut.emplace(face, CoplanarFace{face, mesh.original_face[by], overlap.place});
    };
    for (const Overlap& overlap : *overlaps) {
        const Index behind = layers.covered_one(overlap);
        const bool touch = layers.is_contact(overlap);
        if (touch || behind == overlap.a) {
            covered(overlap.a, overlap.b, overlap);
        }
        if (touch || behind == overlap.b) {
            covered(overlap.b, overlap.a, overlap);
        }
    }
    if (cut.empty()) {
        return result;
    }
    Cutter cutter(mesh, distances.rounding());
    for (std::size_t p = 0; p < patches.size(); ++p) {
        for (std::vector<Index>* const triangles : {&covers[p], &patches[p]}) {
            std::sort(triangles->begin(), triangles->end());
            triangles->erase(std::unique(triangles->begin(), triangles->end()), triangles->end());
        }
        if (!covers[p].empty()) {
            execution.check();
            cutter.cut(patches[p], covers[p]);
        }
    }
    Mesh rest = cutter.result();
    rest.repetition.walls.clear(); // those of before
    rest.derive();
    settle_repetition(rest);
    const double gone = mesh.area - rest.area;
    if (!(gone <= overlapping + most_slivers * mesh.area)) { // more than is covered
        result.given_up = true;
        return result;
    }
    result.area = gone;
    mesh = std::move(rest);
    for (const auto& [number, face] : cut) {
        result.cut.push_back(face);
    }
    return result;
}

} // namespace difusa
