#include <difusa/lighting/mirror_images.h>

#include <difusa/core/even_sequence.h>
#include <difusa/lighting/area_lights.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/lambert.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

namespace difusa {

namespace {

/// Up to this many faces of a plane, parts of an image are clipped to each of them.
constexpr std::size_t few_faces = 64;

/// At most this many pairs of an image and a mirror are looked at to find longer chains: a second or so.
constexpr std::size_t most_pairs = std::size_t{1} << 25U;

/// The part of a convex polygon where normal·p >= offset.
void clip_to_front(const std::vector<Vec3>& polygon, const Vec3& normal, double offset, std::vector<Vec3>& result) {
    result.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double at_a = normal.dot(a) - offset, at_b = normal.dot(b) - offset;
        if (at_a >= 0.0) {
            result.push_back(a);
        }
        if ((at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0)) {
            result.push_back(a + at_a / (at_a - at_b) * (b - a));
        }
    }
}

/// A plane by the rounded direction of its normal and its rounded offset: coordinates in files have six digits, and the
/// triangles of a flat mirror must not become mirrors of their own.
std::tuple<std::int64_t, std::int64_t, std::int64_t, std::int64_t> key_of(const Vec3& normal, double offset,
                                                                          double magnitude) {
    const auto whole = [](double value) { return static_cast<std::int64_t>(std::llround(value * 0x1p17)); };
    return {whole(normal.x()), whole(normal.y()), whole(normal.z()), whole(offset / std::max(magnitude, 1e-300))};
}

} // namespace

MirrorImages::MirrorImages(const Scene& scene, const Tracer& tracer, std::span<const std::pair<Sun, Index>> suns,
                           std::span<const std::pair<PointLight, Index>> points, std::span<const Index> lamps,
                           std::span<const Index> set_of_material)
    : scene_(scene), tracer_(tracer), suns_(suns.begin(), suns.end()), point_lights_(points.begin(), points.end()),
      lamp_triangles_(lamps.begin(), lamps.end()), set_of_material_(set_of_material.begin(), set_of_material.end()),
      reach_(2.0 * scene.mesh.diameter()), rounding_(0x1p-44 * scene.mesh.magnitude()) {
    if (scene.mesh.mirrors.any() && !(suns_.empty() && point_lights_.empty() && lamp_triangles_.empty())) {
        find_planes();
        follow_sources();
    }
}

void MirrorImages::find_planes() {
    const Mesh& mesh = scene_.mesh;
    plane_of_face_.assign(mesh.triangles.size(), none);
    std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t, std::int64_t>, Index> known;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.mirrors.kind(t) == none) {
            continue;
        }
        const Vec3& n = mesh.normals[t];
        const double offset = n.dot(mesh.corner(t, 0));
        const auto [place, is_new] =
            known.try_emplace(key_of(n, offset, mesh.magnitude()), static_cast<Index>(planes_.size()));
        if (is_new) {
            Plane plane;
            plane.normal = n;
            plane.offset = offset;
            planes_.push_back(std::move(plane));
        }
        plane_of_face_[t] = place->second;
        planes_[place->second].faces.push_back(t);
    }
    for (Plane& plane : planes_) {
        Eigen::AlignedBox3d box;
        double area = 0.0;
        for (const Index t : plane.faces) {
            box.extend(mesh.box(t));
            area += mesh.areas[t];
            plane.colour += mesh.areas[t] * mesh.mirrors.reflectance[mesh.mirrors.kind(t)];
        }
        // A plane of one kind has its colour to the bit.
        const Rgb first = mesh.mirrors.reflectance[mesh.mirrors.kind(plane.faces.front())];
        const bool even = std::all_of(plane.faces.begin(), plane.faces.end(), [&](Index t) {
            return (mesh.mirrors.reflectance[mesh.mirrors.kind(t)] == first).all();
        });
        plane.colour = even ? first : Rgb(plane.colour / area);
        plane.centre = box.center();
        plane.radius = 0.5 * box.diagonal().norm();
    }
}

