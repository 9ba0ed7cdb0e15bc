#include <difusa/mesh/shading_normals.h>

#include <difusa/core/frame.h>
#include <difusa/mesh/mesh.h>
#include <difusa/mesh/smooth_sides.h>
#include <difusa/mesh/unfolding.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>

namespace difusa {

namespace {

/// Facets smaller than this, relative to another, are details of it.
constexpr double comparable = 0.25;

/// What is known of a **facet**, a connected part of the mesh in one plane.
struct Facets {
    std::vector<Index> of_triangle;
    std::vector<double> area;
    std::vector<char> curved; ///< it stands for a piece of a curved surface
};

Facets find_facets(const Mesh& mesh, const Twins& smooth) {
    Facets facets;
    facets.of_triangle.assign(mesh.triangles.size(), none);
    std::vector<Index> open;
    for (Index start = 0; start < mesh.triangles.size(); ++start) {
        if (facets.of_triangle[start] != none) {
            continue;
        }
        const auto number = static_cast<Index>(facets.area.size());
        facets.area.push_back(0.0);
        facets.of_triangle[start] = number;
        open.assign(1, start);
        while (!open.empty()) {
            const Index t = open.back();
            open.pop_back();
            facets.area.back() += mesh.areas[t];
            continue_plane(mesh, smooth, t, open, [&](Index other) {
                if (facets.of_triangle[other] != none) {
                    return false;
                }
                facets.of_triangle[other] = number;
                return true;
            });
        }
    }
    return facets;
}

/// A facet stands for a piece of a curved surface if this goes on turning on two sides of it at least, to others that
/// are not much smaller. A wall that ends in a fillet, a plane with a sliver out of it, and the two sides of a single
/// bend are what they are: flat.
void find_curved(const Mesh& mesh, const Twins& smooth, Facets& facets) {
    constexpr double off_the_line = 1e-3;
    facets.curved.assign(facets.area.size(), 0);
    std::vector<std::size_t> first(facets.area.size(), smooth.size()); // side of each facet where it turns
    for (std::size_t side = 0; side < smooth.size(); ++side) {
        if (smooth[side] == none) {
            continue;
        }
        const Index own = facets.of_triangle[triangle_of(side)], other = facets.of_triangle[triangle_of(smooth[side])];
        if (own == other || facets.area[other] < comparable * facets.area[own]) {
            continue;
        }
        if (first[own] == smooth.size()) {
            first[own] = side;
            continue;
        }
        const Vec3& from = mesh.points[point_at(mesh, first[own])];
        const Vec3 along = (mesh.points[point_at(mesh, after(first[own]))] - from).normalized();
        for (const std::size_t corner : {side, after(side)}) {
            const double away = along.cross(mesh.points[point_at(mesh, corner)] - from).norm();
            facets.curved[own] |= static_cast<char>(away > off_the_line * std::sqrt(facets.area[own]));
        }
    }
}

/// The fans of a mesh, with their corners and mean normals.
class Fans {
  public:
    Fans(const Mesh& mesh, const Twins& smooth, const Facets& facets) : mesh_(mesh), facets_(facets) {
        std::tie(fan_, count_) = number_fans(smooth);
        open_.assign(count_, 0);
        first_.assign(count_ + 1, 0);
        for (std::size_t c = 0; c < fan_.size(); ++c) {
            open_[fan_[c]] |= static_cast<char>(smooth[c] == none || smooth[before(c)] == none);
            ++first_[fan_[c] + 1];
        }
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        corner_.resize(fan_.size());
        std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
        for (std::size_t c = 0; c < fan_.size(); ++c) {
            corner_[next[fan_[c]]++] = c;
        }
        take_means();
    }

    std::vector<Index> take_numbers() { return std::move(fan_); }

    /// The mean normals, those of open fans extrapolated.
    std::vector<Vec3> normals() const {
        std::vector<Vec3> normals = mean_;
        std::vector<Index> around;
        for (Index f = 0; f < count_; ++f) {
            if (open_[f] != 0 && mean_[f] != Vec3::Zero()) {
                find_closed(f, around);
                normals[f] = extrapolated(f, around);
            }
        }
        return normals;
    }

  private:
    std::span<const std::size_t> corners(Index fan) const {
        return std::span(corner_).subspan(first_[fan], first_[fan + 1] - first_[fan]);
    }
    const Vec3& tip(Index fan) const { return mesh_.points[point_at(mesh_, corner_[first_[fan]])]; }

    double area_at(std::size_t corner) const { return facets_.area[facets_.of_triangle[triangle_of(corner)]]; }

    void take_means() {
        mean_.assign(count_, Vec3::Zero());
        for (Index f = 0; f < count_; ++f) {
            double total = 0.0, largest = 0.0;
            for (const std::size_t c : corners(f)) {
                largest = std::max(largest, area_at(c));
            }
            for (const std::size_t c : corners(f)) {
                if (area_at(c) < comparable * largest) {
                    continue;
                }
                const Vec3 a = mesh_.points[point_at(mesh_, after(c))] - tip(f),
                           b = mesh_.points[point_at(mesh_, before(c))] - tip(f);
                const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
                mean_[f] += angle * mesh_.normals[triangle_of(c)];
                total += angle;
            }
            // The remainder of a sum that cancels is rounding error with an arbitrary direction.
            const double length = mean_[f].norm();
            mean_[f] = length > 1e-9 * total ? Vec3(mean_[f] / length) : Vec3::Zero();
        }
    }

