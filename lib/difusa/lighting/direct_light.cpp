#include <difusa/lighting/direct_light.h>

#include <difusa/core/parallel.h>

#include <algorithm>

namespace difusa {

DirectLight::DirectLight(const Scene& scene, const Visibility& visibility)
    : visibility_(visibility), reach_(2.0 * scene.mesh.diameter()), lamps_(scene, lamp_triangles(scene), visibility),
      scene_(scene) {
    std::copy_if(scene.suns.begin(), scene.suns.end(), std::back_inserter(suns_),
                 [](const Sun& sun) { return (sun.irradiance > 0.0).any(); });
}

std::size_t DirectLight::lamp_count() const {
    std::size_t count = 0;
    for (const Lamps::Group& group : lamps_.groups()) {
        count += group.triangles.size();
    }
    return count;
}

Segment DirectLight::towards(const SurfacePoint& x, const Sun& sun) const {
    // A shading normal may face a sun that is below the plane of the face, or in it: then the face and those beside it
    // do not hide it.
    const Vec3& n = scene_.mesh.normals[x.face];
    const double height = n.dot(sun.towards);
    Vec3 way = sun.towards;
    if (x.normal != n && height < 0x1p-30) {
        way += (std::max(-height, 0x1p-30) - height) * n;
    }
    return {x.position, x.position + way * reach_, x.face, none};
}

Rgb DirectLight::from_suns(const SurfacePoint& x, Worker& worker) const {
    Rgb H = Rgb::Zero();
    for (const Sun& sun : suns_) {
        const double cosine = x.normal.dot(sun.towards);
        if (cosine > 0.0) {
            const Segment segment = towards(x, sun);
            std::uint8_t blocked = 0;
            visibility_.occluded(std::span(&segment, 1), std::span(&blocked, 1));
            ++worker.cast;
            H += blocked != 0 ? Rgb(Rgb::Zero()) : Rgb(cosine * sun.irradiance);
        }
    }
    return H;
}

Rgb DirectLight::irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const {
    Rgb H = from_suns(x, worker);
    for (const Lamps::Group& group : lamps_.groups()) {
        H += scene_.materials[group.material].emission *
             lamps_.visible_form_factor(x, group, samples, stream, worker.lamps);
    }
    return H;
}

Values DirectLight::irradiance(std::span<const SurfacePoint> x, int channels, std::size_t samples, std::uint64_t seed,
                               std::string_view purpose, const Execution& execution, std::size_t& cast) const {
    Values H = Values::Zero(static_cast<Eigen::Index>(x.size()), channels);
    if (!any()) {
        return H;
    }
    std::vector<std::size_t> counts(execution.threads, 0);
    parallel_for(x.size(), 64, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        Worker worker;
        for (std::size_t i = begin; i < end; ++i) {
            RandomStream stream(seed, purpose, i);
            H.row(static_cast<Eigen::Index>(i)) =
                irradiance(x[i], samples, stream, worker).head(channels).matrix().transpose();
        }
        counts[number] += worker.cast + worker.lamps.cast;
    });
    for (const std::size_t count : counts) {
        cast += count;
    }
    return H;
}

void DirectLight::sample(std::span<const SurfacePoint> x, RandomStream& stream, std::span<Rgb> H,
                         Worker& worker) const {
    std::fill(H.begin(), H.end(), Rgb(Rgb::Zero()));
    for (const Sun& sun : suns_) {
        worker.segments.clear();
        worker.owner.clear();
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (x[i].normal.dot(sun.towards) > 0.0) {
                worker.segments.push_back(towards(x[i], sun));
                worker.owner.push_back(static_cast<Index>(i));
            }
        }
        worker.blocked.resize(worker.segments.size());
        visibility_.occluded(worker.segments, worker.blocked);
        worker.cast += worker.segments.size();
        for (std::size_t k = 0; k < worker.owner.size(); ++k) {
            if (worker.blocked[k] == 0) {
                const Index i = worker.owner[k];
                H[i] += x[i].normal.dot(sun.towards) * sun.irradiance;
            }
        }
    }
    if (has_lamps()) {
        for (std::size_t i = 0; i < x.size(); ++i) {
            H[i] += lamps_.sample(x[i], stream, worker.lamps);
        }
    }
}

} // namespace difusa
