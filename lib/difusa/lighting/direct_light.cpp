#include <difusa/lighting/direct_light.h>

#include <difusa/core/even_sequence.h>
#include <difusa/core/parallel.h>
#include <difusa/lighting/lamp_images.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/scene/light_symmetry.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace difusa {

namespace {

constexpr std::size_t rays_in_a_row = std::size_t{1} << 16U; ///< before a look whether the computation is cancelled

std::vector<Index> triangles_of(const Scene& scene, const std::vector<char>& materials) {
    std::vector<Index> triangles;
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        if (materials[scene.mesh.material[t]] != 0) {
            triangles.push_back(t);
        }
    }
    return triangles;
}

/// Calls `act(i, factor)` for DirectLight::most_sampled lights, drawn by their weight; `factor` is what makes the sum
/// unbiased. `below`: weights up to and including each light.
template <class Act> void draw(const std::vector<double>& below, RandomStream& stream, const Act& act) {
    constexpr std::size_t most = DirectLight::most_sampled;
    const double along = stream.uniform(), share = below.back() / static_cast<double>(most);
    for (std::size_t k = 0; k < most; ++k) {
        const double target =
            std::min((static_cast<double>(k) + along) * share, std::nextafter(below.back(), 0.0)); // rounding
        const auto i =
            static_cast<std::size_t>(std::upper_bound(below.begin(), below.end() - 1, target) - below.begin());
        act(i, share / (below[i] - (i == 0 ? 0.0 : below[i - 1])));
    }
}

/// Writes weights up to and including each light: three quarters of the sum by what the light would give at x if it
/// shone evenly and nothing were in its way, so that near ones count most, and a quarter by its strength, so that no
/// weight is 0 whose light is not.
void weigh(const std::vector<std::pair<PointLight, Index>>& lights, const SurfacePoint& x, std::vector<double>& below) {
    below.resize(lights.size());
    double strength = 0.0, kernel = 0.0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const PointLight& light = lights[i].first;
        const Vec3 way = light.position - x.position;
        const double squared = way.squaredNorm(), own = light.intensity.sum();
        below[i] = squared > 0.0 ? own * std::max(0.0, x.normal.dot(way)) / (squared * std::sqrt(squared)) : 0.0;
        strength += own;
        kernel += below[i];
    }
    const double near = kernel > 0.0 ? 0.75 / kernel : 0.0, even = 0.25 / strength;
    double sum = 0.0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        sum += near * below[i] + even * lights[i].first.intensity.sum();
        below[i] = sum;
    }
}

} // namespace

DirectLight::DirectLight(const Scene& scene, const Tracer& tracer, LightSets sets)
    : scene_(scene), tracer_(tracer), sets_(std::move(sets)), reach_(reach_out_of(scene.mesh)),
      rounding_(0x1p-44 * scene.mesh.magnitude()), area_light_materials_(difusa::area_light_materials(scene)),
      area_lights_(scene, triangles_of(scene, area_light_materials_), tracer) {
    check_light_symmetry(scene);
    for (std::size_t i = 0; i < scene_.suns.size(); ++i) {
        if ((scene_.suns[i].irradiance > 0.0).any()) {
            suns_.emplace_back(scene_.suns[i], sets_.sun[i]);
            extended_ += scene_.suns[i].is_extended() ? 1 : 0;
            suns_below_.push_back(scene_.suns[i].irradiance.sum() + (suns_below_.empty() ? 0.0 : suns_below_.back()));
        }
    }
    const auto shines = [](const PointLight& light) { return (light.intensity > 0.0).any(); };
    const LampImages beyond = LampImages::of(
        scene.mesh,
        static_cast<std::size_t>(std::count_if(scene_.point_lights.begin(), scene_.point_lights.end(), shines)));
    depth_ = beyond.depth;
    for (std::size_t i = 0; i < scene_.point_lights.size(); ++i) {
        if (!shines(scene_.point_lights[i])) {
            continue;
        }
        for (const PointLight& light : with_images(scene_.point_lights[i], beyond, scene.mesh)) {
            points_.emplace_back(light, sets_.point[i]);
            narrow_beams_.add(light);
            extended_ += light.is_extended() ? 1 : 0;
        }
    }
    if (scene_.mesh.mirrors.any()) {
        images_.emplace(scene_, tracer_, suns_, points_, triangles_of(scene_, area_light_materials_), sets_.material);
        if (!images_->any()) {
            images_.reset();
        }
    }
}

