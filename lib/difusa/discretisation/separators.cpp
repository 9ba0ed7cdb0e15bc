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
#include <numeric>
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

/// A low gap, under something close to the surface: its air in radii of the largest support of the region, and over the
/// air before the other point. The finer the sites, the less it matters whether they are seen from the gap.
constexpr double low_gap = 1.0 / 48.0, over_open_air = 0.25;
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

/// A segment that boxes are tested against: of a tree of very many triangles it meets few, though all are within its
/// own box.
class SightLine {
  public:
    SightLine(const Vec3& a, const Vec3& b, double rounding) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = static_cast<Eigen::Index>(k);
            // Parallel to the sides of a box: in between for all of the segment, or for none.
            const double along = b[i] - a[i], least = std::numeric_limits<double>::min() * 0x1p8;
            inverse_[k] = 1.0 / (std::abs(along) < least ? least : along);
            low_[k] = a[i] + rounding;
            high_[k] = a[i] - rounding;
        }
    }

    /// True if some part of the segment is closer to the box than rounding.
    bool meets(const Box& box) const {
        double from = 0.0, to = 1.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = static_cast<Eigen::Index>(k);
            const double at_low = (box.min()[i] - low_[k]) * inverse_[k];
            const double at_high = (box.max()[i] - high_[k]) * inverse_[k];
            from = std::max(from, std::min(at_low, at_high));
            to = std::min(to, std::max(at_low, at_high));
        }
        return from <= to;
    }

  private:
    std::array<double, 3> inverse_{}, low_{}, high_{};
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
    for (std::size_t i = 0; i < sites.size(); ++i) {
        double& reach = sight_[sites.region[i]].reach;
        reach = std::max(reach, support_[i]);
    }
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
    find_clearances(unreported);
    any_ = std::any_of(sight_.begin(), sight_.end(), [](const Sight& here) { return here.obstructed; });
}

/// Which sites have an obstacle, or a fold of their region, within reach of their lines of sight.
void Separators::find_near(const std::vector<Index>& planes, const std::vector<char>& simple,
                           const Execution& execution) {
    /// What is known of the last region.
    struct Search {
        FoldSearch folds;
        Index region = none;
        std::vector<Index> passed; ///< #T: the region that the triangle is known not to block
        Index blocked_by = none;
    };
    std::vector<Index> order(sites_->size()); // by region
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(),
                     [this](Index i, Index j) { return sites_->region[i] < sites_->region[j]; });
    std::vector<std::uint8_t> folded(sites_->size(), 0);
    std::vector<std::optional<Search>> searches(execution.threads);
    parallel_for(order.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        if (!searches[worker]) {
            searches[worker].emplace(Search{{*mesh_, obstacles_->trees()}, none, {}, none});
            searches[worker]->passed.assign(mesh_->triangles.size(), none);
        }
        Search& search = *searches[worker];
        for (std::size_t k = begin; k < end; ++k) {
            const Index i = order[k], region = sites_->region[i];
            const double reach = (planes[region] != none ? 1.0 + most_lift : 2.0) * support_[i];
            const Vec3& centre = sites_->points[i].position;
            const auto within = [&](const Box& box) { return box.squaredExteriorDistance(centre) < reach * reach; };
            if (search.region != region) {
                search.region = region;
                search.blocked_by = none;
            }
            const auto stops = [&](Index T) {
                if (search.passed[T] == region) {
                    return false;
                }
                if (!blocks(T, region)) {
                    search.passed[T] = region;
                    return false;
                }
                search.blocked_by = T;
                return true;
            };
            const bool close =
                sight_[region].obstructed && ((search.blocked_by != none && within(mesh_->box(search.blocked_by))) ||
                                              obstacles_->visit_others(region, within, stops));
            folded[i] = simple[region] == 0 && !search.folds.unfolded(sites_->points[i], support_[i]) ? 1 : 0;
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

/// Of the sites: as far as points of their supports ask.
void Separators::find_clearances(const Execution& execution) {
    clearance_.resize(sites_->size());
    parallel_for(sites_->size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            if (near_[i] != 0) {
                Viewpoint site(sites_->points[i]);
                clearance_[i] = clearance(sites_->region[i], site, (most_lift + 0.5) * support_[i]);
            }
        }
    });
}

