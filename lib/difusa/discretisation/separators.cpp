#include <difusa/discretisation/separators.h>

#include <difusa/core/parallel.h>
#include <difusa/discretisation/obstacles.h>
#include <difusa/discretisation/region_trees.h>
#include <difusa/mesh/triangle_tree.h>
#include <difusa/rays/watertight.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

namespace difusa {

namespace {

using Box = BoxTree::Box;
using Corners = std::array<Vec3, 3>;

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
    const Corners f = mesh.corners(F), t = mesh.corners(T);
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

} // namespace

double wall_rounding(const Mesh& mesh) {
    return std::max(mesh.diameter() * 0x1p-21, mesh.magnitude() * 0x1p-44);
}

std::vector<Separator> find_separators(const Mesh& mesh) {
    RegionTrees trees(mesh);
    return find_separators(mesh, trees, Execution{});
}

std::vector<Separator> find_separators(const Mesh& mesh, const RegionTrees& trees, const Execution& execution) {
    if (mesh.region_count < 2) {
        return {};
    }
    const double rounding = wall_rounding(mesh);
    const auto parted_by = [&](Index F, std::vector<Index>& regions) {
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
                regions.push_back(region);
            }
            return false;
        });
    };
    std::vector<Separator> found = regions_by_triangle(mesh, parted_by, execution);
    std::sort(found.begin(), found.end(), [](const Separator& a, const Separator& b) {
        return a.region < b.region || (a.region == b.region && a.triangle < b.triangle);
    });
    return found;
}

namespace {

constexpr double least_lift = 0x1p-6, most_lift = 0x1p-2; ///< of a line of sight's ends, in radii of the support

/// What lines of sight between points of each region, lifted off it, stay within.
std::vector<SightReach> sight_reach(const SiteSet& sites, std::span<const double> support,
                                    const std::vector<Index>& planes) {
    std::vector<SightReach> reach(planes.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        // Points of a bent region lie up to the radius below the tangent plane of another.
        SightReach& here = reach[sites.region[i]];
        here.plane = planes[sites.region[i]];
        const bool level = here.plane != none;
        here.around = std::max(here.around, (level ? most_lift : 2.0) * support[i]);
        here.lift = std::max(here.lift, (level ? most_lift : most_lift + 0.5) * support[i]);
    }
    return reach;
}

/// The radii of the supports, but at most the extent of the site's region: no point of it is farther away.
std::vector<double> reach_within_region(const RegionTrees& regions, const SiteSet& sites,
                                        std::span<const double> support) {
    std::vector<double> reach(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        reach[i] = std::min(support[i], regions.box(sites.region[i]).diagonal().norm());
    }
    return reach;
}

/// A segment, by its centre and half of its extent: of boxes in a tree of very many triangles it meets few, though all
/// are within its own.
class SightLine {
  public:
    SightLine(const Vec3& a, const Vec3& b, double rounding)
        : centre_(0.5 * (a + b)), half_(0.5 * (b - a)), extent_(half_.cwiseAbs()), rounding_(rounding) {}

    /// No axis and no direction across the segment and an axis tells them apart.
    bool meets(const Box& box) const {
        const Vec3 m = centre_ - 0.5 * (box.min() + box.max());
        const Vec3 h = (0.5 * (box.max() - box.min())).array() + rounding_;
        if ((m.cwiseAbs().array() > (h + extent_).array()).any()) {
            return false;
        }
        for (Eigen::Index i = 0; i < 3; ++i) {
            const Eigen::Index j = (i + 1) % 3, k = (i + 2) % 3;
            if (std::abs(m[j] * half_[k] - m[k] * half_[j]) > h[j] * extent_[k] + h[k] * extent_[j]) {
                return false;
            }
        }
        return true;
    }

  private:
    Vec3 centre_, half_, extent_;
    double rounding_;
};

} // namespace

Separators::Separators(const Mesh& mesh, const SiteSet& sites, std::span<const double> support,
                       const Execution& execution)
    : mesh_(&mesh), sites_(&sites), rounding_(mesh.magnitude() * 0x1p-44) {
    if (mesh.convex) {
        return;
    }
    const Unreported unreported(execution);
    const auto regions = std::make_shared<const RegionTrees>(mesh);
    support_ = reach_within_region(*regions, sites, support);
    const std::vector<Index> planes = planes_of_regions(mesh, *regions, wall_rounding(mesh));
    obstacles_ =
        std::make_shared<const Obstacles>(mesh, regions, sight_reach(sites, support_, planes), wall_rounding(mesh));
    sight_.resize(mesh.region_count);
    for (const Separator& separator : find_separators(mesh, *regions, unreported)) {
        sight_[separator.region].walls.push_back(separator.triangle);
    }
    parallel_for(sight_.size(), 16, unreported, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t region = begin; region < end; ++region) {
            Sight& here = sight_[region];
            here.tree = tree_of_triangles(mesh, here.walls);
            here.obstructed = !here.walls.empty() || obstacles_->any(static_cast<Index>(region));
        }
    });
    near_.assign(sites.size(), 0);
    // A region that is flat, or a closed body on which nothing stands, is not looked at as an obstacle to itself.
    std::vector<char> simple = closed_regions(mesh);
    for (Index region = 0; region < mesh.region_count; ++region) {
        const bool flat = planes[region] != none;
        simple[region] = flat || (simple[region] != 0 && sight_[region].walls.empty()) ? 1 : 0;
    }
    find_near(planes, simple, unreported);
    any_ = std::any_of(sight_.begin(), sight_.end(), [](const Sight& here) { return here.obstructed; });
}