std::size_t DirectLight::depth_of_images() const {
    if (scene_.mesh.repetition.endless.empty() || (points_.empty() && area_lights_.count() == 0)) {
        return 0;
    }
    return points_.empty()             ? area_lights_.depth()
           : area_lights_.count() == 0 ? depth_
                                       : std::min(depth_, area_lights_.depth());
}

Segment DirectLight::shadow_ray(const SurfacePoint& from, const Vec3& direction, double length) const {
    // A shading normal may face a light that is in or below the plane of the face: then the face and its neighbours
    // must not hide it.
    const Vec3& n = scene_.mesh.face_normal(from);
    const double height = n.dot(direction);
    Vec3 way = direction;
    if (from.normal != n && height < 0x1p-30) {
        way += (std::max(-height, 0x1p-30) - height) * n;
    }
    return {from.position, from.position + way * length, from.face, none};
}

void DirectLight::add_sun(const SurfacePoint& x, const SurfacePoint& from, std::size_t number, double factor,
                          const Place& place, std::size_t first, Worker& worker) const {
    const auto& [sun, set] = suns_[number];
    const Vec3 towards = sun.is_extended() ? sun.towards_disc(place) : sun.towards;
    const double cosine = x.normal.dot(towards) / (sun.is_extended() ? sun.towards.dot(towards) : 1.0);
    if (cosine > 0.0) {
        worker.segments.push_back(shadow_ray(from, towards, reach_));
        worker.light.emplace_back(factor * cosine * sun.irradiance);
        worker.owner.push_back(first + set);
    }
}

void DirectLight::add_point(const SurfacePoint& x, const SurfacePoint& from, std::size_t number, double factor,
                            const Place& place, std::size_t first, Worker& worker) const {
    const auto& [light, set] = points_[number];
    const Vec3 source = light.is_extended() ? light.place(place) : light.position;
    const Vec3 way = source - x.position;
    const double distance = way.norm();
    const Vec3 towards = way / distance;
    const double cosine = x.normal.dot(towards);
    const double falloff = cosine > 0.0 ? light.falloff(-towards) : 0.0;
    if (falloff > 0.0) {
        // A light may lie on a face that, by rounding, ends up in front of it.
        const Vec3 ray = source - from.position;
        const double length = ray.norm(), short_of_it = std::max(0.0, length * (1.0 - 0x1p-40) - rounding_);
        worker.segments.push_back(shadow_ray(from, ray / length, short_of_it));
        worker.light.emplace_back(factor * cosine * falloff / (distance * distance) * light.intensity);
        worker.owner.push_back(first + set);
    }
}

void DirectLight::add_outside(const SurfacePoint& x, std::size_t first, Worker& worker) const {
    const SurfacePoint from = inset(scene_.mesh, x);
    for (std::size_t i = 0; i < suns_.size(); ++i) {
        if (!suns_[i].first.is_extended()) {
            add_sun(x, from, i, 1.0, {}, first, worker);
        }
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
        if (!points_[i].first.is_extended()) {
            add_point(x, from, i, 1.0, {}, first, worker);
        }
    }
}

void DirectLight::add_drawn(const SurfacePoint& x, std::size_t first, const Place& place, RandomStream& stream,
                            Worker& worker) const {
    const SurfacePoint from = inset(scene_.mesh, x);
    const auto sun = [&](std::size_t i, double factor) { add_sun(x, from, i, factor, place, first, worker); };
    const auto point = [&](std::size_t i, double factor) { add_point(x, from, i, factor, place, first, worker); };
    if (suns_.size() > most_sampled) {
        draw(suns_below_, stream, sun);
    } else {
        for (std::size_t i = 0; i < suns_.size(); ++i) {
            sun(i, 1.0);
        }
    }
    if (points_.size() > most_sampled) {
        weigh(points_, x, worker.below);
        draw(worker.below, stream, point);
    } else {
        for (std::size_t i = 0; i < points_.size(); ++i) {
            point(i, 1.0);
        }
    }
}

/// Casts the collected shadow rays; the results are in `blocked`.
void DirectLight::cast(Worker& worker) const {
    worker.blocked.resize(worker.segments.size());
    worker.cast += tracer_.occluded(worker.segments, worker.blocked);
}

namespace {

void clear(DirectLight::Worker& worker) {
    worker.segments.clear();
    worker.light.clear();
    worker.owner.clear();
}

} // namespace