/// True if lines of sight of the region end at the triangle of another one.
bool Separators::blocks(Index triangle, Index region) const {
    const std::vector<Index>& walls = sight_[region].walls;
    return std::binary_search(walls.begin(), walls.end(), triangle) || obstacles_->may_obstruct(triangle, region);
}

/// The triangles of the regions, but for its own, whose boxes overlap a box around a viewpoint.
std::span<const BoxTree* const> Separators::others(Index region, Viewpoint& x, const Box& box) const {
    if (!x.around_.contains(box)) {
        // Half as much again, so that it need not grow with each site.
        const Vec3 &centre = x.x_.position, reach = (box.max() - centre).cwiseMax(centre - box.min());
        x.around_.extend(Box(centre - 1.5 * reach, centre + 1.5 * reach));
        x.others_.clear();
        obstacles_->trees().regions().visit(x.around_, [&](Index other, const Box&) {
            if (other != region) {
                x.others_.push_back(&obstacles_->trees().triangles(other));
            }
            return false;
        });
    }
    return x.others_;
}

/// Calls `act(T, known)` for triangles of the region and of others in boxes that `meets` says yes to, until it returns
/// true; `known`: T is of the region itself. Of other regions' triangles, `blocks` tells which are obstacles.
template <class Meets, class Act>
bool Separators::visit_obstacles(Index region, std::span<const BoxTree* const> others, const Meets& meets,
                                 const Act& act) const {
    for (const BoxTree* other : others) {
        if (other->visit_where(meets, [&](Index T) { return act(T, false); })) {
            return true;
        }
    }
    return sight_[region].by_itself &&
           obstacles_->trees().triangles(region).visit_where(meets, [&](Index T) { return act(T, true); });
}

bool Separators::crosses(Index triangle, const Vec3& a, const Vec3& b) const {
    const Vec3& normal = mesh_->normals[triangle];
    const Vec3& foot = mesh_->corner(triangle, 0);
    const double at_a = normal.dot(a - foot), at_b = normal.dot(b - foot);
    if (!((at_a > rounding_ && at_b < -rounding_) || (at_a < -rounding_ && at_b > rounding_))) {
        return false;
    }
    WatertightRay::Meeting meeting;
    return WatertightRay(a, b - a).meets(foot, mesh_->corner(triangle, 1), mesh_->corner(triangle, 2), meeting);
}

bool Separators::crosses_wall(Index region, const Vec3& a, const Vec3& b) const {
    const auto meets = [segment = SightLine(a, b, rounding_)](const Box& box) { return segment.meets(box); };
    return sight_[region].tree.visit_where(meets, [&](Index triangle) { return crosses(triangle, a, b); });
}

bool Separators::crosses_obstacle(Index region, std::span<const BoxTree* const> others, const Vec3& a, const Vec3& b,
                                  Index& last) const {
    if (last != none && crosses(last, a, b)) {
        return true;
    }
    const auto meets = [segment = SightLine(a, b, rounding_)](const Box& box) { return segment.meets(box); };
    return visit_obstacles(region, others, meets, [&](Index triangle, bool known) {
        if (!crosses(triangle, a, b) || !(known || blocks(triangle, region))) {
            return false;
        }
        last = triangle;
        return true;
    });
}

Separators::Clearance Separators::clearance(Index region, Viewpoint& viewpoint, double range) const {
    Clearance air{range, std::numeric_limits<double>::infinity()};
    const SurfacePoint& from = viewpoint.x_;
    const Vec3 to = from.position + range * from.normal;
    const WatertightRay ray(from.position, from.normal);
    const auto meets = [segment = SightLine(from.position, to, rounding_)](const Box& box) {
        return segment.meets(box);
    };
    const std::span<const BoxTree* const> near =
        others(region, viewpoint, grown(Box(from.position).extend(to), rounding_));
    visit_obstacles(region, near, meets, [&](Index triangle, bool known) {
        const Vec3& foot = mesh_->corner(triangle, 0);
        const double height = mesh_->normals[triangle].dot(from.position - foot);
        const double slope = mesh_->normals[triangle].dot(from.normal);
        // Crossed once the other end is beyond the plane by more than rounding.
        const bool ahead = height > 0.0 ? slope < 0.0 : slope > 0.0;
        if (!(std::abs(height) > rounding_) || !ahead) {
            return false;
        }
        const double crossed = (std::abs(height) + rounding_) / std::abs(slope);
        WatertightRay::Meeting meeting;
        if (crossed < std::min(range, air.first) &&
            ray.meets(foot, mesh_->corner(triangle, 1), mesh_->corner(triangle, 2), meeting) &&
            (known || blocks(triangle, region))) {
            air.first = crossed;
        }
        return false;
    });
    return air;
}

