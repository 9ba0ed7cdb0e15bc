#include <difusa/lighting/area_lights.h>

#include <difusa/core/even_sequence.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/lambert.h>
#include <difusa/rays/own_plane.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

constexpr double largest_share = 0.1;
constexpr double contrast = 4.0;

/// Up to this many area lights are all evaluated, which takes no more time than choosing among them; of more, about as
/// many as `representatives_per_sample` says.
constexpr std::size_t few_triangles = 4096;
constexpr double representatives_per_sample = 8.0;

/// Groups that are seen under at most this angle may be represented by some of their lights.
constexpr double opening = 0.15;

/// Points on an area light from which one is chosen for a single ray.
constexpr std::size_t candidates = 8;

/// Up to this many area lights are looked at for what is in the way; for more, this costs more than rays.
constexpr std::size_t few_shafts = 32;

/// Beyond, rays take less time.
constexpr PolygonInSight::Limits most_looked_at{128, 64};

/// Of the light of an area light: what is less is rounding.
constexpr double unseen_part = 0x1p-40;

/// Triangles of a mesh of which those are found that may come between two points of it.
constexpr std::size_t most_told_apart = 16384;

} // namespace

std::vector<char> area_light_materials(const Scene& scene) {
    std::vector<char> emits = emitting_materials(scene);
    if (scene.thermal && scene.mesh.mirrors.any()) { // images of lamps are sampled by set, which may have both signs
        std::fill(emits.begin(), emits.end(), char{0});
    }
    // Whether a material is an area light must not depend on a temperature that is solved for.
    const auto is_found = [&](std::size_t m) {
        return scene.materials[m].thermal && scene.materials[m].thermal->given == Thermal::Given::heat;
    };
    std::vector<double> area(scene.materials.size(), 0.0);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        area[scene.mesh.material[t]] += scene.mesh.areas[t];
    }
    std::vector<std::size_t> even;
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        if (emits[m] != 0 && area[m] > 0.0 && !scene.materials[m].emits_unevenly() && !is_found(m)) {
            even.push_back(m);
        }
    }
    std::stable_sort(even.begin(), even.end(), [&](std::size_t a, std::size_t b) { return area[a] < area[b]; });
    std::vector<char> lamps(scene.materials.size(), 0);
    double small = 0.0;
    for (const std::size_t m : even) {
        small += area[m];
        lamps[m] = small <= largest_share * scene.mesh.area ? 1 : 0;
    }
    const auto brightness = [&](std::size_t m) {
        const Material& material = scene.materials[m];
        const Rgb factor = material.emission_texture ? material.emission_texture->mean() : Rgb(Rgb::Ones());
        return is_found(m) ? 0.0 : std::abs((factor * material.emission).mean());
    };
    double rest = 0.0, light = 0.0;
    for (std::size_t m = 0; m < lamps.size(); ++m) {
        rest += lamps[m] != 0 ? 0.0 : area[m];
        light += lamps[m] != 0 ? 0.0 : area[m] * brightness(m);
    }
    for (std::size_t m = 0; m < lamps.size(); ++m) {
        lamps[m] = lamps[m] != 0 && brightness(m) * rest > contrast * light ? 1 : 0;
    }
    return lamps;
}

LightBlockers::LightBlockers(const Mesh& mesh) : all_(mesh) {
    if (mesh.triangles.size() <= most_told_apart) {
        between_.emplace(mesh, occluders(exposures(mesh, Execution{1})));
    }
}

bool LightBlockers::may_hide(Index light, const SurfacePoint& x, Index& last) const {
    Index unrelated = none; // `last` is one of those between points of the surface
    return shafts(x).may_be_blocked(x, light, between_ && x.face == none ? unrelated : last);
}

PolygonInSight::Extent LightBlockers::look(Index light, const SurfacePoint& x, PolygonInSight& sight) const {
    const Mesh& mesh = all_.mesh();
    const Vec3& n = mesh.normals[light];
    return sight.look(shafts(x), x, mesh.corners(light), {n, n.dot(mesh.corner(light, 0))}, most_looked_at);
}

AreaLights::AreaLights(const Scene& scene, std::vector<Index> triangles, const Tracer& tracer)
    : scene_(scene), tracer_(tracer), count_(triangles.size()), triangles_(std::move(triangles)) {
    if (triangles_.empty()) {
        return;
    }
    if (!scene.mesh.convex) {
        blockers_.emplace(scene.mesh);
    }
    if (const LampImages images = LampImages::of(scene.mesh, count_); !images.images.empty()) {
        depth_ = images.depth;
        images_ = with_images(triangles_, images, scene.mesh);
        originals_ = std::move(triangles_);
        triangles_.resize(images_->triangles.size());
        std::iota(triangles_.begin(), triangles_.end(), Index{0});
    }
    rounding_ = plane_rounding(scene.mesh);
    std::vector<double> power;
    power.reserve(triangles_.size());
    for (const Index t : triangles_) {
        power.push_back(lamps().areas[t] * strength(t));
    }
    tree_.emplace(lamps(), triangles_, power);
    if (triangles_.size() <= few_triangles) {
        batch_ = LambertBatch(lamps(), triangles_);
    }
}

