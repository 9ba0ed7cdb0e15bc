// The rays that glossy reflection needs to know one by one: those that meet glossy surfaces, and all that leave them.
#pragma once

#include <difusa/discretisation/glossy_surfels.h>
#include <difusa/rays/tracer.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <vector>

namespace difusa {

/// Geometry only. Threads may set different points.
class GlossyRays {
  public:
    struct Ray {
        Index bin;                    ///< a surfel, a part of the sky, or none: a back
        std::array<float, 3> towards; ///< unit, away from the point
        double weight;                ///< all rays of a point together have 1
        Vec3 direction() const { return {towards[0], towards[1], towards[2]}; }
    };

    /// `points`: those of the transport.
    GlossyRays(const Mesh& mesh, const Surfels& surfels, std::span<const SurfacePoint> points);

    const GlossySurfels& surfels() const { return *surfels_; }

    /// True if point j is in a region that has faces of this lobe, so that elements may reach from it to these.
    bool reflects(Index lobe, std::size_t j) const { return surfels_->has(lobe, region_[j]); }

    /// True if it does with any of them: all of its rays are kept.
    bool keeps_all(std::size_t j) const { return keeps_all_[j] != 0; }

    /// The unit normal at point j.
    const Vec3& normal(std::size_t j) const { return normal_[j]; }

    /// `bin_of(hit, direction)`: the bin of a ray.
    template <class BinOf> void set(std::size_t j, const Sight& around, const BinOf& bin_of) {
        std::vector<Ray>& rays = rays_[j];
        rays.clear();
        around.for_each_ray([&](const Hit& hit, const Vec3& direction, double weight) {
            const Index bin = bin_of(hit, direction);
            if (keeps_all(j) || (bin != none && !surfels_->of(bin).empty())) {
                rays.push_back({bin,
                                {static_cast<float>(direction[0]), static_cast<float>(direction[1]),
                                 static_cast<float>(direction[2])},
                                weight});
            }
        });
        std::stable_sort(rays.begin(), rays.end(), [](const Ray& a, const Ray& b) { return a.bin < b.bin; });
        rays.shrink_to_fit();
    }

    std::size_t points() const { return rays_.size(); }

    /// Those of point j, in ascending order of their bins.
    const std::vector<Ray>& rays(std::size_t j) const { return rays_[j]; }

    /// Size in bytes.
    std::size_t bytes() const;

  private:
    std::shared_ptr<const GlossySurfels> surfels_;
    std::vector<Index> region_;
    std::vector<Vec3> normal_;
    std::vector<char> keeps_all_;
    std::vector<std::vector<Ray>> rays_;
};

} // namespace difusa