    /// The closed fans at points up to two sides away, in ascending order; not beyond points where very many triangles
    /// meet.
    void find_closed(Index fan, std::vector<Index>& around) const {
        around.clear();
        const auto take = [&](std::size_t corner) {
            const Index other = fan_[corner];
            if (open_[other] == 0 && mean_[other] != Vec3::Zero()) {
                around.push_back(other);
            }
        };
        for (const std::size_t c : corners(fan)) {
            for (const std::size_t side : {after(c), before(c)}) {
                take(side);
                const std::span<const std::size_t> further = corners(fan_[side]);
                for (const std::size_t d : further.first(further.size() <= most_corners ? further.size() : 0)) {
                    take(after(d));
                    take(before(d));
                }
            }
        }
        std::sort(around.begin(), around.end());
        around.erase(std::unique(around.begin(), around.end()), around.end());
    }

    /// The linear function of the place in the tangent plane that fits the normals `around` best, at the tip of the
    /// fan. The mean normal if they do not determine it: if they are about in one line, all the same, nearer to the
    /// mean normal than the result, or off the function by more than that.
    Vec3 extrapolated(Index fan, std::span<const Index> around) const {
        const Vec3& mean = mean_[fan];
        Vec3 t, b;
        tangents(mean, t, b);
        double farthest = 0.0;
        Eigen::Vector2d middle = Eigen::Vector2d::Zero();
        Vec3 middle_normal = Vec3::Zero();
        const auto place = [&](Index other) {
            const Vec3 way = tip(other) - tip(fan);
            return Eigen::Vector2d(t.dot(way), b.dot(way));
        };
        const double share = 1.0 / static_cast<double>(around.size());
        for (const Index other : around) {
            farthest = std::max(farthest, (mean_[other] - mean).norm());
            middle += share * place(other);
            middle_normal += share * mean_[other];
        }
        if (!(farthest > 1e-9)) {
            return mean;
        }
        Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
        Eigen::Matrix<double, 3, 2> products = Eigen::Matrix<double, 3, 2>::Zero();
        for (const Index other : around) {
            const Eigen::Vector2d away = place(other) - middle;
            moments += away * away.transpose();
            products += (mean_[other] - middle_normal) * away.transpose();
        }
        const double det = moments.determinant(), trace = moments.trace();
        if (!(det > least_spread * trace * trace)) {
            return mean;
        }
        const Eigen::Matrix<double, 3, 2> slope = products * moments.inverse();
        const Vec3 fitted = (middle_normal - slope * middle).normalized();
        const double change = (fitted - mean).norm();
        double squares = 0.0;
        for (const Index other : around) {
            squares += share * (mean_[other] - middle_normal - slope * (place(other) - middle)).squaredNorm();
        }
        return change <= farthest && std::sqrt(squares) <= change ? fitted : mean;
    }

    static constexpr std::size_t most_corners = 64; ///< of a point around which others are looked for
    static constexpr double least_spread = 0.01;    ///< of the smaller axis' moment over the larger one's

    const Mesh& mesh_;
    const Facets& facets_;
    std::vector<Index> fan_; ///< of each corner
    Index count_ = 0;
    std::vector<char> open_;                  ///< does not go all around its tip
    std::vector<std::size_t> first_, corner_; ///< #fans + 1, #corners: those of each fan
    std::vector<Vec3> mean_;                  ///< weighted by angles, or zero
};

} // namespace

ShadingNormals::ShadingNormals(const Mesh& mesh) {
    if (mesh.repetition.any()) {
        *this = unfolded(mesh).shading;
        const std::size_t own = mesh.triangles.size();
        fan_.resize(std::min(fan_.size(), 3 * own));
        curved_.resize(std::min(curved_.size(), own));
        return;
    }
    const Twins smooth = join_smooth_sides(mesh, mesh.crease_angle);
    Facets facets = find_facets(mesh, smooth);
    const auto turns = [&](std::size_t side) {
        return smooth[side] != none &&
               facets.of_triangle[triangle_of(side)] != facets.of_triangle[triangle_of(smooth[side])];
    };
    std::size_t side = 0;
    while (side < smooth.size() && !turns(side)) {
        ++side;
    }
    if (side == smooth.size()) {
        return;
    }
    find_curved(mesh, smooth, facets);
    Fans fans(mesh, smooth, facets);
    normal_ = fans.normals();
    fan_ = fans.take_numbers();
    for (const Index facet : facets.of_triangle) {
        curved_.push_back(facets.curved[facet]);
    }
}

bool ShadingNormals::flat() const {
    return std::find(curved_.begin(), curved_.end(), 1) == curved_.end();
}

Vec3 ShadingNormals::interpolated(Index triangle, double u, double v, const Vec3& face_normal) const {
    const Index* const fan = fan_.data() + 3 * std::size_t{triangle};
    const Vec3 mean = (1.0 - u - v) * normal_[fan[0]] + u * normal_[fan[1]] + v * normal_[fan[2]];
    // A normal leaving the front of its own face would shade it from behind.
    return mean.dot(face_normal) > 0.0 ? Vec3(mean.normalized()) : face_normal;
}

Vec3 ShadingNormals::at_vertex(Index triangle, double u, double v, const Vec3& face_normal) const {
    constexpr double on_a_side = 0x1p-40;
    if (fan_.empty() || (curved_[triangle] == 0 && std::min({u, v, 1.0 - u - v}) > on_a_side)) {
        return face_normal;
    }
    const Vec3 normal = interpolated(triangle, u, v, face_normal);
    // Within a wall it is exactly that of the wall.
    return (normal - face_normal).norm() > same_normal ? normal : face_normal;
}

} // namespace difusa
