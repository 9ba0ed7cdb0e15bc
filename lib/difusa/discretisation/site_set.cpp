#include <difusa/discretisation/site_set.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/mesh/point_tree.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

namespace difusa {

namespace {

double distance_between(const SiteSet& sites, Index i, Index j) {
    return site_distance(sites.points[i].position, sites.points[i].normal, sites.region[i], sites.points[j].position,
                         sites.points[j].normal, sites.region[j]);
}

/// The neighbours found; buffers reused between searches.
struct NeighbourSearch {
    std::vector<Index> found;
    std::vector<double> squared, distance;
};

/// Site distance from site `i` to its m-th nearest one in the tree of its region, or a negative number if fewer than m
/// are at a finite distance.
double mth_distance(const SiteSet& sites, const PointTree& tree, Index i, std::size_t m, NeighbourSearch& search) {
    auto& [found, squared, distance] = search;
    // The site distance is never smaller than the Euclidean one: once the m-th site distance among the k nearest points
    // does not exceed the Euclidean distance of the k-th, no farther point can change it.
    for (std::size_t k = 2 * m + 2;; k *= 2) {
        k = std::min(k, tree.size());
        found.resize(k);
        squared.resize(k);
        tree.nearest(sites.points[i].position, found, squared);
        distance.clear();
        for (const Index other : found) {
            if (other != i) {
                distance.push_back(distance_between(sites, i, other));
            }
        }
        if (distance.size() >= m) {
            const auto mth = distance.begin() + static_cast<std::ptrdiff_t>(m) - 1;
            std::nth_element(distance.begin(), mth, distance.end());
            if (k == tree.size() || *mth <= std::sqrt(squared.back())) {
                return std::isfinite(*mth) ? *mth : -1.0;
            }
        }
        if (k == tree.size()) {
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

void check_points(const Mesh& mesh, const std::vector<SurfacePoint>& points) {
    if (points.empty()) {
        throw UsageError("there are no sites: the sampler has placed none");
    }
    const double rounding = 1e-6 * mesh.diameter() + 1e-12 * mesh.magnitude();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SurfacePoint& x = points[i];
        if (x.face >= mesh.triangles.size() ||
            !((x.position - mesh.at(x.face, x.u, x.v).position).norm() <= rounding)) {
            throw UsageError("site number " + std::to_string(i) + ", at " + coordinates(x.position) +
                             ", is not at the place of a triangle of the mesh that it states: the sampler is at fault");
        }
    }
}

} // namespace

SiteSet make_site_set(const Mesh& mesh, std::vector<SurfacePoint> points, double spacing, int neighbours,
                      const Execution& execution, const SizeField* size) {
    DIFUSA_REQUIRE(neighbours >= 1 && spacing > 0.0);
    check_points(mesh, points);
    SiteSet sites;
    sort_along_z_curve(mesh, points);
    sites.points = std::move(points);
    for (SurfacePoint& site : sites.points) {
        site = mesh.shaded(site);
    }
    sites.spacing = spacing;
    sites.neighbours = neighbours;
    sites.region.resize(sites.size());
    sites.radius.assign(sites.size(), 0.0);
    sites.area.resize(sites.size());

    std::vector<std::vector<Index>> members(mesh.region_count);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        sites.region[i] = mesh.region[sites.points[i].face];
        members[sites.region[i]].push_back(static_cast<Index>(i));
    }
    std::vector<Vec3> low(mesh.region_count, mesh.high), high(mesh.region_count, mesh.low);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const Index p : mesh.triangles[t]) {
            low[mesh.region[t]] = low[mesh.region[t]].cwiseMin(mesh.points[p]);
            high[mesh.region[t]] = high[mesh.region[t]].cwiseMax(mesh.points[p]);
        }
    }

    std::vector<std::unique_ptr<PointTree>> regions(mesh.region_count);
    const Execution silent = execution.silent();
    parallel_for(regions.size(), 1, silent, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t region = begin; region < end; ++region) {
            if (!members[region].empty()) {
                regions[region] = std::make_unique<PointTree>(sites.points, members[region]);
            }
        }
    });
    const auto m = static_cast<std::size_t>(neighbours);
    parallel_for(sites.size(), 256, silent, [&](std::size_t begin, std::size_t end, unsigned) {
        NeighbourSearch search;
        for (std::size_t i = begin; i < end; ++i) {
            const Index region = sites.region[i];
            const std::vector<Index>& own = members[region];
            const double diameter = (high[region] - low[region]).norm();
            const double found =
                own.size() > m ? mth_distance(sites, *regions[region], static_cast<Index>(i), m, search) : -1.0;
            const double own_spacing = size != nullptr ? size->reach(sites.points[i].position, region) : spacing;
            const double least = own_spacing * (1.0 + 0x1p-10);
            sites.radius[i] = std::max(found < 0.0 ? diameter : std::min(found, diameter), least);
            sites.area[i] = std::numbers::pi * sites.radius[i] * sites.radius[i] / static_cast<double>(neighbours + 1);
        }
    });
    return sites;
}

double SiteSet::mean(const Eigen::Ref<const Values>& at_points) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(at_points.rows()) >= size());
    double sum = 0.0, all = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
        const double weight = std::max(0.0, area[i]); // integrals of basis functions with negative parts
        sum += weight * at_points.row(static_cast<Eigen::Index>(i)).mean();
        all += weight;
    }
    return all > 0.0 ? sum / all : 0.0;
}

} // namespace difusa