/// Which sites have an obstacle, or a fold of their region, within reach of their lines of sight.
void Separators::find_near(const std::vector<Index>& planes, const std::vector<char>& simple,
                           const Execution& execution) {
    std::vector<std::uint8_t> folded(sites_->size(), 0);
    std::vector<std::optional<FoldSearch>> searches(execution.threads);
    parallel_for(sites_->size(), 1024, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        if (!searches[worker]) {
            searches[worker].emplace(*mesh_, obstacles_->trees());
        }
        for (std::size_t i = begin; i < end; ++i) {
            const Index region = sites_->region[i];
            const double reach = (planes[region] != none ? 1.0 + most_lift : 2.0) * support_[i];
            const Vec3& centre = sites_->points[i].position;
            const auto within = [&](const Box& box) { return box.squaredExteriorDistance(centre) < reach * reach; };
            const bool close = sight_[region].obstructed &&
                               obstacles_->visit_others(region, within, [&](Index T) { return blocks(T, region); });
            folded[i] = simple[region] == 0 && !searches[worker]->unfolded(sites_->points[i], support_[i]) ? 1 : 0;
            near_[i] = close || folded[i] != 0 ? 1 : 0;
        }
    });
    for (std::size_t i = 0; i < sites_->size(); ++i) {
        Sight& here = sight_[sites_->region[i]];
        here.by_itself = here.by_itself || folded[i] != 0;
    }
    for (Index region = 0; region < sight_.size(); ++region) {
        Sight& here = sight_[region];
        here.obstructed = here.obstructed || here.by_itself;
        here.by_itself = simple[region] == 0 && here.obstructed;
    }
}

/// True if lines of sight of the region end at the triangle of another one.
bool Separators::blocks(Index triangle, Index region) const {
    const std::vector<Index>& walls = sight_[region].walls;
    return std::binary_search(walls.begin(), walls.end(), triangle) || obstacles_->may_obstruct(triangle, region);
}

/// Calls `act(T, known)` for triangles in boxes that `meets` says yes to, until it returns true; `known`: T is of the
/// region itself. Of other regions' triangles, `blocks` tells which are obstacles.
template <class Meets, class Act>
bool Separators::visit_obstacles(Index region, const Meets& meets, const Act& act) const {
    if (obstacles_->visit_others(region, meets, [&](Index T) { return act(T, false); })) {
        return true;
    }
    return sight_[region].by_itself &&
           obstacles_->trees().triangles(region).visit_where(meets, [&](Index T) { return act(T, true); });
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

bool Separators::crosses_wall(Index region, const Vec3& a, const Vec3& b) const {
    const auto meets = [segment = SightLine(a, b, rounding_)](const Box& box) { return segment.meets(box); };
    return sight_[region].tree.visit_where(meets, [&](Index triangle) {
        double t = 0.0;
        return crosses(triangle, a, b, t);
    });
}

bool Separators::crosses_obstacle(Index region, const Vec3& a, const Vec3& b) const {
    const auto meets = [segment = SightLine(a, b, rounding_)](const Box& box) { return segment.meets(box); };
    return visit_obstacles(region, meets, [&](Index triangle, bool known) {
        double t = 0.0;
        return crosses(triangle, a, b, t) && (known || blocks(triangle, region));
    });
}

Vec3 Separators::lifted(Index region, const Vec3& from, const Vec3& normal, double wanted) const {
    const Vec3 to = from + wanted * normal;
    double clear = 1.0;
    const auto meets = [segment = SightLine(from, to, rounding_)](const Box& box) { return segment.meets(box); };
    visit_obstacles(region, meets, [&](Index triangle, bool known) {
        double t = 1.0;
        if (crosses(triangle, from, to, t) && 0.5 * t < clear && (known || blocks(triangle, region))) {
            clear = 0.5 * t;
        }
        return false;
    });
    return from + clear * wanted * normal;
}

bool Separators::hides(Index site, const SurfacePoint& x) const {
    const SurfacePoint& p = sites_->points[site];
    const Index region = sites_->region[site];
    const Vec3 away = x.position - p.position;
    const double below_p = 0.5 * std::max(0.0, -away.dot(p.normal)), below_x = 0.5 * std::max(0.0, away.dot(x.normal));
    const double least = least_lift * support_[site];
    // Most pairs have none in the box around them.
    Box around(p.position);
    around.extend(x.position)
        .extend(p.position + (least + below_p) * p.normal)
        .extend(x.position + (least + below_x) * x.normal);
    const auto overlaps = [&](const Box& box) { return box.intersects(around); };
    if (!visit_obstacles(region, overlaps, [](Index, bool) { return true; })) {
        return false;
    }
    for (double share = least_lift; share <= most_lift; share *= 4.0) {
        const double lift = share * support_[site];
        const Vec3 a = lifted(region, p.position, p.normal, lift + below_p),
                   b = lifted(region, x.position, x.normal, lift + below_x);
        if (share == least_lift && crosses_wall(region, a, b)) {
            return true;
        }
        if (!crosses_obstacle(region, a, b)) {
            return false;
        }
        // Under a low ceiling over one of them, as between a shelf and the table below it.
        const double low = std::min((a - p.position).norm(), (b - x.position).norm());
        if (share == least_lift && low > 4.0 * rounding_ && low < lift &&
            !crosses_obstacle(region, p.position + low * p.normal, x.position + low * x.normal)) {
            return false;
        }
    }
    return true;
}

} // namespace difusa