/// Whether some part of one is in front of the other: not so between the faces of a convex body.
bool MirrorImages::see_each_other(const Plane& a, const Plane& b) const {
    const Mesh& mesh = scene_.mesh;
    const auto reaches = [&](const Plane& plane, const Plane& other) {
        return plane.height(other.centre) + other.radius > rounding_ &&
               std::any_of(other.faces.begin(), other.faces.end(), [&](Index t) {
                   return std::max({plane.height(mesh.corner(t, 0)), plane.height(mesh.corner(t, 1)),
                                    plane.height(mesh.corner(t, 2))}) > 16.0 * rounding_;
               });
    };
    return reaches(a, b) && reaches(b, a);
}

MirrorImages::Chain MirrorImages::before(Index plane, const Chain& chain) const {
    const Eigen::Matrix3d reflection = planes_[plane].reflection();
    Chain result;
    result.planes.push_back(plane);
    result.planes.insert(result.planes.end(), chain.planes.begin(), chain.planes.end());
    result.colour = planes_[plane].colour * chain.colour;
    result.linear = reflection * chain.linear;
    result.offset = reflection * chain.offset + planes_[plane].shift();
    return result;
}

std::optional<MirrorImages::PointImage> MirrorImages::in_mirror(const PointImage& source, Index plane) const {
    const Plane& mirror = planes_[plane];
    PointImage image = source;
    const double height = image.is_sun ? mirror.normal.dot(image.at) : mirror.height(image.at);
    const double extent = image.is_sun ? suns_[image.source].first.disc : radius(image);
    if (!(height + extent > (image.is_sun ? 0x1p-40 : rounding_))) {
        return std::nullopt;
    }
    image.chain = before(plane, source.chain);
    image.at -= 2.0 * height * mirror.normal;
    return image;
}

std::optional<MirrorImages::LampImage> MirrorImages::in_mirror(const LampImage& source, Index plane) const {
    const Plane& mirror = planes_[plane];
    std::vector<Vec3> front;
    clip_to_front(source.polygon, mirror.normal, mirror.offset + rounding_, front);
    if (front.size() < 3) {
        return std::nullopt;
    }
    LampImage image;
    image.triangle = source.triangle;
    image.chain = before(plane, source.chain);
    Eigen::AlignedBox3d box;
    for (Vec3& corner : front) {
        corner -= 2.0 * mirror.height(corner) * mirror.normal;
        box.extend(corner);
    }
    std::reverse(front.begin(), front.end()); // a reflection turns it over
    image.polygon = std::move(front);
    image.centre = box.center();
    image.radius = 0.5 * box.diagonal().norm();
    return image;
}

/// One generation of chains after another, each as a whole.
template <class Image> void MirrorImages::add_images(std::vector<Image>& images) {
    std::vector<Image> generation = std::move(images), next;
    images.clear();
    const auto give_up = [&](std::size_t length) {
        complete_ = false;
        followed_ = followed_ == 0 ? length - 1 : std::min(followed_, length - 1);
    };
    for (std::size_t length = 1; length <= scene_.mesh.mirrors.most; ++length) {
        next.clear();
        if (length > 1 && generation.size() * planes_.size() > most_pairs) {
            give_up(length);
            return;
        }
        for (const Image& image : generation) {
            for (Index plane = 0; plane < planes_.size(); ++plane) {
                if (!image.chain.planes.empty() &&
                    (plane == image.chain.planes.front() ||
                     !see_each_other(planes_[plane], planes_[image.chain.planes.front()]))) {
                    continue;
                }
                if (std::optional<Image> longer = in_mirror(image, plane)) {
                    next.push_back(std::move(*longer));
                }
            }
            if (length > 1 && images.size() + next.size() > most_images) {
                give_up(length);
                return;
            }
        }
        if (next.empty()) {
            break;
        }
        images.insert(images.end(), next.begin(), next.end());
        std::swap(generation, next);
    }
}

void MirrorImages::follow_sources() {
    extended_ = std::any_of(suns_.begin(), suns_.end(), [](const auto& sun) { return sun.first.is_extended(); }) ||
                std::any_of(point_lights_.begin(), point_lights_.end(),
                            [](const auto& light) { return light.first.is_extended(); });
    for (Index i = 0; i < suns_.size(); ++i) {
        points_.push_back({{}, suns_[i].first.towards, i, true});
    }
    for (Index i = 0; i < point_lights_.size(); ++i) {
        points_.push_back({{}, point_lights_[i].first.position, i, false});
    }
    for (const Index t : lamp_triangles_) {
        LampImage lamp;
        for (int k = 0; k < 3; ++k) {
            lamp.polygon.push_back(scene_.mesh.corner(t, k));
        }
        lamp.triangle = t;
        lamps_.push_back(std::move(lamp));
    }
    add_images(points_);
    add_images(lamps_);
    for (LampImage& image : lamps_) {
        add_windows(image);
    }
}

