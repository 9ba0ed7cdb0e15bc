// A handful of rays from a point, to tell whether light can get there at all.
#pragma once

#include <difusa/core/random.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/tracer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace difusa {

/// 32 cosine-weighted rays from x, stratified in the angle, and what they hit.
struct Glance {
    std::array<Ray, 32> rays;
    std::array<Hit, 32> hits;

    Glance(const Tracer& tracer, const SurfacePoint& x, RandomStream& stream) {
        Vec3 t, b;
        const Vec3& n = tracer.mesh().face_normal(x); // nothing is looked at from behind
        tangents(n, t, b);
        for (std::size_t d = 0; d < rays.size(); ++d) {
            const double r2 = stream.uniform(), r = std::sqrt(r2);
            const double angle =
                2.0 * std::numbers::pi * (static_cast<double>(d) + stream.uniform()) / static_cast<double>(rays.size());
            const Vec3 direction = r * std::cos(angle) * t + r * std::sin(angle) * b + std::sqrt(1.0 - r2) * n;
            rays[d] = {x.position, direction, x.face};
        }
        tracer.first_hits(rays, hits);
    }

    /// False if every ray ends on a back: x lies inside a body, or between two that touch.
    bool light_arrives() const {
        return std::any_of(hits.begin(), hits.end(), [](const Hit& hit) { return hit.face == none || hit.front; });
    }
};

} // namespace difusa