/// The share of the light of one extended source that gets through. `add(place)` collects the shadow ray towards that
/// place, if there is light from it.
template <class Add>
DirectLight::Visible DirectLight::visible_share(std::size_t samples, RandomStream& stream, Worker& worker,
                                                const Add& add) const {
    LightSeen light;
    BatchNoise noise, noise_of_light;
    std::size_t lit = 0; // places on the source that shine on x
    const auto cast_batches = [&](std::size_t rays) {
        light = {};
        noise = noise_of_light = {};
        lit = 0;
        for (std::size_t batch = 0; batch < ShadowBatches::batches; ++batch) {
            const Place shift{stream.uniform(), stream.uniform()};
            clear(worker);
            for (std::size_t k = 0; k < rays; ++k) {
                add(even_point<2>(k, shift));
            }
            cast(worker);
            LightSeen now;
            for (std::size_t k = 0; k < worker.light.size(); ++k) {
                now.all += worker.light[k].sum();
                now.seen += worker.blocked[k] == 0 ? worker.light[k].sum() : 0.0;
            }
            noise.add(now);
            noise_of_light.add(now.seen / static_cast<double>(rays));
            light.add(now);
            lit += worker.light.size();
        }
    };
    const ShadowBatches plan = shadow_batches(samples);
    cast_batches(plan.rays_of_pilot());
    const double pilot = light.share();
    const bool narrow = 2 * lit < ShadowBatches::batches * plan.rays_of_pilot(); // a beam: few places shine on x
    const std::size_t rays = narrow ? plan.most_rays() : plan.rays_after(noise);
    cast_batches(rays);
    return {light.all > 0.0 ? light.share() : pilot, noise.variance_of_mean(),
            light.seen / static_cast<double>(ShadowBatches::batches * rays), noise_of_light.variance_of_mean()};
}

void DirectLight::add_extended(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                               std::span<Rgb> H) const {
    const SurfacePoint from = inset(scene_.mesh, x);
    const auto add_light = [&](Index set, const Visible& visible, const Rgb& light) {
        H[set] += visible.share * light;
        worker.variance += visible.variance * light.square();
    };
    for (std::size_t i = 0; i < suns_.size(); ++i) {
        const auto& [sun, set] = suns_[i];
        const double cosine = x.normal.dot(sun.towards);
        if (!sun.is_extended() || !(cosine > -sun.disc)) {
            continue;
        }
        const Visible visible = visible_share(samples, stream, worker,
                                              [&](const Place& place) { add_sun(x, from, i, 1.0, place, 0, worker); });
        if (cosine >= sun.disc) { // wholly above the horizon, the disc gives what its centre would
            add_light(set, visible, cosine * sun.irradiance);
        } else {
            const Rgb colour = sun.irradiance / sun.irradiance.sum();
            H[set] += visible.light * colour;
            worker.variance += visible.variance_of_light * colour.square();
        }
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const auto& [light, set] = points_[i];
        const double unblocked = light.is_extended() ? light.mean_kernel(x.position, x.normal) : 0.0;
        if (unblocked > 0.0) {
            const Visible visible = visible_share(
                samples, stream, worker, [&](const Place& place) { add_point(x, from, i, 1.0, place, 0, worker); });
            add_light(set, visible, unblocked * light.intensity);
        }
    }
}

void DirectLight::irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                             std::span<Rgb> H) const {
    std::fill(H.begin(), H.end(), Rgb(Rgb::Zero()));
    worker.variance = Rgb::Zero();
    clear(worker);
    add_outside(x, 0, worker);
    cast(worker);
    for (std::size_t k = 0; k < worker.light.size(); ++k) {
        H[worker.owner[k]] += worker.blocked[k] == 0 ? worker.light[k] : Rgb(Rgb::Zero());
    }
    area_lights_.irradiance(x, samples, stream, worker.area_lights, sets_.material, H);
    worker.variance += worker.area_lights.variance;
    if (images_) {
        images_->irradiance(x, samples, stream, worker.images, H);
        worker.variance += worker.images.variance;
    }
    if (extended_ > 0) {
        add_extended(x, samples, stream, worker, H);
    }
}

Rgb DirectLight::irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const {
    std::vector<Rgb> H(sets_.count());
    irradiance(x, samples, stream, worker, H);
    return std::accumulate(H.begin(), H.end(), Rgb(Rgb::Zero()));
}

