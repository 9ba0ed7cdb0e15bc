// Where the sky is seen from inside a scene, such as the windows of a room: found by rays, without being told of them.
// Rays aimed there take the place of those that happen to meet a small opening.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/random.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

namespace difusa {

/// Cells of the sides of the scene's bounding box through which light from the sky arrives.
class SkyOpenings {
  public:
    /// From rays of some of the points: each cell through which one escapes, and those around it. Null if none does, or
    /// if more than `most_open` of them do: then the scene is open to the sky. Cells are so large that each of
    /// those met has several rays. Throws Interrupted.
    static std::shared_ptr<const SkyOpenings> find(const Tracer& tracer, std::span<const SurfacePoint> points,
                                                   const Directions& directions, std::uint64_t seed,
                                                   const Execution& execution);
    static constexpr double most_open = 0.25; ///< of all rays, weighted with the cosine

    /// Whether a ray from x in this direction that escapes does so through one of the cells.
    bool contain(const Vec3& x, const Vec3& direction) const { return is_open_[exit_of(x, direction)] != 0; }

    /// What a point gathers of the sky through the openings. Scratch of one thread.
    class View {
      public:
        /// Casts about `count` rays from x (just beside it, as Hemisphere does), distributed over the cells by their
        /// form factors from it. False, without rays, if it is outside of the box, or if the openings are so near or so
        /// large that ordinary rays do as well.
        bool look(const Tracer& tracer, const SkyOpenings& openings, const SurfacePoint& x, std::size_t count,
                  RandomStream& stream);

        /// Calls `on_sky(direction, weight)` for each that escapes; the weights add up to the form factor of the sky
        /// through the openings (in the mean over streams).
        template <class OnSky> void for_each(const OnSky& on_sky) const {
            for (std::size_t k = 0; k < segments_.size(); ++k) {
                if (blocked_[k] == 0) {
                    on_sky(directions_[k], weights_[k]);
                }
            }
        }

        /// The weights of all rays, whether they escape or not.
        double weight() const { return std::accumulate(weights_.begin(), weights_.end(), 0.0); }

      private:
        std::vector<double> factors_;
        std::vector<Segment> segments_;
        std::vector<Vec3> directions_;
        std::vector<double> weights_;
        std::vector<std::uint8_t> blocked_;
    };

    std::size_t rays() const { return rays_; } ///< cast to find them

    /// The rays that are aimed from a point, beside so many others.
    static std::size_t aimed(std::size_t rays) { return std::max<std::size_t>(32, rays / 4); }

  private:
    /// A part of a side of the box, with the half edges of the two other axes.
    struct Cell {
        Vec3 centre, half_u, half_v;
        int axis;
        double area;
    };
    explicit SkyOpenings(const Eigen::AlignedBox3d& box);
    void divide(std::size_t resolution);
    std::size_t exit_of(const Vec3& x, const Vec3& direction) const;
    void add_cells(const std::vector<std::uint32_t>& count);

    Eigen::AlignedBox3d box_;
    std::size_t resolution_ = 1;        ///< cells along each edge
    std::vector<std::uint8_t> is_open_; ///< 6 resolution²
    std::vector<Cell> cells_;           ///< those that are
    std::size_t rays_ = 0;
};

} // namespace difusa
