#include <difusa/lighting/bright_surfels.h>

#include <difusa/core/even_sequence.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

/// Surfels whose centre is closer than this many of their edge lengths are left to the rays: within them the kernel
/// varies too much to be represented by the density at the centre.
constexpr double near = 4.0;

} // namespace

BrightSurfels::BrightSurfels(const Scene& scene, const Tracer& tracer, const Surfels& surfels,
                             const DirectLight& sources, const SurfelLight& light)
    : scene_(scene), tracer_(tracer), surfels_(surfels), sources_(sources) {
    // What each surfel sends of the one light and of the other.
    const std::array<Values, 2> sent{light.first_bounce(), light.uneven_emission};
    std::array<std::vector<double>, 2> power;
    std::array<double, 2> share{};
    for (std::size_t k = 0; k < sent.size(); ++k) {
        power[k].assign(surfels.size(), 0.0);
        double sum = 0.0, squares = 0.0;
        for (std::size_t s = 0; s < surfels.size() && sent[k].rows() > 0; ++s) {
            const double area = surfels.area(static_cast<Index>(s));
            const double q = area * sent[k].row(static_cast<Eigen::Index>(s)).cwiseAbs().sum();
            power[k][s] = q;
            sum += q;
            squares += area > 0.0 ? q * q / area : 0.0;
        }
        share[k] = sum > 0.0 ? sum * sum / (squares * scene.mesh.area) : 0.0;
    }
    bright_share_ = share[0];
    std::vector<double> below(surfels.size() + 1, 0.0);
    for (std::size_t s = 0; s < surfels.size(); ++s) {
        below[s + 1] = below[s] + (share[0] <= broad ? power[0][s] : 0.0) + (share[1] <= broad ? power[1][s] : 0.0);
    }
    if (!(below.back() > 0.0) || scene.mesh.repetition.any()) { // bins do not tell in which image a ray ended
        return;
    }
    emits_ = share[1] > 0.0 && share[1] <= broad;
    below_ = std::move(below);
    centre_.assign(surfels.size(), none);
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        if (below_[s + 1] > below_[s]) {
            const SurfacePoint centre = surfels.centre(s, pieces);
            centre_[s] = static_cast<Index>(centres_.size());
            centres_.emplace_back(centre.position, centre.normal);
        }
    }
}

/// Probability density, by area, of sampling a point on the surfel.
double BrightSurfels::density(Index s) const {
    const double area = surfels_.area(s);
    return area > 0.0 ? (below_[s + 1] - below_[s]) / below_.back() / area : 0.0;
}

/// Probability density, by area, with which a ray from x goes towards y: cosine over pi by solid angle, directions
/// below the plane of the face being mirrored to above it (Sight::cast). This is also the kernel of irradiance.
double BrightSurfels::ray_density(const SurfacePoint& x, const Vec3& y, const Vec3& n_y) const {
    const Vec3 way = y - x.position;
    const Vec3& n = scene_.mesh.face_normal(x);
    const double r2 = way.squaredNorm(), up = n.dot(way), at_y = -n_y.dot(way);
    if (!(up > 0.0) || !(at_y > 0.0)) {
        return 0.0;
    }
    const double at_x = std::max(0.0, x.normal.dot(way)) + std::max(0.0, x.normal.dot(way - 2.0 * up * n));
    return at_x * at_y / (std::numbers::pi * r2 * r2);
}

/// The points on bright surfels visible from x, the ray origin.
void BrightSurfels::draw(const SurfacePoint& x, std::size_t count, RandomStream& stream, Worker& worker) const {
    worker.places.clear();
    worker.surfel.clear();
    worker.segments.clear();
    const double along = stream.uniform();
    const std::array<double, 2> shift{stream.uniform(), stream.uniform()};
    auto after = below_.begin();
    Index at_hand = none;
    for (std::size_t k = 0; k < count; ++k) {
        // Below the sum of all, also where rounding says otherwise: the last surfel may be a dark one.
        const double light = std::min((static_cast<double>(k) + along) / static_cast<double>(count) * below_.back(),
                                      std::nextafter(below_.back(), 0.0));
        after = std::upper_bound(after, below_.end() - 1, light);
        const auto s = static_cast<Index>(std::distance(below_.begin(), after) - 1);
        if (s != at_hand) {
            surfels_.pieces(s, worker.pieces);
            at_hand = s;
        }
        const auto [u, v] = even_point<2>(k, shift);
        const SurfacePoint y = surfels_.point_on(worker.pieces, u, v);
        if (ray_density(x, y.position, y.normal) > 0.0) {
            worker.places.push_back(y);
            worker.surfel.push_back(s);
            worker.segments.push_back({x.position, y.position, x.face, y.face});
        }
    }
    worker.blocked.resize(worker.places.size());
    worker.light.cast += tracer_.occluded_between(worker.segments, worker.blocked);
    std::size_t seen = 0;
    for (std::size_t k = 0; k < worker.places.size(); ++k) {
        if (worker.blocked[k] == 0) {
            worker.places[seen] = worker.places[k];
            worker.surfel[seen++] = worker.surfel[k];
        }
    }
    worker.places.resize(seen);
    worker.surfel.resize(seen);
}

