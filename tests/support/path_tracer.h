// Light by plain path tracing: slow, unbiased, and independent of everything but rays, so that a bake can be judged by
// it.
#pragma once

#include <difusa/core/random.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa::test {

/// Irradiance at x in W/m², the mean of `paths` paths, and its variance (of the mean). Every emitting face is sampled
/// by area at each vertex of a path, so emission that a path runs into is not counted. No sky, no suns.
struct Traced {
    Rgb mean = Rgb::Zero(), variance = Rgb::Zero();
};

inline Traced trace_paths(const Scene& scene, const Visibility& visibility, const SurfacePoint& x, std::size_t paths,
                          RandomStream stream) {
    const Mesh& mesh = scene.mesh;
    std::vector<Index> lamps;
    std::vector<double> below;
    double area = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if ((scene.materials[mesh.material[t]].emission > 0.0).any()) {
            lamps.push_back(t);
            below.push_back(area += mesh.areas[t]);
        }
    }
    struct Path {
        std::size_t number;
        SurfacePoint at;
        Rgb weight;
    };
    std::vector<Path> open;
    for (std::size_t i = 0; i < paths; ++i) {
        open.push_back({i, x, Rgb::Ones()});
    }
    std::vector<Rgb> sum(paths, Rgb::Zero());
    std::vector<Segment> segments;
    std::vector<Rgb> light;
    std::vector<std::uint8_t> blocked;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    while (!open.empty()) {
        segments.clear();
        light.clear();
        rays.clear();
        for (const Path& path : open) {
            const auto place = std::upper_bound(below.begin(), below.end(), stream.uniform() * area);
            const Index lamp =
                lamps[std::min<std::size_t>(static_cast<std::size_t>(place - below.begin()), lamps.size() - 1)];
            const double u = stream.uniform(), v = stream.uniform();
            const SurfacePoint y = uniform_point(mesh, lamp, u, v);
            const Vec3 way = y.position - path.at.position;
            const double r2 = way.squaredNorm();
            const double cosines = std::max(0.0, path.at.normal.dot(way)) * std::max(0.0, -y.normal.dot(way));
            light.push_back(cosines > 0.0
                                ? Rgb(path.weight * scene.emission(y) * (area * cosines / (std::numbers::pi * r2 * r2)))
                                : Rgb(Rgb::Zero()));
            segments.push_back({path.at.position, y.position, path.at.face, y.face});
            Vec3 t, b;
            tangents(path.at.normal, t, b);
            const double r = std::sqrt(stream.uniform()), angle = 2.0 * std::numbers::pi * stream.uniform();
            rays.push_back({path.at.position,
                            r * std::cos(angle) * t + r * std::sin(angle) * b + std::sqrt(1.0 - r * r) * path.at.normal,
                            path.at.face});
        }
        blocked.resize(segments.size());
        hits.resize(rays.size());
        visibility.occluded(segments, blocked);
        visibility.first_hits(rays, hits);
        std::vector<Path> next;
        for (std::size_t i = 0; i < open.size(); ++i) {
            sum[open[i].number] += blocked[i] != 0 ? Rgb(Rgb::Zero()) : light[i];
            if (hits[i].face == none || !hits[i].front) {
                continue;
            }
            const SurfacePoint y = mesh.at(hits[i].face, hits[i].u, hits[i].v);
            const Rgb weight = open[i].weight * scene.reflectance(y);
            const double survival = std::min(1.0, weight.maxCoeff()); // Russian roulette
            if (stream.uniform() < survival) {
                next.push_back({open[i].number, y, weight / survival});
            }
        }
        open = std::move(next);
    }
    Traced traced;
    const auto n = static_cast<double>(paths);
    for (const Rgb& s : sum) {
        traced.mean += s / n;
    }
    for (const Rgb& s : sum) {
        traced.variance += (s - traced.mean).square() / (n * (n - 1.0));
    }
    return traced;
}

} // namespace difusa::test
