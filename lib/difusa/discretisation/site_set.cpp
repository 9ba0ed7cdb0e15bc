#include <difusa/discretisation/site_set.h>

#include <difusa/core/parallel.h>

#include <nanoflann.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

namespace difusa {

namespace {

/// The sites of one region as nanoflann wants to see them.
struct RegionCloud {
    const SiteSet& sites;
    const std::vector<Index>& members;
    std::size_t kdtree_get_point_count() const { return members.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const {
        return sites.points[members[i]].position[static_cast<Eigen::Index>(axis)];
    }
    template <class Box> bool kdtree_get_bbox(Box& /*box*/) const { return false; }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, RegionCloud>, RegionCloud, 3>;

double distance_between(const SiteSet& sites, Index i, Index j) {
    return site_distance(sites.points[i].position, sites.points[i].normal, sites.region[i], sites.points[j].position,
                         sites.points[j].normal, sites.region[j]);
}

/// Neighbours found, kept between searches.
struct Search {
    std::vector<std::uint32_t> found;
    std::vector<double> squared, distance;
};

/// Site distance from member `i` to its m-th nearest site, or a negative number if fewer than m are at a finite one.
double mth_distance(const SiteSet& sites, const std::vector<Index>& members, const Tree& tree, std::size_t i,
                    std::size_t m, Search& search) {
    auto& [found, squared, distance] = search;
    // The site distance is never smaller than the Euclidean one: once the m-th site distance among the k nearest
    // points does not exceed the Euclidean distance of the k-th, no farther point can change it.
    for (std::size_t k = 2 * m + 2;; k *= 2) {
        k = std::min(k, members.size());
        found.resize(k);
        squared.resize(k);
        tree.knnSearch(sites.points[members[i]].position.data(), k, found.data(), squared.data());
        distance.clear();
        for (const std::uint32_t other : found) {
            if (other != i) {
                distance.push_back(distance_between(sites, members[i], members[other]));
            }
        }
        if (distance.size() >= m) {
            const auto mth = distance.begin() + static_cast<std::ptrdiff_t>(m) - 1;
            std::nth_element(distance.begin(), mth, distance.end());
            if (k == members.size() || *mth <= std::sqrt(squared.back())) {
                return std::isfinite(*mth) ? *mth : -1.0;
            }
        }
        if (k == members.size()) {
            return -1.0;
        }
    }
}

} // namespace

namespace {

/// Position along the Z curve through the bounding box, 2^21 cells across.
std::uint64_t z_order(const Vec3& p, const Vec3& low, double size) {
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto cell = static_cast<std::uint64_t>(std::clamp((p[axis] - low[axis]) / size, 0.0, 1.0) * 0x1.fffffp20);
        for (unsigned bit = 0; bit < 21; ++bit) {
            code |= ((cell >> bit) & 1U) << (3 * bit + static_cast<unsigned>(axis));
        }
    }
    return code;
}

void sort_along_z_curve(const Mesh& mesh, std::vector<SurfacePoint>& points) {
    const double size = (mesh.high - mesh.low).maxCoeff();
    std::vector<std::pair<std::uint64_t, std::size_t>> order(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        order[i] = {z_order(points[i].position, mesh.low, size), i};
    }
    std::sort(order.begin(), order.end());
    std::vector<SurfacePoint> sorted;
    sorted.reserve(points.size());
    for (const auto& [code, i] : order) {
        sorted.push_back(points[i]);
    }
    points = std::move(sorted);
}

} // namespace

SiteSet make_site_set(const Mesh& mesh, std::vector<SurfacePoint> points, double spacing, int neighbours,
                      const Execution& execution) {
    DIFUSA_REQUIRE(neighbours >= 1 && spacing > 0.0);
    SiteSet sites;
    sort_along_z_curve(mesh, points);
    sites.points = std::move(points);
    sites.spacing = spacing;
    sites.neighbours = neighbours;
    sites.region.resize(sites.size());
    sites.radius.assign(sites.size(), 0.0);
    sites.area.resize(sites.size());

    std::vector<std::vector<Index>> members(mesh.region_count);
    std::vector<Index> member(sites.size()); // number of each site in its region
    for (std::size_t i = 0; i < sites.size(); ++i) {
        sites.region[i] = mesh.region[sites.points[i].face];
        member[i] = static_cast<Index>(members[sites.region[i]].size());
        members[sites.region[i]].push_back(static_cast<Index>(i));
    }
    std::vector<Vec3> low(mesh.region_count, mesh.high), high(mesh.region_count, mesh.low);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const Index p : mesh.triangles[t]) {
            low[mesh.region[t]] = low[mesh.region[t]].cwiseMin(mesh.points[p]);
            high[mesh.region[t]] = high[mesh.region[t]].cwiseMax(mesh.points[p]);
        }
    }

    struct Region {
        RegionCloud cloud;
        Tree tree;
        Region(const SiteSet& all, const std::vector<Index>& own) : cloud{all, own}, tree(3, cloud) {}
    };
    std::vector<std::unique_ptr<Region>> regions(mesh.region_count);
    const Execution silent{execution.threads, nullptr};
    parallel_for(regions.size(), 1, silent, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t region = begin; region < end; ++region) {
            if (!members[region].empty()) {
                regions[region] = std::make_unique<Region>(sites, members[region]);
            }
        }
    });
    const auto m = static_cast<std::size_t>(neighbours);
    const double least = spacing * (1.0 + 0x1p-10);
    parallel_for(sites.size(), 256, silent, [&](std::size_t begin, std::size_t end, unsigned) {
        Search search;
        for (std::size_t i = begin; i < end; ++i) {
            const Index region = sites.region[i];
            const std::vector<Index>& own = members[region];
            const double diameter = (high[region] - low[region]).norm();
            const double found =
                own.size() > m ? mth_distance(sites, own, regions[region]->tree, member[i], m, search) : -1.0;
            sites.radius[i] = std::max(found < 0.0 ? diameter : std::min(found, diameter), least);
            sites.area[i] = std::numbers::pi * sites.radius[i] * sites.radius[i] / static_cast<double>(neighbours + 1);
        }
    });
    return sites;
}

} // namespace difusa