Eigen::RowVectorXd BrightSurfels::gather(const SurfacePoint& x, std::span<const Index> hit,
                                         std::span<const double> weight, std::size_t rays, const Values& sent,
                                         RandomStream& stream, Worker& worker) const {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(sent.cols());
    const SurfacePoint from = inset(scene_.mesh, x); // where the rays started
    const std::size_t count = places(rays);
    const auto by_rays = static_cast<double>(rays), by_places = static_cast<double>(count);
    const double reach = near * surfels_.edge();
    // The density of both kinds of samples that land on a surfel, as far as its centre can represent it; 0 for near
    // surfels, which are left to the rays.
    const auto density_of_both = [&](Index s, double& of_rays) {
        const auto& [centre, normal] = centres_[centre_[s]];
        of_rays = by_rays * ray_density(from, centre, normal);
        return (centre - from.position).squaredNorm() < reach * reach ? 0.0 : of_rays + by_places * density(s);
    };
    for (std::size_t k = 0; k < hit.size(); ++k) {
        const Index s = hit[k];
        if (s >= centre_.size()) {
            continue;
        }
        double of_rays = 0.0;
        const double both = centre_[s] != none ? density_of_both(s, of_rays) : 0.0;
        sum += (both > 0.0 ? of_rays / both : 1.0) * weight[k] * sent.row(s);
    }
    draw(from, count, stream, worker);
    for (std::size_t k = 0; k < worker.places.size(); ++k) {
        double of_rays = 0.0;
        const double both = density_of_both(worker.surfel[k], of_rays);
        if (both > 0.0) {
            const SurfacePoint& y = worker.places[k];
            sum += ray_density(from, y.position, y.normal) / both * sent.row(worker.surfel[k]);
        }
    }
    return sum;
}

/// Adds rho H at each y, times Worker::factor, with fresh shadow rays. Worker::surfel: the surfels, for the shortcut.
void BrightSurfels::add_reflected(std::span<const SurfacePoint> y, RandomStream& stream, Worker& worker,
                                  std::span<Rgb> H, const Shortcut* shortcut) const {
    const std::size_t sets = H.size(), first = shortcut != nullptr ? stream.below(shortcut->stride) : 0;
    const auto is_short = [&](std::size_t p) { return shortcut != nullptr && shortcut->even[worker.surfel[p]] != 0; };
    worker.sampled.clear();
    worker.sampled_at.clear();
    for (std::size_t p = 0; p < y.size(); ++p) {
        if (!is_short(p) || p % shortcut->stride == first) {
            worker.sampled.push_back(p);
            worker.sampled_at.push_back(y[p]);
        }
    }
    worker.H.resize(worker.sampled.size() * sets);
    sources_.sample(worker.sampled_at, stream, worker.H, worker.light);
    for (std::size_t k = 0; k < worker.sampled.size(); ++k) {
        double& factor = worker.factor[worker.sampled[k]];
        const double times = is_short(worker.sampled[k]) ? static_cast<double>(shortcut->stride) : 1.0;
        const Rgb rho = times * factor * scene_.reflectance(worker.sampled_at[k]);
        for (std::size_t set = 0; set < sets; ++set) {
            H[set] += rho * worker.H[k * sets + set];
        }
        factor -= times * factor;
    }
    if (shortcut == nullptr) {
        return;
    }
    const Eigen::Index channels = shortcut->first_bounce.cols() / static_cast<Eigen::Index>(sets);
    for (std::size_t p = 0; p < y.size(); ++p) {
        const double* light = shortcut->first_bounce.row(static_cast<Eigen::Index>(worker.surfel[p])).data();
        for (std::size_t set = 0; is_short(p) && set < sets; ++set, light += channels) {
            for (Eigen::Index channel = 0; channel < channels; ++channel) {
                H[set][channel] += worker.factor[p] * light[channel];
            }
        }
    }
}

/// Adds the emission at each y, times Worker::factor, of materials that emit unevenly.
void BrightSurfels::add_emitted(std::span<const SurfacePoint> y, const Worker& worker, std::span<Rgb> E) const {
    for (std::size_t p = 0; p < y.size() && samples_emission(); ++p) {
        const Index material = scene_.mesh.material[y[p].face];
        if (scene_.materials[material].emits_unevenly() && sources_.area_light_materials()[material] == 0) {
            E[sources_.sets().material[material]] += worker.factor[p] * scene_.emission(y[p]);
        }
    }
}

void BrightSurfels::gather_exactly(const SurfacePoint& x, std::span<const SurfacePoint> met,
                                   std::span<const double> weight, std::size_t rays, RandomStream& stream,
                                   Worker& worker, std::span<Rgb> H, std::span<Rgb> E, const Shortcut* shortcut) const {
    std::fill(H.begin(), H.end(), Rgb(Rgb::Zero()));
    std::fill(E.begin(), E.end(), Rgb(Rgb::Zero()));
    const SurfacePoint from = inset(scene_.mesh, x);
    const std::size_t count = places(rays);
    const auto by_rays = static_cast<double>(rays), by_places = static_cast<double>(count);
    worker.factor.assign(weight.begin(), weight.end());
    worker.surfel.clear();
    for (std::size_t p = 0; p < met.size() && (count > 0 || shortcut != nullptr); ++p) {
        worker.surfel.push_back(surfels_.at(met[p].face, met[p].u, met[p].v));
        if (count > 0) {
            const double other = by_places * density(worker.surfel[p]);
            const double own = other > 0.0 ? by_rays * ray_density(from, met[p].position, met[p].normal) : 1.0;
            worker.factor[p] *= own / (own + other);
        }
    }
    add_emitted(met, worker, E);
    add_reflected(met, stream, worker, H, shortcut);
    if (count == 0) {
        return;
    }
    draw(from, count, stream, worker);
    worker.factor.clear();
    for (std::size_t k = 0; k < worker.places.size(); ++k) {
        const double own = ray_density(from, worker.places[k].position, worker.places[k].normal);
        worker.factor.push_back(own / (by_rays * own + by_places * density(worker.surfel[k])));
    }
    add_emitted(worker.places, worker, E);
    add_reflected(worker.places, stream, worker, H, shortcut);
}

} // namespace difusa
