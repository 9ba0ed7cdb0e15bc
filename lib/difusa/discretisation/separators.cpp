#include <difusa/discretisation/separators.h>

#include <difusa/rays/watertight.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace difusa {

namespace {

using Box = BoxTree::Box;
using Corners = std::array<Vec3, 3>;

Corners corners_of(const Mesh& mesh, Index triangle) {
    return {mesh.corner(triangle, 0), mesh.corner(triangle, 1), mesh.corner(triangle, 2)};
}

Box grown(const Box& box, double by) {
    return {box.min() - Vec3::Constant(by), box.max() + Vec3::Constant(by)};
}

/// The signed distances of a triangle's corners from a plane.
struct Heights {
    std::array<double, 3> at{};
    double low = 0.0, high = 0.0;
    Heights(const Corners& corners, const Vec3& normal, const Vec3& foot) {
        for (std::size_t k = 0; k < 3; ++k) {
            at[k] = normal.dot(corners[k] - foot);
        }
        low = std::min({at[0], at[1], at[2]});
        high = std::max({at[0], at[1], at[2]});
    }
    /// Reaches the plane, but does not lie in it.
    bool stands_on(double rounding) const {
        return low <= rounding && high >= -rounding && (low < -rounding || high > rounding);
    }
};

/// Where a triangle meets a plane that it has these heights over: the interval along `axis`, from `origin`.
std::pair<double, double> section(const Corners& corners, const Heights& height, const Vec3& origin, const Vec3& axis,
                                  double rounding) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    const auto add = [&](const Vec3& point) {
        const double along = axis.dot(point - origin);
        low = std::min(low, along);
        high = std::max(high, along);
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const double h = height.at[k], g = height.at[next];
        if (std::abs(h) <= rounding) {
            add(corners[k]);
        }
        if ((h < 0.0) != (g < 0.0)) {
            add(corners[k] + h / (h - g) * (corners[next] - corners[k]));
        }
    }
    return {low, high};
}

/// The heights of triangle T over the plane of F if the two touch and neither lies in the plane of the other.
std::optional<Heights> touches(const Mesh& mesh, Index F, Index T, double rounding) {
    const Corners f = corners_of(mesh, F), t = corners_of(mesh, T);
    const Heights of_T(t, mesh.normals[F], f[0]);
    if (!of_T.stands_on(rounding)) {
        return std::nullopt;
    }
    const Heights of_F(f, mesh.normals[T], t[0]);
    if (!of_F.stands_on(rounding)) {
        return std::nullopt;
    }
    // Both sections lie on the line in which the planes meet, which rounding moves the more the flatter they meet.
    const Vec3 cross = mesh.normals[F].cross(mesh.normals[T]);
    const double sine = cross.norm();
    if (sine == 0.0) {
        return std::nullopt;
    }
    const auto [T_low, T_high] = section(t, of_T, f[0], cross / sine, rounding);
    const auto [F_low, F_high] = section(f, of_F, f[0], cross / sine, rounding);
    const double slack = 2.0 * rounding / sine;
    return std::max(T_low, F_low) <= std::min(T_high, F_high) + slack ? std::optional(of_T) : std::nullopt;
}

/// The triangles of each region, and trees of them that are made when they are first asked for.
class RegionTrees {
  public:
    explicit RegionTrees(const Mesh& mesh) : mesh_(mesh), trees_(mesh.region_count) {
        std::vector<Box> boxes(mesh.region_count);
        first_.assign(mesh.region_count + std::size_t{1}, 0);
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            boxes[mesh.region[t]].extend(mesh.box(t));
            ++first_[mesh.region[t] + std::size_t{1}];
        }
        for (std::size_t p = 0; p < mesh.region_count; ++p) {
            first_[p + 1] += first_[p];
        }
        members_.resize(mesh.triangles.size());
        std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            members_[next[mesh.region[t]]++] = t;
        }
        std::vector<Index> numbers(mesh.region_count);
        for (Index p = 0; p < mesh.region_count; ++p) {
            numbers[p] = p;
        }
        regions_ = BoxTree(std::move(boxes), std::move(numbers));
    }

    /// Boxes of whole regions.
    const BoxTree& regions() const { return regions_; }

    /// Boxes of the triangles of one.
    const BoxTree& triangles(Index region) {
        if (trees_[region].empty()) {
            std::vector<Index> items(members_.begin() + static_cast<std::ptrdiff_t>(first_[region]),
                                     members_.begin() + static_cast<std::ptrdiff_t>(first_[region + std::size_t{1}]));
            std::vector<Box> boxes;
            boxes.reserve(items.size());
            for (const Index t : items) {
                boxes.push_back(mesh_.box(t));
            }
            trees_[region] = BoxTree(std::move(boxes), std::move(items));
        }
        return trees_[region];
    }

  private:
    const Mesh& mesh_;
    std::vector<std::size_t> first_; ///< #regions + 1
    std::vector<Index> members_;     ///< #T, by region
    BoxTree regions_;
    std::vector<BoxTree> trees_; ///< #regions
};

} // namespace

double wall_rounding(const Mesh& mesh) {
    return std::max(mesh.diameter() * 0x1p-21, mesh.magnitude() * 0x1p-44);
}

