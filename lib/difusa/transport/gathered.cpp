#include <difusa/transport/gathered.h>

#include <difusa/core/parallel.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered_rows.h>

#include <algorithm>

namespace difusa {

LightTransport gathered(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels,
                        const SkyBins& sky_bins, const Directions& directions, std::size_t rays, std::uint64_t seed,
                        const Execution& execution) {
    const DirectionPool pool(directions, rays, seed);
    // A range of a few thousand rays: short enough to stop soon when cancelled.
    const std::size_t grain = std::clamp<std::size_t>(4096 / pool.count(), 1, 16);
    GatheredRows rows(tracer, points, surfels, sky_bins, pool, grain);
    parallel_for(points.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        Hemisphere around(tracer, pool);
        GatheredRows::Scratch scratch;
        for (std::size_t j = begin; j < end; ++j) {
            around.look(points[j], j);
            rows.set(j, around, scratch);
        }
        rows.close_block(begin);
    });
    return rows.finish();
}

LightTransport gathered(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels,
                        const Directions& directions, std::size_t rays, std::uint64_t seed,
                        const Execution& execution) {
    return gathered(tracer, points, surfels, {SkyParts::count, SkyParts::at}, directions, rays, seed, execution);
}

} // namespace difusa