/// Whether the closed form F is more than the rounding of the angles it is summed from. It is not for a light in the
/// plane that x is on: rounding decides whether x is before it, and if so, one back to back with the face of x would
/// seem to cover the whole sky.
bool AreaLights::lights(const SurfacePoint& x, Index t, double F) const {
    if (!(F > 0x1p-48) || (!is_image(t) && original(t) == x.face)) {
        return false;
    }
    const Vec3& n = scene_.mesh.face_normal(x);
    const std::array<Vec3, 3> corners = lamps().corners(t);
    return !std::all_of(corners.begin(), corners.end(),
                        [&](const Vec3& corner) { return std::abs(n.dot(corner - x.position)) <= rounding_; });
}

/// Calls `add(triangle, form factor)` for all area lights that send light to x if nothing blocks.
template <class Add> void AreaLights::for_each_facing(const SurfacePoint& x, Worker& worker, const Add& add) const {
    worker.factors.resize(triangles_.size());
    batch_.form_factors(x.position, x.normal, worker.factors);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        if (lights(x, triangles_[i], worker.factors[i])) {
            add(triangles_[i], worker.factors[i]);
        }
    }
}

/// The closed form, or 0.
double AreaLights::form_factor(const SurfacePoint& x, Index t) const {
    const double F = lambert_form_factor(x.position, x.normal, lamps().corners(t));
    return lights(x, t, F) ? F : 0.0;
}

