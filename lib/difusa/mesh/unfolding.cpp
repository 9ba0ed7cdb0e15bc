#include <difusa/mesh/unfolding.h>

#include <difusa/mesh/mesh.h>
#include <difusa/mesh/point_tree.h>
#include <difusa/mesh/smooth_sides.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace difusa {

namespace {

constexpr int rings = 3; ///< of triangles around points that an image shares with the mesh

class Unfolding {
  public:
    explicit Unfolding(const Mesh& mesh)
        : mesh_(mesh), tolerance_(2.0 * Repetition::tolerance * mesh.diameter()), result_(without_walls(mesh)) {
        for (Index p = 0; p < mesh.points.size(); ++p) {
            const Vec3& point = mesh.points[p];
            const bool near =
                std::any_of(mesh.repetition.walls.begin(), mesh.repetition.walls.end(),
                            [&](const Repetition::Wall& wall) { return std::abs(wall.height(point)) <= tolerance_; });
            if (near) {
                at_walls_.push_back(p);
                known_.push_back({point, Vec3::UnitZ(), p, 0.0, 0.0});
            }
        }
    }

    Mesh result() {
        const std::vector<Repetition::Image> images = mesh_.repetition.images(1);
        for (std::size_t i = 1; i < images.size() && !known_.empty(); ++i) {
            add(images[i]);
        }
        result_.derive();
        return std::move(result_);
    }

  private:
    static Mesh without_walls(const Mesh& mesh) {
        Mesh result;
        result.points = mesh.points;
        result.triangles = mesh.triangles;
        result.original_face = mesh.original_face;
        result.material = mesh.material;
        result.crease_angle = mesh.crease_angle;
        return result;
    }

    /// The number in the result of a known point there, or none.
    Index found(const PointTree& tree, const Vec3& place) const {
        const SurfacePoint& nearest = known_[tree.nearest(place)];
        return (nearest.position - place).norm() <= tolerance_ ? nearest.face : none;
    }

    void add(const Repetition::Image& image) {
        const PointTree tree(known_);
        std::vector<Index> number(mesh_.points.size(), none); // in the result
        std::vector<char> touching(mesh_.points.size(), 0);
        for (const Index p : at_walls_) {
            number[p] = found(tree, image(mesh_.points[p]));
            touching[p] = static_cast<char>(number[p] != none && number[p] < mesh_.points.size());
        }
        if (std::find(touching.begin(), touching.end(), 1) == touching.end()) {
            return;
        }
        const std::vector<char> chosen = choose(std::move(touching));
        for (Index t = 0; t < mesh_.triangles.size(); ++t) {
            if (chosen[t] != 0) {
                add_triangle(image, t, number);
            }
        }
        for (const Index p : at_walls_) {
            if (number[p] != none && number[p] >= mesh_.points.size()) {
                known_.push_back({result_.points[number[p]], Vec3::UnitZ(), number[p], 0.0, 0.0});
            }
        }
    }

    void add_triangle(const Repetition::Image& image, Index t, std::vector<Index>& number) {
        std::array<Index, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            Index& corner = number[mesh_.triangles[t][k]];
            if (corner == none) {
                corner = static_cast<Index>(result_.points.size());
                result_.points.push_back(image(mesh_.points[mesh_.triangles[t][k]]));
            }
            corners[k] = corner;
        }
        const auto [a, b, c] = corners;
        // In a wall, or at the other end of a period: it is there already.
        const bool in_a_wall = std::max({a, b, c}) < mesh_.points.size();
        if (in_a_wall || a == b || b == c || c == a) {
            return;
        }
        result_.triangles.push_back(image.reflects() ? std::array<Index, 3>{a, c, b} : corners);
        result_.original_face.push_back(mesh_.original_face[t]);
        result_.material.push_back(mesh_.material[t]);
    }

    /// The triangles around the points marked.
    std::vector<char> choose(std::vector<char> marked) const {
        std::vector<char> chosen(mesh_.triangles.size(), 0);
        std::vector<Index> last;
        for (int ring = 0; ring < rings; ++ring) {
            last.clear();
            for (Index t = 0; t < mesh_.triangles.size(); ++t) {
                const auto& corners = mesh_.triangles[t];
                if (chosen[t] == 0 &&
                    std::any_of(corners.begin(), corners.end(), [&](Index p) { return marked[p] != 0; })) {
                    chosen[t] = 1;
                    last.push_back(t);
                }
            }
            for (const Index t : last) {
                for (const Index p : mesh_.triangles[t]) {
                    marked[p] = 1;
                }
            }
        }
        // Facets that go on across a wall, and those beyond them, which tell whether they are curved.
        complete_planes(chosen);
        std::vector<char> wider = chosen;
        for (std::size_t side = 0; side < mesh_.twin.size(); ++side) {
            if (mesh_.twin[side] != none && chosen[side / 3] != 0) {
                wider[mesh_.twin[side] / 3] = 1;
            }
        }
        complete_planes(wider);
        return wider;
    }

    void complete_planes(std::vector<char>& chosen) const {
        std::vector<Index> open;
        for (Index t = 0; t < mesh_.triangles.size(); ++t) {
            if (chosen[t] != 0) {
                open.push_back(t);
            }
        }
        while (!open.empty()) {
            const Index t = open.back();
            open.pop_back();
            continue_plane(mesh_, mesh_.twin, t, open,
                           [&](Index other) { return std::exchange(chosen[other], static_cast<char>(1)) == 0; });
        }
    }

    const Mesh& mesh_;
    double tolerance_;
    Mesh result_;
    std::vector<Index> at_walls_;     ///< points of the mesh
    std::vector<SurfacePoint> known_; ///< points of the result at walls, and at images of these; `face`: the number
};

} // namespace

Mesh unfolded(const Mesh& mesh) {
    return Unfolding(mesh).result();
}

} // namespace difusa
