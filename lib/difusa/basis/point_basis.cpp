#include <difusa/basis/point_basis.h>

#include <nanoflann.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace difusa {

struct PointBasis::NearestSite {
    struct Cloud {
        const SiteSet& sites;
        std::size_t kdtree_get_point_count() const { return sites.size(); }
        double kdtree_get_pt(std::size_t i, std::size_t axis) const {
            return sites.points[i].position[static_cast<Eigen::Index>(axis)];
        }
        template <class Box> bool kdtree_get_bbox(Box& /*box*/) const { return false; }
    };
    using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3>;
    Cloud cloud;
    Tree tree;
    explicit NearestSite(const SiteSet& sites) : cloud{sites}, tree(3, cloud) {}
};

PointBasis::PointBasis() = default;
PointBasis::~PointBasis() = default;

void PointBasis::bind(const Mesh& mesh, const SiteSet& sites) {
    DIFUSA_REQUIRE(sites.size() > 0);
    mesh_ = &mesh;
    sites_ = &sites;
    normalise_ = partition_of_unity();
    std::vector<double> reach(sites.size());
    std::transform(sites.radius.begin(), sites.radius.end(), reach.begin(), [this](double r) { return support(r); });
    grid_ = SupportGrid(mesh, sites, reach);
    nearest_ = std::make_unique<NearestSite>(sites);
}

std::size_t PointBasis::size() const {
    return sites_->size();
}

Index PointBasis::nearest(const SurfacePoint& x) const {
    std::array<std::uint32_t, 16> found{};
    std::array<double, 16> squared{};
    const std::size_t count = nearest_->tree.knnSearch(x.position.data(), found.size(), found.data(), squared.data());
    const Index patch = mesh_->patch[x.face];
    Index by_distance = none, by_patch = none;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < count; ++k) {
        const Index i = found[k];
        const double d = site_distance(x.position, x.normal, patch, sites_->points[i].position,
                                       sites_->points[i].normal, sites_->patch[i]);
        if (d < least) {
            least = d;
            by_distance = i;
        }
        if (by_patch == none && sites_->patch[i] == patch) {
            by_patch = i;
        }
    }
    return by_distance != none ? by_distance : by_patch != none ? by_patch : found[0];
}

void PointBasis::evaluate(const SurfacePoint& x, BasisRow& row) const {
    row.clear();
    const std::span<const Index> candidates = grid_.near(x.position, mesh_->patch[x.face]);
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
        // Written always, kept if inside: no branch to mispredict.
        row.element[count] = site;
        distance[count] = squared;
        cosine[count] = cosine_here;
        count += static_cast<std::size_t>((squared < c.support_squared) & (cosine_here > 0.0));
    }
    row.element.resize(count);
    row.weight.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        distance[i] = std::sqrt(distance[i]);
        radius[i] = sites_->radius[row.element[i]];
    }
    weigh(x, {row.element, {distance, count}, {cosine, count}, {radius, count}}, row.weight);
    if (!normalise_) {
        return;
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        sum += row.weight[i];
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
