#include <difusa/lighting/direct_light.h>

#include <difusa/core/even_sequence.h>
#include <difusa/core/parallel.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace difusa {

namespace {

std::vector<Index> lamps_of(const Scene& scene, const LightGroup& group, const std::vector<char>& materials) {
    std::vector<Index> lamps;
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        const Index m = scene.mesh.material[t];
        if (materials[m] != 0 && group.materials[m] != 0) {
            lamps.push_back(t);
        }
    }
    return lamps;
}

std::shared_ptr<const Shafts> shafts_for(const Scene& scene, const std::vector<char>& lamps) {
    return std::find(lamps.begin(), lamps.end(), 1) == lamps.end() || scene.mesh.convex
               ? nullptr
               : std::make_shared<Shafts>(scene.mesh);
}

} // namespace

DirectLight::DirectLight(const Scene& scene, const Visibility& visibility)
    : scene_(scene), visibility_(visibility), reach_(2.0 * scene.mesh.diameter()),
      rounding_(0x1p-44 * scene.mesh.magnitude()), lamp_materials_(difusa::lamp_materials(scene)),
      shafts_(shafts_for(scene, lamp_materials_)),
      lamps_(scene, lamps_of(scene, all_lights(scene), lamp_materials_), visibility, shafts_) {
    add_lights(all_lights(scene));
}

DirectLight::DirectLight(const DirectLight& all, const LightGroup& group)
    : scene_(all.scene_), visibility_(all.visibility_), reach_(all.reach_), rounding_(all.rounding_),
      lamp_materials_(all.lamp_materials_), shafts_(all.shafts_),
      lamps_(scene_, lamps_of(scene_, group, lamp_materials_), visibility_, shafts_) {
    add_lights(group);
}

void DirectLight::add_lights(const LightGroup& group) {
    for (std::size_t i = 0; i < scene_.suns.size(); ++i) {
        if (group.suns[i] != 0 && (scene_.suns[i].irradiance > 0.0).any()) {
            suns_.push_back(scene_.suns[i]);
        }
    }
    for (std::size_t i = 0; i < scene_.point_lights.size(); ++i) {
        if (group.points[i] != 0 && (scene_.point_lights[i].intensity > 0.0).any()) {
            points_.push_back(scene_.point_lights[i]);
        }
    }
}

Segment DirectLight::shadow_ray(const SurfacePoint& from, const Vec3& direction, double length) const {
    // A shading normal may face a light that is below the plane of the face, or in it: then the face and those beside
    // it do not hide it.
    const Vec3& n = scene_.mesh.normals[from.face];
    const double height = n.dot(direction);
    Vec3 way = direction;
    if (from.normal != n && height < 0x1p-30) {
        way += (std::max(-height, 0x1p-30) - height) * n;
    }
    return {from.position, from.position + way * length, from.face, none};
}

void DirectLight::add_outside(const SurfacePoint& x, Index owner, Worker& worker) const {
    const auto add = [&](const Segment& segment, const Rgb& light) {
        worker.segments.push_back(segment);
        worker.light.push_back(light);
        worker.owner.push_back(owner);
    };
    const SurfacePoint from = inset(scene_.mesh, x);
    for (const Sun& sun : suns_) {
        const double cosine = x.normal.dot(sun.towards);
        if (cosine > 0.0) {
            add(shadow_ray(from, sun.towards, reach_), cosine * sun.irradiance);
        }
    }
    for (const PointLight& light : points_) {
        const Vec3 way = light.position - x.position;
        const double distance = way.norm();
        const Vec3 towards = way / distance;
        const double cosine = x.normal.dot(towards);
        const double falloff = cosine > 0.0 ? light.falloff(-towards) : 0.0;
        if (falloff > 0.0) {
            // A light may lie on a face, which by rounding may be before it.
            const Vec3 ray = light.position - from.position;
            const double length = ray.norm(), short_of_it = std::max(0.0, length * (1.0 - 0x1p-40) - rounding_);
            add(shadow_ray(from, ray / length, short_of_it),
                cosine * falloff / (distance * distance) * light.intensity);
        }
    }
}

Rgb DirectLight::from_outside(const SurfacePoint& x, Worker& worker) const {
    Rgb H = Rgb::Zero();
    if (suns_.empty() && points_.empty()) {
        return H;
    }
    worker.segments.clear();
    worker.light.clear();
    worker.owner.clear();
    add_outside(x, 0, worker);
    worker.blocked.resize(worker.segments.size());
    visibility_.occluded(worker.segments, worker.blocked);
    worker.cast += worker.segments.size();
    for (std::size_t k = 0; k < worker.light.size(); ++k) {
        H += worker.blocked[k] == 0 ? worker.light[k] : Rgb(Rgb::Zero());
    }
    return H;
}

Rgb DirectLight::irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const {
    return from_outside(x, worker) + lamps_.irradiance(x, samples, stream, worker.lamps);
}

Values DirectLight::irradiance(std::span<const SurfacePoint> x, int channels, std::size_t samples, std::uint64_t seed,
                               std::string_view purpose, const Execution& execution, Effort& effort) const {
    Values H = Values::Zero(static_cast<Eigen::Index>(x.size()), channels);
    if (!any()) {
        return H;
    }
    std::vector<Effort> efforts(execution.threads);
    parallel_for(x.size(), 64, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        Worker worker;
        for (std::size_t i = begin; i < end; ++i) {
            RandomStream stream(seed, purpose, i);
            H.row(static_cast<Eigen::Index>(i)) =
                irradiance(x[i], samples, stream, worker).head(channels).matrix().transpose();
        }
        efforts[number].add(worker);
    });
    for (const Effort& each : efforts) {
        effort.segments += each.segments;
        effort.clear += each.clear;
    }
    return H;
}

void DirectLight::sample(std::span<const SurfacePoint> x, RandomStream& stream, std::span<Rgb> H,
                         Worker& worker) const {
    std::fill(H.begin(), H.end(), Rgb(Rgb::Zero()));
    worker.segments.clear();
    worker.light.clear();
    worker.owner.clear();
    for (std::size_t i = 0; i < x.size(); ++i) {
        add_outside(x[i], static_cast<Index>(i), worker);
    }
    worker.blocked.resize(worker.segments.size());
    visibility_.occluded(worker.segments, worker.blocked);
    worker.cast += worker.segments.size();
    for (std::size_t k = 0; k < worker.owner.size(); ++k) {
        if (worker.blocked[k] == 0) {
            H[worker.owner[k]] += worker.light[k];
        }
    }
    if (lamps_.count() == 0) {
        return;
    }
    const std::array<double, 4> shift{stream.uniform(), stream.uniform(), stream.uniform(), stream.uniform()};
    for (std::size_t i = 0; i < x.size(); ++i) {
        H[i] += lamps_.sample(x[i], even_point(i, shift), worker.lamps);
    }
}

} // namespace difusa