void MirrorImages::add_windows(LampImage& image) const {
    Chain seen; // over the mirrors before each
    for (const Index plane : image.chain.planes) {
        std::vector<std::array<Vec3, 3>> window;
        if (planes_[plane].faces.size() <= few_faces) {
            for (const Index t : planes_[plane].faces) {
                const Mesh& mesh = scene_.mesh;
                window.push_back({seen(mesh.corner(t, 0)), seen(mesh.corner(t, 1)), seen(mesh.corner(t, 2))});
            }
        }
        image.has_all_windows = image.has_all_windows && !window.empty();
        image.windows.push_back(std::move(window));
        // The next mirror is seen in this one as this one is seen: the reflection in it comes first.
        seen.offset += seen.linear * planes_[plane].shift();
        seen.linear = seen.linear * planes_[plane].reflection();
    }
}

/// False only if no straight line from a place within `spread` of x to one within `radius` of the target passes through
/// the plane's ball: moving x is moving both balls.
bool MirrorImages::may_show(const Plane& plane, const Vec3& x, double spread, const Vec3& target, double radius) const {
    if (!(plane.height(x) + spread > 0.0)) {
        return false;
    }
    const Vec3 to_mirror = plane.centre - x, to_target = target - x;
    const double a = to_mirror.norm(), b = to_target.norm();
    const double sine_a = (plane.radius + spread) / a, sine_b = (radius + spread) / b;
    if (!(sine_a < 1.0 && sine_b < 1.0)) {
        return true;
    }
    // The angle between the centres against the sum of the angles of the balls, which is less than pi.
    const double cosine_a = std::sqrt(1.0 - sine_a * sine_a), cosine_b = std::sqrt(1.0 - sine_b * sine_b);
    return to_mirror.dot(to_target) >= (cosine_a * cosine_b - sine_a * sine_b - 1e-9) * a * b;
}

/// The same for a sun or point light.
bool MirrorImages::may_show(const PointImage& image, const Vec3& x, double spread) const {
    const Plane& plane = planes_[image.chain.planes.front()];
    if (!image.is_sun) {
        return may_show(plane, x, spread, image.at, radius(image));
    }
    const Vec3 to_mirror = plane.centre - x;
    const double sine = suns_[image.source].first.disc;
    const double along = to_mirror.dot(image.at),
                 reach = plane.radius + spread + sine / std::sqrt(1.0 - sine * sine) * to_mirror.norm();
    return plane.height(x) + spread > 0.0 && along > -reach && to_mirror.squaredNorm() - along * along <= reach * reach;
}

/// The same for one place: whether the line meets the plane within the ball.
bool MirrorImages::shows_place(const Plane& plane, const Vec3& x, const Vec3& way, bool endless) const {
    const double height = plane.height(x), sinks = -plane.normal.dot(way);
    if (!(height > 0.0 && sinks > 0.0) || (!endless && height > sinks)) {
        return false;
    }
    const double slack = plane.radius * (1.0 + 1e-6) + rounding_;
    return (x + height / sinks * way - plane.centre).squaredNorm() <= slack * slack;
}

