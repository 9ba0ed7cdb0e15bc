#include <difusa/mesh/shading_normals.h>

#include <difusa/core/frame.h>
#include <difusa/mesh/mesh.h>
#include <difusa/mesh/smooth_sides.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>

namespace difusa {

namespace {

/// Unit vectors at this distance or less are the same to within rounding.
constexpr double same_normal = 8.0 * std::numeric_limits<double>::epsilon();

/// The fans of a mesh, with their corners and mean normals.
class Fans {
  public:
    Fans(const Mesh& mesh, const Twins& smooth) : mesh_(mesh) {
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

    void take_means() {
        mean_.assign(count_, Vec3::Zero());
        for (Index f = 0; f < count_; ++f) {
            double total = 0.0;
            for (const std::size_t c : corners(f)) {
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
    /// fan. The mean normal if they do not determine it: if they are about in one line, all the same, or nearer to the
    /// mean normal than the result.
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
        const Vec3 fitted = (middle_normal - products * (moments.inverse() * middle)).normalized();
        return (fitted - mean).norm() <= farthest ? fitted : mean;
    }

    static constexpr std::size_t most_corners = 64; ///< of a point around which others are looked for
    static constexpr double least_spread = 0.01;    ///< of the smaller axis' moment over the larger one's

    const Mesh& mesh_;
    std::vector<Index> fan_; ///< of each corner
    Index count_ = 0;
    std::vector<char> open_;                  ///< does not go all around its tip
    std::vector<std::size_t> first_, corner_; ///< #fans + 1, #corners: those of each fan
    std::vector<Vec3> mean_;                  ///< weighted by angles, or zero
};

/// Whether the mesh turns anywhere without a crease.
bool is_curved(const Mesh& mesh, const Twins& smooth) {
    for (std::size_t s = 0; s < smooth.size(); ++s) {
        if (smooth[s] != none &&
            (mesh.normals[triangle_of(s)] - mesh.normals[triangle_of(smooth[s])]).norm() > same_normal) {
            return true;
        }
    }
    return false;
}

} // namespace

ShadingNormals::ShadingNormals(const Mesh& mesh) {
    const Twins smooth = join_smooth_sides(mesh, mesh.crease_angle);
    if (is_curved(mesh, smooth)) {
        Fans fans(mesh, smooth);
        normal_ = fans.normals();
        fan_ = fans.take_numbers();
    }
}

Vec3 ShadingNormals::at(Index triangle, double u, double v, const Vec3& face_normal) const {
    if (flat()) {
        return face_normal;
    }
    const Index* const fan = fan_.data() + 3 * std::size_t{triangle};
    const Vec3 mean = (1.0 - u - v) * normal_[fan[0]] + u * normal_[fan[1]] + v * normal_[fan[2]];
    // A flat wall gets exactly the normal of its faces, not one that differs in the last place; and a normal leaving
    // the front of its own face would shade it from behind.
    const bool differs = (mean - face_normal).norm() > same_normal && mean.dot(face_normal) > 0.0;
    return differs ? Vec3(mean.normalized()) : face_normal;
}

} // namespace difusa