Values DirectLight::irradiance(std::span<const SurfacePoint> x, int channels, std::size_t samples, std::uint64_t seed,
                               std::string_view purpose, const Execution& execution, Effort& effort,
                               Values* variance) const {
    const std::size_t sets = sets_.count();
    const auto count = static_cast<Eigen::Index>(x.size());
    Values H = Values::Zero(count, static_cast<Eigen::Index>(sets) * channels);
    if (variance != nullptr) {
        variance->setZero(count, channels);
    }
    if (!any()) {
        return H;
    }
    std::vector<Effort> efforts(execution.threads);
    const std::size_t grain = std::clamp<std::size_t>(rays_in_a_row / rays_per_point(samples), 1, 64);
    parallel_for(x.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        Worker worker;
        std::vector<Rgb> by_set(sets);
        for (std::size_t i = begin; i < end; ++i) {
            RandomStream stream(seed, purpose, i);
            irradiance(x[i], samples, stream, worker, by_set);
            const auto row = static_cast<Eigen::Index>(i);
            if (variance != nullptr) {
                variance->row(row) = worker.variance.head(channels).matrix().transpose();
            }
            for (std::size_t set = 0; set < sets; ++set) {
                H.row(row).segment(static_cast<Eigen::Index>(set) * channels, channels) =
                    by_set[set].head(channels).matrix().transpose();
            }
        }
        efforts[number].add(worker);
    });
    for (const Effort& each : efforts) {
        effort.segments += each.segments;
        effort.clear += each.clear;
    }
    return H;
}

void DirectLight::cast_drawn(std::span<const SurfacePoint> x, RandomStream& stream, Worker& worker) const {
    clear(worker);
    const Place start = extended_ > 0 ? Place{stream.uniform(), stream.uniform()} : Place{};
    for (std::size_t i = 0; i < x.size(); ++i) {
        add_drawn(x[i], i * sets_.count(), even_point<2>(i, start), stream, worker);
    }
    cast(worker);
}

template <class Sample, class Act>
void DirectLight::for_each_lamp_sample(std::size_t count, RandomStream& stream, const Sample& sample,
                                       const Act& act) const {
    if (area_lights_.count() == 0) {
        return;
    }
    const std::array<double, 5> shift{stream.uniform(), stream.uniform(), stream.uniform(), stream.uniform(),
                                      stream.uniform()};
    for (std::size_t i = 0; i < count; ++i) {
        const AreaLights::Sample one = sample(i, even_point(i, shift));
        if (one.material != none) {
            act(i, sets_.material[one.material], one);
        }
    }
}

void DirectLight::sample(std::span<const SurfacePoint> x, RandomStream& stream, std::span<Rgb> H, Worker& worker,
                         std::span<Rgb> from_outside) const {
    std::fill(H.begin(), H.end(), Rgb(Rgb::Zero()));
    std::fill(from_outside.begin(), from_outside.end(), Rgb(Rgb::Zero()));
    cast_drawn(x, stream, worker);
    for (std::size_t k = 0; k < worker.owner.size(); ++k) {
        if (worker.blocked[k] == 0) {
            H[worker.owner[k]] += worker.light[k];
            if (!from_outside.empty()) {
                from_outside[worker.owner[k] / sets_.count()] += worker.light[k];
            }
        }
    }
    if (images_) {
        images_->sample(x, stream, worker.images, H, from_outside);
    }
    for_each_lamp_sample(
        x.size(), stream,
        [&](std::size_t i, const std::array<double, 5>& u) { return area_lights_.sample(x[i], u, worker.area_lights); },
        [&](std::size_t i, Index set, const AreaLights::Sample& one) { H[i * sets_.count() + set] += one.H; });
}

void DirectLight::sample_directions(std::span<const SurfacePoint> x, RandomStream& stream,
                                    std::vector<Arrival>& arrivals, Worker& worker) const {
    arrivals.clear();
    cast_drawn(x, stream, worker);
    for (std::size_t k = 0; k < worker.owner.size(); ++k) {
        if (worker.blocked[k] == 0) {
            const Segment& segment = worker.segments[k];
            arrivals.push_back({worker.owner[k] / sets_.count(), static_cast<Index>(worker.owner[k] % sets_.count()),
                                (segment.to - segment.from).normalized(), worker.light[k], true});
        }
    }
    for_each_lamp_sample(
        x.size(), stream,
        [&](std::size_t i, const std::array<double, 5>& u) {
            return area_lights_.sample_direction(x[i], u, worker.area_lights);
        },
        [&](std::size_t i, Index set, const AreaLights::Sample& one) {
            arrivals.push_back({i, set, one.towards, one.H, false});
        });
}

} // namespace difusa