Rgb MirrorImages::follow(const SurfacePoint& from, const Chain& chain, const Vec3& target, const Vec3* source,
                         Index source_face, Vec3& last, Worker& worker) const {
    const Mesh& mesh = scene_.mesh;
    Rgb colour = Rgb::Ones();
    SurfacePoint at = from;
    Vec3 way = source == nullptr ? target : Vec3(target - from.position);
    for (const Index plane : chain.planes) {
        const Ray ray{at.position, way, at.face};
        Hit hit;
        tracer_.first_hits({&ray, 1}, {&hit, 1});
        ++worker.cast;
        if (hit.face == none || !hit.front || plane_of_face_[hit.face] != plane) {
            return Rgb::Zero();
        }
        colour *= mesh.mirrors.reflectance[mesh.mirrors.kind(hit.face)];
        at = inset(mesh, mesh.at(hit.face, hit.u, hit.v));
        way = mirrored(source == nullptr ? way : Vec3((1.0 - hit.t) * way), planes_[plane].normal);
    }
    Segment segment{at.position, at.position + reach_ * way, at.face, none};
    if (source != nullptr) {
        const Vec3 rest = *source - at.position;
        const double length = rest.norm();
        // A light may lie on a face that, by rounding, ends up in front of it.
        const double part = source_face == none ? std::max(0.0, 1.0 - 0x1p-40 - rounding_ / length) : 1.0;
        segment = {at.position, at.position + part * rest, at.face, source_face};
        way = rest;
    }
    last = way;
    std::uint8_t blocked = 0;
    worker.cast += tracer_.occluded({&segment, 1}, {&blocked, 1});
    return blocked != 0 ? Rgb(Rgb::Zero()) : colour;
}

bool MirrorImages::is_extended(const PointImage& image) const {
    return image.is_sun ? suns_[image.source].first.is_extended() : point_lights_[image.source].first.is_extended();
}

double MirrorImages::radius(const PointImage& image) const {
    return image.is_sun ? 0.0 : point_lights_[image.source].first.radius();
}

Rgb MirrorImages::light_of(const PointImage& image, const SurfacePoint& x, const SurfacePoint& from,
                           const std::array<double, 2>& place, Worker& worker) const {
    const bool extended = is_extended(image);
    Vec3 target = image.at, source = Vec3::Zero();
    double at_sun = 1.0; // cosine between the direction and the sun's axis
    if (image.is_sun && extended) {
        const Sun& sun = suns_[image.source].first;
        const Vec3 towards = sun.towards_disc(place);
        target = image.chain.linear * towards;
        at_sun = sun.towards.dot(towards);
    } else if (!image.is_sun) {
        const PointLight& light = point_lights_[image.source].first;
        source = extended ? light.place(place) : light.position;
        target = extended ? image.chain(source) : image.at;
    }
    const Vec3 way = image.is_sun ? target : Vec3(target - x.position);
    const double distance = way.norm(), cosine = x.normal.dot(way) / distance;
    if (!(cosine > 0.0) || !shows_place(planes_[image.chain.planes.front()], x.position, way, image.is_sun)) {
        return Rgb::Zero();
    }
    Vec3 last;
    if (image.is_sun) {
        return cosine / at_sun * suns_[image.source].first.irradiance *
               follow(from, image.chain, way, nullptr, none, last, worker);
    }
    const PointLight& light = point_lights_[image.source].first;
    const Rgb colour = follow(from, image.chain, target, &source, none, last, worker);
    return (colour > 0.0).any()
               ? Rgb(cosine * light.falloff(-last.normalized()) / (distance * distance) * colour * light.intensity)
               : Rgb(Rgb::Zero());
}

void MirrorImages::add_points(const SurfacePoint& x, std::size_t batches, std::size_t samples, RandomStream& stream,
                              Worker& worker, std::span<Rgb> H, Rgb* from_outside) const {
    const SurfacePoint from = inset(scene_.mesh, x);
    std::array<std::array<double, 2>, ShadowBatches::batches> start{};
    for (std::size_t batch = 0; extended_ && batch < batches; ++batch) {
        start[batch] = {stream.uniform(), stream.uniform()};
    }
    std::array<Rgb, ShadowBatches::batches> of_batch; // of all images: all see the same places of a source
    of_batch.fill(Rgb::Zero());
    for (const PointImage& image : points_) {
        Rgb light = Rgb::Zero();
        if (!is_extended(image)) {
            light = light_of(image, x, from, start[0], worker);
        } else if (may_show(image, x.position, 0.0)) {
            for (std::size_t batch = 0; batch < batches; ++batch) {
                Rgb now = Rgb::Zero();
                for (std::size_t k = 0; k < samples; ++k) {
                    now += light_of(image, x, from, even_point<2>(k, start[batch]), worker);
                }
                now /= static_cast<double>(samples);
                of_batch[batch] += now;
                light += now / static_cast<double>(batches);
            }
        }
        H[image.is_sun ? suns_[image.source].second : point_lights_[image.source].second] += light;
        if (from_outside != nullptr) {
            *from_outside += light;
        }
    }
    RgbBatchNoise noise;
    for (std::size_t batch = 0; batch < batches; ++batch) {
        noise.add(of_batch[batch]);
    }
    worker.variance += noise.variance_of_mean();
}

