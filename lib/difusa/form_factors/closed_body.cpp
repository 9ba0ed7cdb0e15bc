#include <difusa/form_factors/closed_body.h>

#include <difusa/mesh/crossing_faces.h>

#include <algorithm>
#include <optional>
#include <unordered_map>

namespace difusa {

namespace {

constexpr std::size_t most_comparisons = std::size_t{1} << 26U; ///< of faces with corners
constexpr double single_rounding = 0x1p-21; ///< of distances between points in single precision, of the coordinates

Plane plane_of(const Mesh& mesh, Index triangle) {
    return {mesh.normals[triangle], mesh.normals[triangle].dot(mesh.corner(triangle, 0))};
}

/// The number of each key, in the order in which they are asked for.
class Numbering {
  public:
    Index of(Index key) { return number_.try_emplace(key, static_cast<Index>(number_.size())).first->second; }
    std::size_t size() const { return number_.size(); }

  private:
    std::unordered_map<Index, Index> number_;
};

/// The triangles that can be reached from one across joined sides, if no side is left open.
std::optional<std::vector<Index>> closed_part(const Mesh& mesh, Index seed, std::vector<char>& seen) {
    std::vector<Index> members{seed};
    seen[seed] = 1;
    bool closed = true;
    for (std::size_t at = 0; at < members.size(); ++at) {
        for (std::size_t side = 3 * std::size_t{members[at]}; side < 3 * std::size_t{members[at]} + 3; ++side) {
            const Index twin = mesh.twin[side];
            closed = closed && twin != none;
            if (twin != none && seen[twin / 3] == 0) {
                seen[twin / 3] = 1;
                members.push_back(twin / 3);
            }
        }
    }
    return closed ? std::optional(std::move(members)) : std::nullopt;
}

/// Whether the volume that triangles enclose is behind their fronts.
bool is_outward(const Mesh& mesh, const std::vector<Index>& triangles) {
    const Vec3& origin = mesh.corner(triangles.front(), 0);
    double volume = 0.0; // six times
    for (const Index t : triangles) {
        const auto [a, b, c] = mesh.corners(t);
        volume += (a - origin).dot((b - origin).cross(c - origin));
    }
    return volume > 0.0;
}

} // namespace

ClosedBody::ClosedBody(const Mesh& mesh, const std::vector<Index>& triangles, const std::vector<Index>& faces) {
    Numbering corner, face;
    for (const Index t : triangles) {
        std::array<Index, 3>& own = triangles_.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            own[k] = corner.of(mesh.triangles[t][k]);
            if (own[k] == corners_.size()) {
                corners_.push_back(mesh.points[mesh.triangles[t][k]]);
            }
        }
        if (face.of(faces[t]) == planes_.size()) {
            planes_.push_back(plane_of(mesh, t));
        }
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Index t = triangles[i];
        for (std::size_t k = 0; k < 3; ++k) {
            const Index other = mesh.twin[3 * std::size_t{t} + k] / 3;
            if (t < other && faces[t] != faces[other]) {
                edges_.push_back(
                    {triangles_[i][k], triangles_[i][(k + 1) % 3], face.of(faces[t]), face.of(faces[other])});
            }
        }
    }
    convex_ = is_convex(mesh, triangles);
}

bool ClosedBody::is_convex(const Mesh& mesh, const std::vector<Index>& triangles) const {
    double magnitude = 0.0;
    for (const Vec3& corner : corners_) {
        magnitude = std::max(magnitude, corner.cwiseAbs().maxCoeff());
    }
    const double rounding = magnitude * single_rounding;
    // Across each edge first: other surfaces are soon done with.
    for (const Index t : triangles) {
        const Plane plane = plane_of(mesh, t);
        for (std::size_t k = 0; k < 3; ++k) {
            const Index twin = mesh.twin[3 * std::size_t{t} + k];
            if (plane.height(mesh.corner(twin / 3, static_cast<int>((twin % 3 + 2) % 3))) > rounding) {
                return false;
            }
        }
    }
    return planes_.size() * corners_.size() <= most_comparisons &&
           std::all_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
               return std::all_of(corners_.begin(), corners_.end(),
                                  [&](const Vec3& corner) { return plane.height(corner) <= rounding; });
           });
}

bool ClosedBody::find_outline(const Vec3& x, double rounding, View& view) const {
    view.front.resize(planes_.size());
    for (std::size_t f = 0; f < planes_.size(); ++f) {
        view.front[f] = planes_[f].height(x) > rounding ? 1 : 0;
    }
    view.outside = std::find(view.front.begin(), view.front.end(), 1) != view.front.end();
    view.next.assign(corners_.size(), none);
    std::size_t count = 0;
    Index start = none;
    for (const Edge& edge : edges_) {
        if (view.front[edge.left] == view.front[edge.right]) {
            continue;
        }
        const bool left = view.front[edge.left] != 0;
        start = left ? edge.from : edge.to;
        if (view.next[start] != none) {
            return false;
        }
        view.next[start] = left ? edge.to : edge.from;
        ++count;
    }
    view.outline.clear();
    for (Index at = start; at != none && view.outline.size() < count; at = view.next[at]) {
        view.outline.push_back(at);
        if (view.next[at] == start) {
            return view.outline.size() == count;
        }
    }
    return false;
}

std::vector<std::shared_ptr<const ClosedBody>> closed_bodies(const Mesh& mesh, const std::vector<Index>& parts) {
    std::vector<std::shared_ptr<const ClosedBody>> bodies(mesh.triangles.size());
    std::vector<char> seen(mesh.triangles.size(), 0);
    std::vector<std::vector<Index>> found;
    std::vector<Index> number(mesh.triangles.size(), none);
    for (Index t = 0; t < seen.size(); ++t) {
        if (seen[t] != 0) {
            continue;
        }
        const std::optional<std::vector<Index>> triangles = closed_part(mesh, t, seen);
        if (triangles && is_outward(mesh, *triangles)) {
            for (const Index own : *triangles) {
                number[own] = static_cast<Index>(found.size());
            }
            found.push_back(*triangles);
        }
    }
    if (found.empty()) {
        return bodies;
    }
    const auto crossings = find_crossing_triangles(mesh);
    if (!crossings) {
        return bodies;
    }
    std::vector<char> simple(found.size(), 1);
    for (const auto& [t, other] : *crossings) {
        if (number[t] != none && number[t] == number[other]) {
            simple[number[t]] = 0;
        }
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (simple[i] != 0) {
            const auto body = std::make_shared<const ClosedBody>(mesh, found[i], parts);
            for (const Index own : found[i]) {
                bodies[own] = body;
            }
        }
    }
    return bodies;
}

} // namespace difusa
