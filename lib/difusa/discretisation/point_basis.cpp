#include <difusa/discretisation/point_basis.h>

#include <difusa/mesh/point_tree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace difusa {

/// Search trees of the sites: one per region, and one of all sites for regions that have none.
struct PointBasis::NearestSite {
    std::vector<PointTree> of_region; ///< empty: the region has no site
    std::optional<PointTree> all;     ///< absent: every region has a site

    NearestSite(const Mesh& mesh, const SiteSet& sites) {
        std::vector<std::vector<Index>> members(mesh.region_count);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            members[sites.region[i]].push_back(static_cast<Index>(i));
        }
        for (std::vector<Index>& own : members) {
            if (own.empty() && !all) {
                all.emplace(sites.points);
            }
            of_region.emplace_back(sites.points, std::move(own));
        }
    }

    const PointTree& tree(Index region) const { return of_region[region].size() > 0 ? of_region[region] : *all; }
};

PointBasis::PointBasis() = default;
PointBasis::~PointBasis() = default;

void PointBasis::bind(const Mesh& mesh, const SiteSet& sites) {
    DIFUSA_REQUIRE(sites.size() > 0);
    mesh_ = &mesh;
    sites_ = &sites;
    normalise_ = sums_to_one();
    prepare(sites);
    std::vector<double> reach(sites.size());
    std::transform(sites.radius.begin(), sites.radius.end(), reach.begin(), [this](double r) { return support(r); });
    grid_ = SupportGrid(mesh, sites, reach);
    separators_ = Separators(mesh, sites, reach);
    nearest_ = std::make_unique<NearestSite>(mesh, sites);
}

std::size_t PointBasis::size() const {
    return sites_->size();
}

Index PointBasis::nearest(const SurfacePoint& x) const {
    const Index region = mesh_->region[x.face];
    std::array<Index, 16> found{};
    std::array<double, 16> squared{};
    const std::size_t count = nearest_->tree(region).nearest(x.position, found, squared);
    const bool parted = separators_.any(region);
    Index nearest = found[0], in_sight = none;
    double least = std::numeric_limits<double>::infinity(), least_in_sight = least;
    for (std::size_t k = 0; k < count; ++k) {
        const Index i = found[k];
        const double d = site_distance(x.position, x.normal, region, sites_->points[i].position,
                                       sites_->points[i].normal, sites_->region[i]);
        if (d < least) {
            least = d;
            nearest = i;
        }
        if (parted && d < least_in_sight && !separators_.hides(i, x)) {
            least_in_sight = d;
            in_sight = i;
        }
    }
    return in_sight != none ? in_sight : nearest;
}

void PointBasis::evaluate(const SurfacePoint& x, BasisRow& row) const {
    evaluate_among(x, grid_.near(x.position, mesh_->region[x.face]), row);
}

void PointBasis::evaluate(std::span<const SurfacePoint> x, std::span<BasisRow> rows) const {
    constexpr std::size_t group = 16;
    std::array<SupportGrid::Query, group> queries;
    for (std::size_t first = 0; first < x.size(); first += group) {
        const std::size_t count = std::min(group, x.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            queries[i].position = &x[first + i].position;
            queries[i].region = mesh_->region[x[first + i].face];
        }
        grid_.near(std::span(queries).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            evaluate_among(x[first + i], queries[i].near, rows[first + i]);
        }
    }
}

void PointBasis::evaluate_among(const SurfacePoint& x, std::span<const Index> candidates, BasisRow& row) const {
    constexpr std::size_t at_once = 256;
    std::array<double, at_once> distance_buffer, cosine_buffer, radius_buffer; // NOLINT: filled before use
    std::vector<double> large;
    double *distance = distance_buffer.data(), *cosine = cosine_buffer.data(), *radius = radius_buffer.data();
    if (candidates.size() > at_once) {
        large.resize(3 * candidates.size());
        distance = large.data();
        cosine = distance + candidates.size();
        radius = cosine + candidates.size();
    }
    row.element.resize(candidates.size());
    std::size_t count = 0;
    const double px = x.position[0], py = x.position[1], pz = x.position[2];
    const double nx = x.normal[0], ny = x.normal[1], nz = x.normal[2];
    for (const Index site : candidates) {
        const SupportGrid::Candidate& c = grid_.candidate(site);
        const double dx = px - c.position[0], dy = py - c.position[1], dz = pz - c.position[2];
        const double squared = dx * dx + dy * dy + dz * dz;
        const double cosine_here = nx * c.normal[0] + ny * c.normal[1] + nz * c.normal[2];
        // Always written, kept only if inside: no branch to mispredict.
        row.element[count] = site;
        distance[count] = squared;
        cosine[count] = cosine_here;
        radius[count] = c.radius;
        count += static_cast<std::size_t>((squared < c.support_squared) & (cosine_here > perpendicular));
    }
    if (separators_.any()) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Index site = row.element[i];
            if (separators_.near(site) && separators_.hides(site, x)) {
                continue;
            }
            row.element[kept] = site;
            distance[kept] = distance[i];
            cosine[kept] = cosine[i];
            radius[kept] = radius[i];
            ++kept;
        }
        count = kept;
    }
    row.element.resize(count);
    row.weight.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        distance[i] = std::sqrt(distance[i]);
    }
    weigh(x, {row.element, {distance, count}, {cosine, count}, {radius, count}}, row.weight);
    if (!normalise_) {
        return;
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        sum += row.weight[i];
    }
    if (!(sum > 0.0) && sites_->is_dark(mesh_->region[x.face])) {
        row.clear();
        return;
    }
    if (!(sum > 0.0)) {
        row.element.assign(1, nearest(x));
        row.weight.assign(1, 1.0);
        return;
    }
    const double scale = 1.0 / sum;
    for (double& weight : row.weight) {
        weight *= scale;
    }
}

} // namespace difusa