/// Adds a convex polygon, counterclockwise seen from its front and relative to nothing, as triangles.
void MirrorImages::add_part(const std::vector<Vec3>& polygon, Index lamp, const SurfacePoint& x, Worker& worker) const {
    for (std::size_t k = 2; k < polygon.size(); ++k) {
        Part part{{polygon[0], polygon[k - 1], polygon[k]}, lamp};
        part.form_factor = lambert_form_factor(x.position, x.normal, part.corner[0], part.corner[1], part.corner[2]);
        part.light = part.form_factor * light(lamps_[lamp]).mean();
        if (part.form_factor > 0x1p-48 && part.light > 0.0) {
            worker.parts.push_back(part);
        }
    }
}

/// Clips what is left of an image to the faces of one mirror after another, as x sees them.
void MirrorImages::look_through(const LampImage& image, std::size_t window, Index lamp, const SurfacePoint& x,
                                const std::vector<Vec3>& polygon, Worker& worker) const {
    if (window == image.windows.size()) {
        add_part(polygon, lamp, x, worker);
        return;
    }
    if (image.windows[window].empty()) {
        look_through(image, window + 1, lamp, x, polygon, worker);
        return;
    }
    std::vector<Vec3> left, next;
    for (const std::array<Vec3, 3>& face : image.windows[window]) {
        const std::array<Vec3, 3> w{face[0] - x.position, face[1] - x.position, face[2] - x.position};
        const double side = w[0].cross(w[1]).dot(w[2]) > 0.0 ? 1.0 : -1.0;
        left = polygon;
        for (std::size_t k = 0; k < 3 && left.size() >= 3; ++k) {
            const Vec3 normal = side * w[k].cross(w[(k + 1) % 3]);
            clip_to_front(left, normal, normal.dot(x.position), next);
            std::swap(left, next);
        }
        if (left.size() >= 3) {
            look_through(image, window + 1, lamp, x, left, worker);
        }
    }
}

/// The images that places within `spread` of x may see.
void MirrorImages::find_candidates(const Vec3& x, double spread, Worker& worker) const {
    worker.candidates.clear();
    for (Index lamp = 0; lamp < lamps_.size(); ++lamp) {
        const LampImage& image = lamps_[lamp];
        if (may_show(planes_[image.chain.planes.front()], x, spread, image.centre, image.radius)) {
            worker.candidates.push_back(lamp);
        }
    }
}

void MirrorImages::collect(const SurfacePoint& x, Worker& worker) const {
    worker.parts.clear();
    for (const Index lamp : worker.candidates) {
        const LampImage& image = lamps_[lamp];
        if (may_show(planes_[image.chain.planes.front()], x.position, 0.0, image.centre, image.radius)) {
            look_through(image, 0, lamp, x, image.polygon, worker);
        }
    }
}

/// A point of a part, uniform by area.
MirrorImages::Sampled MirrorImages::sample_part(const Part& part, const SurfacePoint& x, const SurfacePoint& from,
                                                double u, double v, Worker& worker) const {
    const LampImage& image = lamps_[part.lamp];
    const double root = std::sqrt(u);
    const Vec3 edge_b = part.corner[1] - part.corner[0], edge_c = part.corner[2] - part.corner[0];
    const Vec3 y = part.corner[0] + root * (1.0 - v) * edge_b + root * v * edge_c;
    const Vec3 normal = edge_b.cross(edge_c); // twice the area long
    const Vec3 way = y - x.position;
    const double r2 = way.squaredNorm(), cosines = x.normal.dot(way) * -normal.dot(way) * 0.5;
    if (!(x.normal.dot(way) > 0.0) || !(cosines > 0.0)) {
        return {};
    }
    Sampled sampled;
    const double kernel = cosines / (std::numbers::pi * r2 * r2);
    sampled.unblocked = kernel * light(image);
    // Back over the mirrors: the inverse of a reflection followed by others is its transpose.
    const Vec3 source = image.chain.linear.transpose() * (y - image.chain.offset);
    Vec3 last;
    sampled.seen = kernel * emission(image) * follow(from, image.chain, y, &source, image.triangle, last, worker);
    return sampled;
}

