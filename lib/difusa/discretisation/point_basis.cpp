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

namespace {

constexpr std::size_t few_sites = 16, many_sites = 64; ///< sites looked at where no support is

} // namespace

PointBasis::PointBasis() = default;
PointBasis::~PointBasis() = default;

void PointBasis::bind(const Mesh& mesh, const SiteSet& sites, const Execution& execution) {
    DIFUSA_REQUIRE(sites.size() > 0);
    mesh_ = &mesh;
    sites_ = &sites;
    normalise_ = sums_to_one();
    prepare(sites);
    std::vector<double> reach(sites.size());
    std::transform(sites.radius.begin(), sites.radius.end(), reach.begin(), [this](double r) { return support(r); });
    grid_ = SupportGrid(mesh, sites, reach);
    separators_ = Separators(mesh, sites, reach, execution);
    nearest_ = std::make_unique<NearestSite>(mesh, sites);
}

std::size_t PointBasis::size() const {
    return sites_ != nullptr ? sites_->size() : 0;
}

Index PointBasis::nearest(const SurfacePoint& x) const {
    const Index region = mesh_->region[x.face];
    const PointTree& tree = nearest_->tree(region);
    const auto distance = [&](Index i) {
        return site_distance(x.position, x.normal, region, sites_->points[i].position, sites_->points[i].normal,
                             sites_->region[i]);
    };
    if (!separators_.any(region) || nearest_->of_region[region].size() == 0) {
        std::array<Index, few_sites> found{};
        std::array<double, few_sites> squared{};
        const std::size_t count = tree.nearest(x.position, found, squared);
        return *std::min_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count),
                                 [&](Index i, Index j) { return distance(i) < distance(j); });
    }
    Separators::Viewpoint viewpoint(x);
    std::vector<Index> found;
    std::vector<double> squared;
    for (std::size_t tried = 0, count = few_sites; tried < tree.size() && count <= many_sites; count *= 4) {
        found.resize(count);
        squared.resize(count);
        const std::size_t now = tree.nearest(x.position, found, squared);
        Index best = none;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = tried; k < now; ++k) {
            const double d = distance(found[k]);
            if ((best == none || d < least) && !separators_.hides(found[k], viewpoint)) {
                best = found[k];
                least = d;
            }
        }
        if (best != none) {
            return best;
        }
        tried = now;
    }
    return none;
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
        Separators::Viewpoint viewpoint(x);
        for (std::size_t i = 0; i < count; ++i) {
            const Index site = row.element[i];
            if (separators_.near(site) && separators_.hides(site, viewpoint)) {
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
        const Index site = nearest(x);
        row.clear();
        if (site != none) {
            row.element.push_back(site);
            row.weight.push_back(1.0);
        }
        return;
    }
    const double scale = 1.0 / sum;
    for (double& weight : row.weight) {
        weight *= scale;
    }
}

} // namespace difusa
