#include <difusa/lighting/dark_regions.h>

#include <difusa/core/parallel.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/glance.h>

#include <algorithm>

namespace difusa {

namespace {

constexpr std::size_t least_places = 64; ///< per region

/// Whether light can reach x, as far as a handful of rays can tell.
bool sees_light(const Scene& scene, const DirectLight& lights, std::span<const Index> others, const Tracer& tracer,
                const SurfacePoint& x, RandomStream& stream, DirectLight::Worker& worker) {
    std::vector<Rgb> direct(lights.sets().count());
    lights.sample({&x, 1}, stream, direct, worker);
    if (std::any_of(direct.begin(), direct.end(), [](const Rgb& H) { return (H != 0.0).any(); })) {
        return true;
    }
    if (!others.empty()) {
        const double u = stream.uniform(), v = stream.uniform();
        const SurfacePoint y = uniform_point(scene.mesh, others[stream.below(others.size())], u, v);
        const Vec3 way = y.position - x.position;
        if (x.normal.dot(way) > 0.0 && y.normal.dot(way) < 0.0) {
            const Segment segment{x.position, y.position, x.face, y.face};
            std::uint8_t blocked = 0;
            tracer.occluded({&segment, 1}, {&blocked, 1});
            if (blocked == 0) {
                return true;
            }
        }
    }
    const Glance seen(tracer, x, stream);
    for (std::size_t d = 0; d < seen.rays.size(); ++d) {
        const Hit& hit = seen.hits[d];
        if (hit.face == none ? scene.has_sky() && (scene.sky_radiance(seen.rays[d].direction) > 0.0).any()
                             : hit.front) {
            return true;
        }
    }
    return false;
}

} // namespace

std::vector<char> dark_regions(const Scene& scene, const DirectLight& lights, const Tracer& tracer, std::uint64_t seed,
                               const Execution& execution) {
    const Mesh& mesh = scene.mesh;
    std::vector<std::vector<Index>> triangles(mesh.region_count);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        triangles[mesh.region[t]].push_back(t);
    }
    const std::vector<char> emits = emitting_materials(scene);
    std::vector<Index> others; // emitting triangles that are not area lights
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (emits[mesh.material[t]] != 0 && lights.area_light_materials()[mesh.material[t]] == 0) {
            others.push_back(t);
        }
    }
    std::vector<char> dark(mesh.region_count, 0);
    parallel_for(mesh.region_count, 1, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        DirectLight::Worker worker;
        for (std::size_t p = begin; p < end; ++p) {
            RandomStream stream(seed, "dark regions", p);
            const std::vector<Index>& own = triangles[p];
            const std::size_t places = std::max(least_places, own.size());
            bool lit = false;
            for (std::size_t i = 0; i < places && !lit; ++i) {
                if (i % 256 == 0) {
                    execution.check();
                }
                const Index t = own[i % own.size()];
                const double u = stream.uniform(), v = stream.uniform();
                lit = sees_light(scene, lights, others, tracer, uniform_point(mesh, t, u, v), stream, worker);
            }
            dark[p] = lit ? 0 : 1;
        }
    });
    return dark;
}

} // namespace difusa