namespace {

/// How far along its normal a point is lifted: half the way to what is in the way.
double lift_within(const Separators::Clearance& air, double wanted) {
    return wanted > air.first ? 0.5 * air.first : wanted;
}

} // namespace

double Separators::lift(Index site, double wanted) const {
    const Clearance& known = clearance_[site];
    if (wanted <= known.searched || known.first < known.searched) {
        return lift_within(known, wanted);
    }
    Viewpoint from(sites_->points[site]);
    return lift_within(clearance(sites_->region[site], from, wanted), wanted);
}

double Separators::lift(Index region, Viewpoint& x, double wanted) const {
    if (wanted > x.clearance_.searched && !(x.clearance_.first < x.clearance_.searched)) {
        x.clearance_ = clearance(region, x, 2.0 * wanted);
    }
    return lift_within(x.clearance_, wanted);
}

bool Separators::hides(Index site, const SurfacePoint& x) const {
    Viewpoint from(x);
    return hides(site, from);
}

bool Separators::hides(Index site, Viewpoint& viewpoint) const {
    const SurfacePoint &p = sites_->points[site], &x = viewpoint.x_;
    const Index region = sites_->region[site];
    const Vec3 away = x.position - p.position;
    const double below_p = 0.5 * std::max(0.0, -away.dot(p.normal)), below_x = 0.5 * std::max(0.0, away.dot(x.normal));
    const double least = least_lift * support_[site];
    const double gap = low_gap * sight_[region].reach, searched = std::max(least, gap);
    if (!sight_[region].by_itself) {
        // Most pairs have none in the box around them.
        Box around(p.position);
        around.extend(x.position)
            .extend(p.position + (searched + below_p) * p.normal)
            .extend(x.position + (searched + below_x) * x.normal);
        const auto overlaps = [&](const Box& box) { return box.intersects(around); };
        const std::span<const BoxTree* const> near = others(region, viewpoint, around);
        if (!visit_obstacles(region, near, overlaps, [](Index, bool) { return true; })) {
            return false;
        }
    }
    const auto lifted = [&](double wanted) {
        return std::pair(lift(site, wanted + below_p), lift(region, viewpoint, wanted + below_x));
    };
    const auto is_clear = [&](double above_p, double above_x) {
        const Vec3 a = p.position + above_p * p.normal, b = x.position + above_x * x.normal;
        const Box around = Box(p.position).extend(x.position).extend(a).extend(b);
        const std::span<const BoxTree* const> near = others(region, viewpoint, grown(around, rounding_));
        return !crosses_obstacle(region, near, a, b, viewpoint.last_);
    };
    if (!sight_[region].tree.empty()) {
        const auto [above_p, above_x] = lifted(least);
        if (crosses_wall(region, p.position + above_p * p.normal, x.position + above_x * x.normal)) {
            return true;
        }
    }
    // Light that gets in along the surface does not get far.
    const auto [open_p, open_x] = lifted(most_lift * support_[site]);
    const double low = std::min(open_p, open_x);
    if (low < 0.5 * gap && low < over_open_air * std::max(open_p, open_x)) {
        return !is_clear(open_p, open_x);
    }
    static_assert(most_lift == 16.0 * least_lift);
    // Close to a surface of many small triangles a line passes many of their boxes: it is not the first to be tried.
    for (const double share : {4.0 * least_lift, least_lift, most_lift}) {
        const double wanted = share * support_[site];
        const auto [above_p, above_x] = lifted(wanted);
        if (is_clear(above_p, above_x)) {
            return false;
        }
        // Under a low ceiling over one of them, as between a shelf and the table below it.
        const double lower = std::min(above_p, above_x);
        if (share == least_lift && lower > 4.0 * rounding_ && lower < wanted && is_clear(lower, lower)) {
            return false;
        }
    }
    return true;
}

} // namespace difusa