/// The area lights that send light to x if nothing blocks, each with its weight.
void AreaLights::collect(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const {
    worker.parts.clear();
    worker.shares.clear();
    const auto add = [&](Index triangle, double F, double weight) {
        const std::size_t share = worker.shares.of(lamps().material[triangle]);
        worker.parts.push_back({triangle, F, weight, weight * F * strength(triangle), share});
    };
    if (triangles_.size() <= few_triangles) {
        for_each_facing(x, worker, [&](Index triangle, double F) { add(triangle, F, 1.0); });
        return;
    }
    const double representatives = representatives_per_sample * static_cast<double>(samples);
    tree_->represent(x.position, x.normal, opening, representatives, stream, worker.nodes, worker.node_parts,
                     worker.chosen);
    for (const LightTree::Representative& one : worker.chosen) {
        const Index triangle = triangles_[one.light];
        if (const double F = form_factor(x, triangle); F > 0.0) {
            add(triangle, F, one.weight);
        }
    }
}

bool AreaLights::may_be_blocked(const SurfacePoint& x, Index light, Index& last_blocker) const {
    if (!blockers_) {
        return false;
    }
    return is_elsewhere(x, light) || blockers_->may_hide(original(light), x, last_blocker);
}

/// Whether the point sees a light as its face does: with a shading normal it may also see what is below the horizon of
/// its face. False if the way may lead through images.
bool AreaLights::may_be_looked_at(const SurfacePoint& from, Index light) const {
    if (is_elsewhere(from, light)) {
        return false;
    }
    const Vec3& own = scene_.mesh.face_normal(from);
    if (from.normal == own) {
        return true;
    }
    const std::array<Vec3, 3> corners = scene_.mesh.corners(original(light));
    return std::all_of(corners.begin(), corners.end(),
                       [&](const Vec3& corner) { return own.dot(corner - from.position) >= 0.0; });
}

/// Of an area light, the part of its light that gets through; nothing if too much is in the way.
std::optional<double> AreaLights::visible_part(const SurfacePoint& from, Index light, Worker& worker) const {
    const auto factor_of = [&](std::span<const Vec3> polygon) {
        return lambert_form_factor(from.position, from.normal, polygon);
    };
    switch (blockers_->look(original(light), from, worker.sight)) {
    case PolygonInSight::Extent::whole:
        return 1.0;
    case PolygonInSight::Extent::pieces:
        if (const double whole = factor_of(scene_.mesh.corners(original(light))); whole > 0.0) {
            const double part = worker.sight.sum(factor_of) / whole;
            return part > unseen_part ? std::min(1.0, part) : 0.0;
        }
        break; // grazing
    case PolygonInSight::Extent::unknown:
        break;
    }
    return {};
}

/// Moves what is known of the collected lights to `Share::known`, and leaves those in `parts` that need shadow rays.
void AreaLights::look(const SurfacePoint& from, Worker& worker) const {
    const bool few = worker.parts.size() <= few_shafts;
    bool simple = few && blockers_.has_value(); // what is in the way of one light is in the way of others, too
    std::size_t left = 0;
    for (Worker::Part& part : worker.parts) {
        const Rgb light = part.weight * part.form_factor * emission(part.triangle);
        std::optional<double> seen;
        if (simple && may_be_looked_at(from, part.triangle)) {
            seen = visible_part(from, part.triangle, worker);
            simple = seen.has_value();
        } else if (!blockers_ || (few && !may_be_blocked(from, part.triangle, worker.last_blocker))) {
            seen = 1.0;
        }
        LightShares::Share& share = worker.shares[part.share];
        if (seen) {
            share.known += *seen * light;
        } else {
            share.unblocked += light;
            worker.parts[left++] = part;
        }
    }
    worker.parts.resize(left);
}

/// Samples go to evenly distributed points on the lights.
void AreaLights::cast_batch(const SurfacePoint& x, std::size_t samples, const std::array<double, 3>& start,
                            Worker& worker) const {
    worker.segments.clear();
    worker.light.clear();
    worker.owner.clear();
    for_even_samples(worker.parts, samples, start[0], [&](const Worker::Part& part, std::size_t s) {
        const auto [u, v] = even_point<2>(s, {start[1], start[2]});
        const SurfacePoint y = uniform_point(lamps(), part.triangle, u, v);
        const Vec3 way = y.position - x.position;
        const double cosine = x.normal.dot(way), cosines = cosine * -y.normal.dot(way);
        const double r2 = way.squaredNorm();
        if (cosine > 0.0 && cosines > 0.0) {
            // Points on lights are chosen by area; the kernel varies over the light.
            const double kernel = cosines / (r2 * r2) * lamps().areas[y.face] / part.form_factor;
            worker.segments.push_back({x.position, y.position, x.face, original(y.face)});
            worker.light.emplace_back(part.factor * kernel / strength(y.face) * emission(y.face));
            worker.owner.push_back(part.share);
        }
    });
    worker.blocked.resize(worker.segments.size());
    worker.cast += tracer_.occluded(worker.segments, worker.blocked);
    for (std::size_t s = 0; s < worker.segments.size(); ++s) {
        const Rgb seen = worker.blocked[s] == 0 ? worker.light[s] : Rgb(Rgb::Zero());
        worker.shares[worker.owner[s]].batch.add({seen, worker.light[s]});
    }
}

void AreaLights::cast_rays(const SurfacePoint& from, std::size_t samples, RandomStream& stream, Worker& worker) const {
    LightShares& shares = worker.shares;
    const auto cast = [&](std::size_t rays) {
        shares.cast_batches([&] {
            const std::array start{stream.uniform(), stream.uniform(), stream.uniform()};
            cast_batch(from, rays, start, worker);
        });
    };
    const ShadowBatches plan = shadow_batches(samples);
    shares.divide(worker.parts, ShadowBatches::batches * plan.rays_of_pilot());
    cast(plan.rays_of_pilot());
    const double unblocked = shares.strength(&LightShares::Share::unblocked);
    cast(plan.rays_after(shares.noise_of_visible_part(),
                         unblocked / (shares.strength(&LightShares::Share::known) + unblocked)));
}

void AreaLights::irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                            std::span<const Index> set_of, std::span<Rgb> H) const {
    worker.variance = Rgb::Zero();
    if (triangles_.empty()) {
        return;
    }
    collect(x, samples, stream, worker);
    if (worker.parts.empty()) {
        return;
    }
    const SurfacePoint from = inset(scene_.mesh, x);
    look(from, worker);
    worker.clear += worker.parts.empty() ? 1 : 0;
    if (!worker.parts.empty()) {
        cast_rays(from, samples, stream, worker);
        worker.variance = worker.shares.variance();
    }
    worker.shares.for_each_visible([&](Index material, const Rgb& irradiance) { H[set_of[material]] += irradiance; });
}