void MirrorImages::cast_batch(const SurfacePoint& x, const SurfacePoint& from, std::size_t paths,
                              const std::array<double, 3>& start, Worker& worker) const {
    for_even_samples(worker.parts, paths, start[0], [&](const Part& part, std::size_t s) {
        const auto [u, v] = even_point<2>(s, {start[1], start[2]});
        const Sampled sampled = sample_part(part, x, from, u, v, worker);
        const double factor = part.factor / part.light;
        worker.shares[part.share].batch.add({factor * sampled.seen, factor * sampled.unblocked});
    });
}

void MirrorImages::irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                              std::span<Rgb> H) const {
    worker.variance = Rgb::Zero();
    add_points(x, ShadowBatches::batches, samples_of_batch(samples), stream, worker, H, nullptr);
    find_candidates(x.position, 0.0, worker);
    collect(x, worker);
    if (worker.parts.empty()) {
        return;
    }
    const SurfacePoint from = inset(scene_.mesh, x);
    LightShares& shares = worker.shares;
    shares.clear();
    for (Part& part : worker.parts) {
        const LampImage& lamp = lamps_[part.lamp];
        part.share = shares.of(scene_.mesh.material[lamp.triangle]);
        shares[part.share].unblocked += part.form_factor * light(lamp);
    }
    const auto cast = [&](std::size_t paths) {
        shares.cast_batches([&] {
            const std::array<double, 3> start{stream.uniform(), stream.uniform(), stream.uniform()};
            cast_batch(x, from, paths, start, worker);
        });
    };
    // Where no window is known, few paths may get through.
    const bool sure = std::all_of(worker.parts.begin(), worker.parts.end(),
                                  [&](const Part& part) { return lamps_[part.lamp].has_all_windows; });
    const ShadowBatches plan = shadow_batches(samples);
    shares.divide(worker.parts, ShadowBatches::batches * plan.rays_of_pilot());
    cast(plan.rays_of_pilot());
    cast(shares.sees_some() || sure ? plan.rays_after(shares.noise_of_visible_part()) : plan.most_rays());
    worker.variance += shares.variance();
    shares.for_each_visible(
        [&](Index material, const Rgb& irradiance) { H[set_of_material_[material]] += irradiance; });
}

void MirrorImages::sample(std::span<const SurfacePoint> x, RandomStream& stream, Worker& worker, std::span<Rgb> H,
                          std::span<Rgb> from_outside) const {
    if (x.empty()) {
        return;
    }
    Eigen::AlignedBox3d box;
    for (const SurfacePoint& each : x) {
        box.extend(each.position);
    }
    const double spread = 0.5 * box.diagonal().norm();
    find_candidates(box.center(), spread, worker);
    worker.near = !worker.candidates.empty() ||
                  std::any_of(points_.begin(), points_.end(),
                              [&](const PointImage& image) { return may_show(image, box.center(), spread); });
    const std::size_t sets = H.size() / x.size();
    for (std::size_t i = 0; i < x.size(); ++i) {
        const std::span<Rgb> own = H.subspan(i * sets, sets);
        add_points(x[i], 1, 1, stream, worker, own, from_outside.empty() ? nullptr : &from_outside[i]);
        if (!lamps_.empty()) {
            sample_lamps(x[i], stream, worker, own);
        }
    }
}

void MirrorImages::sample_lamps(const SurfacePoint& x, RandomStream& stream, Worker& worker, std::span<Rgb> H) const {
    const double choice = stream.uniform(), u = stream.uniform(), v = stream.uniform();
    collect(x, worker);
    if (worker.parts.empty()) {
        return;
    }
    double whole = 0.0;
    for (Part& part : worker.parts) {
        whole += part.light;
        part.below = whole;
    }
    const auto part = std::find_if(worker.parts.begin(), worker.parts.end() - 1,
                                   [&](const Part& each) { return choice * whole < each.below; });
    const Sampled sampled = sample_part(*part, x, inset(scene_.mesh, x), u, v, worker);
    H[set_of(lamps_[part->lamp])] += whole / part->light * sampled.seen;
}

} // namespace difusa
