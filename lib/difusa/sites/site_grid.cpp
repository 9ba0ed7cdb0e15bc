#include <difusa/sites/site_grid.h>

#include <difusa/core/random.h>

#include <cmath>

namespace difusa {

SiteGrid::SiteGrid(const Mesh& mesh, double spacing) : mesh_(mesh), spacing_(spacing) {}

std::size_t SiteGrid::Hash::operator()(const Cell& cell) const {
    return mix_bits(static_cast<std::uint64_t>(cell.x) ^
                    mix_bits(static_cast<std::uint64_t>(cell.y) ^ mix_bits(static_cast<std::uint64_t>(cell.z))));
}

SiteGrid::Cell SiteGrid::cell_of(const Vec3& p) const {
    const Vec3 scaled = (p - mesh_.low) / spacing_;
    return {static_cast<std::int64_t>(std::floor(scaled[0])), static_cast<std::int64_t>(std::floor(scaled[1])),
            static_cast<std::int64_t>(std::floor(scaled[2]))};
}

template <class Test> bool SiteGrid::any_near(const Vec3& p, const Test& test) const {
    const Cell centre = cell_of(p);
    for (std::int64_t x = centre.x - 1; x <= centre.x + 1; ++x) {
        for (std::int64_t y = centre.y - 1; y <= centre.y + 1; ++y) {
            for (std::int64_t z = centre.z - 1; z <= centre.z + 1; ++z) {
                const auto found = first_.find({x, y, z});
                for (Index i = found == first_.end() ? none : found->second; i != none; i = next_[i]) {
                    if (test(i)) {
                        return true;
                    }
                }
            }
        }
    }
    return false;
}

bool SiteGrid::conflicts(const SurfacePoint& x) const {
    return any_near(x.position, [&](Index i) {
        return site_distance(x.position, x.normal, mesh_.patch[x.face], sites_[i].position, sites_[i].normal,
                             mesh_.patch[sites_[i].face]) < spacing_;
    });
}

bool SiteGrid::covers(Index face, const std::array<Vec3, 3>& corners) const {
    // A site that covers the piece is within the spacing of its first corner.
    return any_near(corners[0], [&](Index i) {
        if (mesh_.patch[sites_[i].face] != mesh_.patch[face]) {
            return false;
        }
        const double reach = spacing_ * sites_[i].normal.dot(mesh_.normals[face]);
        if (reach <= 0.0) {
            return false;
        }
        for (const Vec3& corner : corners) {
            if ((corner - sites_[i].position).squaredNorm() > reach * reach) {
                return false;
            }
        }
        return true;
    });
}

void SiteGrid::insert(const SurfacePoint& x) {
    const auto number = static_cast<Index>(sites_.size());
    const auto [entry, is_new] = first_.try_emplace(cell_of(x.position), number);
    sites_.push_back(x);
    next_.push_back(is_new ? none : entry->second);
    entry->second = number;
}

} // namespace difusa