/// One area light for x, with the unblocked light it sends there divided by the probability of choosing it. A few
/// lights are chosen in proportion to that light, so that the choice adds no noise. Of more, the tree proposes some,
/// evenly spaced along it, and one of these is chosen likewise, with the mean of all as the light (resampled importance
/// sampling; Talbot, Cline and Egbert 2005).
AreaLights::Choice AreaLights::choose(const SurfacePoint& x, double u, double along, Worker& worker) const {
    worker.parts.clear();
    double mean = 0.0;
    const auto add = [&](Index triangle, double F, double weight) {
        const double light = weight * F * strength(triangle);
        mean += light;
        worker.parts.push_back({triangle, F, weight, light, 0, mean});
    };
    if (chooses_by_form_factors()) {
        for_each_facing(x, worker, [&](Index triangle, double F) { add(triangle, F, 1.0); });
    } else {
        constexpr auto count = static_cast<double>(proposals);
        for (std::size_t i = 0; i < proposals; ++i) {
            const auto pick =
                tree_->pick(LightTree::root, x.position, x.normal, (static_cast<double>(i) + along) / count);
            if (!pick) {
                continue;
            }
            const Index triangle = triangles_[pick->light];
            if (const double F = form_factor(x, triangle); F > 0.0) {
                add(triangle, F, 1.0 / (count * pick->probability));
            }
        }
    }
    double before = 0.0;
    for (const Worker::Part& part : worker.parts) {
        if (u * mean < part.below || &part == &worker.parts.back()) {
            return {part.triangle, part.weight * mean / (part.below - before), part.form_factor};
        }
        before = part.below;
    }
    return {};
}

AreaLights::Sample AreaLights::sample(const SurfacePoint& x, const std::array<double, 5>& u, Worker& worker) const {
    const Choice choice = choose(x, u[0], u[4], worker);
    if (choice.triangle == none || !(choice.form_factor > 0.0)) {
        return {};
    }
    const auto sample_of = [&](double seen) {
        return Sample{lamps().material[choice.triangle], choice.weight * seen * emission(choice.triangle)};
    };
    const SurfacePoint from = inset(scene_.mesh, x);
    // Of many lights, each is small: a ray to a point on it is as good as a shaft, and takes less time.
    if ((chooses_by_form_factors() || !blockers_) && !may_be_blocked(from, choice.triangle, worker.last_blocker)) {
        return sample_of(choice.form_factor);
    }
    const Target target = target_on(from, choice.triangle, {u[1], u[2], u[3]});
    if (!(target.form_factor > 0.0)) {
        return {};
    }
    if (is_blocked(from, target, choice.triangle, worker)) {
        ++worker.blocked_samples;
        return {};
    }
    return sample_of(target.form_factor);
}

bool AreaLights::is_blocked(const SurfacePoint& from, const Target& target, Index light, Worker& worker) const {
    const Segment segment{from.position, target.position, from.face, original(light)};
    std::uint8_t blocked = 0;
    worker.cast += tracer_.occluded({&segment, 1}, {&blocked, 1});
    return blocked != 0;
}

AreaLights::Sample AreaLights::sample_direction(const SurfacePoint& x, const std::array<double, 5>& u,
                                                Worker& worker) const {
    const Choice choice = choose(x, u[0], u[4], worker);
    if (choice.triangle == none || !(choice.form_factor > 0.0)) {
        return {};
    }
    const SurfacePoint from = inset(scene_.mesh, x);
    const Target target = target_on(from, choice.triangle, {u[1], u[2], u[3]});
    if (!(target.form_factor > 0.0)) {
        return {};
    }
    if (may_be_blocked(from, choice.triangle, worker.last_blocker) &&
        is_blocked(from, target, choice.triangle, worker)) {
        return {};
    }
    return {lamps().material[choice.triangle], choice.weight * target.form_factor * emission(choice.triangle),
            (target.position - from.position).normalized()};
}

/// One of several points spread over the triangle, chosen in proportion to what it sends to x, and the form factor as
/// the mean over them: their product with the visibility of the chosen point has the visible form factor as its
/// expectation.
AreaLights::Target AreaLights::target_on(const SurfacePoint& x, Index triangle, const std::array<double, 3>& u) const {
    const Mesh& mesh = lamps();
    std::array<Vec3, candidates> place;
    std::array<double, candidates> below{};
    double sum = 0.0;
    for (std::size_t i = 0; i < candidates; ++i) {
        const auto [place_u, place_v] = even_point<2>(i, {u[0], u[1]});
        place[i] = uniform_point(mesh, triangle, place_u, place_v).position;
        const Vec3 way = place[i] - x.position;
        const double r2 = way.squaredNorm();
        sum += std::max(0.0, x.normal.dot(way)) * std::max(0.0, -mesh.normals[triangle].dot(way)) / (r2 * r2);
        below[i] = sum;
    }
    const auto chosen = std::upper_bound(below.begin(), below.end() - 1, u[2] * sum) - below.begin();
    return {place[static_cast<std::size_t>(chosen)],
            sum * mesh.areas[triangle] / (static_cast<double>(candidates) * std::numbers::pi)};
}

} // namespace difusa
