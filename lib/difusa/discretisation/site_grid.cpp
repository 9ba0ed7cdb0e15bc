#include <difusa/discretisation/site_grid.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <cmath>

namespace difusa {

namespace {

std::int32_t floor_to_cell(double x) {
    return static_cast<std::int32_t>(std::floor(x));
}

} // namespace

SiteGrid::SiteGrid(const Mesh& mesh, double spacing)
    : mesh_(mesh), spacing_(spacing), inverse_size_(1.0 / (cell_in_spacings * spacing)) {
    if (!(mesh.diameter() * inverse_size_ < 0x1p30)) {
        throw ResourceError("a spacing of " + text_of(spacing) + " is too small for a scene of diameter " +
                            text_of(mesh.diameter()) + "; give a larger --spacing");
    }
}

template <class Test> bool SiteGrid::any_near(const Vec3& p, Index region, const Test& test) const {
    const Vec3 scaled = (p - mesh_.low) * inverse_size_;
    // A little more than the spacing: a site must not be lost to rounding.
    const double reach = (1.0 + 1e-6) / cell_in_spacings;
    Cell low{}, high{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = floor_to_cell(scaled[static_cast<Eigen::Index>(axis)] - reach);
        high[axis] = floor_to_cell(scaled[static_cast<Eigen::Index>(axis)] + reach);
    }
    for (std::int32_t x = low[0]; x <= high[0]; ++x) {
        for (std::int32_t y = low[1]; y <= high[1]; ++y) {
            for (std::int32_t z = low[2]; z <= high[2]; ++z) {
                const Index cell = table_.find({x, y, z}, region);
                for (Index i = cell == none ? none : first_[cell]; i != none; i = next_[i]) {
                    if (test(sites_[i])) {
                        return true;
                    }
                }
            }
        }
    }
    return false;
}

bool SiteGrid::conflicts(const SurfacePoint& x) const {
    const Index region = mesh_.region[x.face];
    return any_near(x.position, region, [&](const SurfacePoint& site) {
        return site_distance(x.position, x.normal, region, site.position, site.normal, region) < spacing_;
    });
}

bool SiteGrid::covers(Index face, const std::array<Vec3, 3>& corners) const {
    // A site that covers the piece is within the spacing of its first corner.
    return any_near(corners[0], mesh_.region[face], [&](const SurfacePoint& site) {
        const double cosine = site.normal.dot(mesh_.normals[face]);
        if (cosine <= perpendicular) {
            return false;
        }
        const double reach = spacing_ * cosine;
        for (const Vec3& corner : corners) {
            if ((corner - site.position).squaredNorm() > reach * reach) {
                return false;
            }
        }
        return true;
    });
}

void SiteGrid::insert(const SurfacePoint& x) {
    const Vec3 scaled = (x.position - mesh_.low) * inverse_size_;
    const Index cell = table_.insert({floor_to_cell(scaled[0]), floor_to_cell(scaled[1]), floor_to_cell(scaled[2])},
                                     mesh_.region[x.face]);
    if (cell == first_.size()) {
        first_.push_back(none);
    }
    next_.push_back(first_[cell]);
    first_[cell] = static_cast<Index>(sites_.size());
    sites_.push_back(x);
}

} // namespace difusa