std::vector<Separator> find_separators(const Mesh& mesh) {
    std::vector<Separator> found;
    if (mesh.region_count < 2) {
        return found;
    }
    const double rounding = wall_rounding(mesh);
    RegionTrees trees(mesh);
    for (Index F = 0; F < mesh.triangles.size(); ++F) {
        const Box box = grown(mesh.box(F), rounding);
        trees.regions().visit(box, [&](Index region, const Box& whole) {
            // A region that lies on one side of the plane, as floors do of the walls around them, is soon done with.
            const Vec3 normal = mesh.normals[F], foot = mesh.corner(F, 0);
            const double middle = normal.dot(whole.center() - foot);
            const double half = 0.5 * normal.cwiseAbs().dot(whole.sizes());
            if (region == mesh.region[F] || middle - half >= -rounding || middle + half <= rounding) {
                return false;
            }
            bool below = false, above = false;
            const bool parted = trees.triangles(region).visit(box, [&](Index T, const Box&) {
                if (const auto height = touches(mesh, F, T, rounding)) {
                    below = below || height->low < -rounding;
                    above = above || height->high > rounding;
                }
                return below && above;
            });
            if (parted) {
                found.push_back({region, F});
            }
            return false;
        });
    }
    std::sort(found.begin(), found.end(), [](const Separator& a, const Separator& b) {
        return a.region < b.region || (a.region == b.region && a.triangle < b.triangle);
    });
    return found;
}

Separators::Separators(const Mesh& mesh, const SiteSet& sites, std::span<const double> support)
    : mesh_(&mesh), sites_(&sites), rounding_(mesh.magnitude() * 0x1p-44) {
    const std::vector<Separator> found = find_separators(mesh);
    if (found.empty()) {
        return;
    }
    tree_.assign(mesh.region_count, none);
    for (std::size_t first = 0, last = 0; first < found.size(); first = last) {
        std::vector<Box> boxes;
        std::vector<Index> items;
        for (; last < found.size() && found[last].region == found[first].region; ++last) {
            boxes.push_back(mesh.box(found[last].triangle));
            items.push_back(found[last].triangle);
        }
        tree_[found[first].region] = static_cast<Index>(trees_.size());
        trees_.emplace_back(std::move(boxes), std::move(items));
    }
    support_.assign(support.begin(), support.end());
    near_.assign(sites.size(), 0);
    for (Index i = 0; i < sites.size(); ++i) {
        if (!any(sites.region[i])) {
            continue;
        }
        // Lifted segments leave the ball around the support by less than its radius (they are lifted by at most half a
        // radius and 2^-6 of it).
        const double reach = 2.0 * support[i];
        const Vec3& centre = sites.points[i].position;
        near_[i] = trees_[tree_[sites.region[i]]].visit(grown(Box(centre), reach), [&](Index, const Box& box) {
            return box.squaredExteriorDistance(centre) < reach * reach;
        });
    }
}

bool Separators::crosses(Index triangle, const Vec3& a, const Vec3& b, double& t) const {
    const Vec3& normal = mesh_->normals[triangle];
    const Vec3& foot = mesh_->corner(triangle, 0);
    const double at_a = normal.dot(a - foot), at_b = normal.dot(b - foot);
    if (!((at_a > rounding_ && at_b < -rounding_) || (at_a < -rounding_ && at_b > rounding_))) {
        return false;
    }
    WatertightRay::Meeting meeting;
    t = at_a / (at_a - at_b);
    return WatertightRay(a, b - a).meets(foot, mesh_->corner(triangle, 1), mesh_->corner(triangle, 2), meeting);
}

double Separators::lift(const BoxTree& tree, const Vec3& from, const Vec3& normal, double wanted) const {
    const Vec3 to = from + wanted * normal;
    double clear = 1.0;
    tree.visit(Box(from).extend(to), [&](Index triangle, const Box&) {
        double t = 1.0;
        if (crosses(triangle, from, to, t)) {
            clear = std::min(clear, 0.5 * t);
        }
        return false;
    });
    return clear * wanted;
}

bool Separators::hides(Index site, const SurfacePoint& x) const {
    const SurfacePoint& p = sites_->points[site];
    const BoxTree& tree = trees_[tree_[sites_->region[site]]];
    const Vec3 away = x.position - p.position;
    const double least = 0x1p-6 * support_[site];
    const double wanted_p = least + 0.5 * std::max(0.0, -away.dot(p.normal));
    const double wanted_x = least + 0.5 * std::max(0.0, away.dot(x.normal));
    // Most pairs have none in the box around them.
    Box around(p.position);
    around.extend(x.position).extend(p.position + wanted_p * p.normal).extend(x.position + wanted_x * x.normal);
    if (!tree.visit(around, [](Index, const Box&) { return true; })) {
        return false;
    }
    const Vec3 a = p.position + lift(tree, p.position, p.normal, wanted_p) * p.normal;
    const Vec3 b = x.position + lift(tree, x.position, x.normal, wanted_x) * x.normal;
    return tree.visit(Box(a).extend(b), [&](Index triangle, const Box&) {
        double t = 0.0;
        return crosses(triangle, a, b, t);
    });
}

} // namespace difusa
