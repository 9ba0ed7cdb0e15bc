#include <difusa/lighting/lamps.h>

#include <difusa/lighting/lambert.h>
#include <difusa/transport/transport.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace difusa {

namespace {

constexpr double largest_share = 0.1;
constexpr std::size_t most_triangles = 4096;
constexpr std::size_t most_materials = 32;

/// Up to so many lamps are chosen among by their form factors, which is exact where nothing blocks; more of them by
/// their power.
constexpr std::size_t few = 16;

/// Fractional parts of i times the powers of the plastic number's inverse: an even sequence in the square (Roberts).
double even_u(std::size_t i) {
    return static_cast<double>(i) * 0.7548776662466927;
}
double even_v(std::size_t i) {
    return static_cast<double>(i) * 0.5698402909980532;
}
double fraction(double x) {
    return x - std::floor(x);
}

} // namespace

std::vector<Index> lamp_triangles(const Scene& scene) {
    const std::vector<char> emits = emitting_materials(scene);
    std::vector<Index> lamps;
    std::set<Index> materials;
    double area = 0.0;
    bool patterned = false;
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        const Index material = scene.mesh.material[t];
        if (emits[material] != 0) {
            lamps.push_back(t);
            materials.insert(material);
            area += scene.mesh.areas[t];
            patterned = patterned || scene.materials[material].emission_pattern;
        }
    }
    if (patterned || area > largest_share * scene.mesh.area || lamps.size() > most_triangles ||
        materials.size() > most_materials) {
        lamps.clear();
    }
    return lamps;
}

Lamps::Lamps(const Scene& scene, const std::vector<Index>& triangles, const Visibility& visibility)
    : scene_(scene), visibility_(visibility), triangles_(triangles) {
    std::map<Index, Group> groups;
    double power = 0.0;
    for (const Index t : triangles) {
        Group& group = groups[scene.mesh.material[t]];
        group.material = scene.mesh.material[t];
        group.triangles.push_back(t);
        power += scene.mesh.areas[t] * scene.materials[group.material].emission.mean();
        power_.push_back(power);
    }
    for (auto& [material, group] : groups) {
        groups_.push_back(std::move(group));
    }
}

double Lamps::visible_form_factor(const SurfacePoint& x, const Group& group, std::size_t samples, RandomStream& stream,
                                  Worker& worker) const {
    const Mesh& mesh = scene_.mesh;
    worker.form_factor.clear();
    double F = 0.0;
    for (const Index t : group.triangles) {
        F += t == x.face
                 ? 0.0
                 : lambert_form_factor(x.position, x.normal, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
        worker.form_factor.push_back(F); // running sum
    }
    if (!(F > 0.0)) {
        return 0.0;
    }
    place_samples(x, group, F, samples, stream, worker);
    worker.blocked.resize(worker.segments.size());
    visibility_.occluded(worker.segments, worker.blocked);
    double seen = 0.0, all = 0.0;
    for (std::size_t s = 0; s < worker.segments.size(); ++s) {
        all += worker.weight[s];
        seen += worker.blocked[s] == 0 ? worker.weight[s] : 0.0;
    }
    worker.cast += worker.segments.size();
    return all > 0.0 ? F * seen / all : F; // grazing: every sample fell below the horizon
}

/// Sample s goes to the lamp that holds the share (s + shift) / samples of the form factor, to an even place on it.
void Lamps::place_samples(const SurfacePoint& x, const Group& group, double F, std::size_t samples,
                          RandomStream& stream, Worker& worker) const {
    const std::vector<double>& below = worker.form_factor;
    worker.segments.clear();
    worker.weight.clear();
    const double shift = stream.uniform(), shift_u = stream.uniform(), shift_v = stream.uniform();
    for (std::size_t s = 0; s < samples; ++s) {
        const double share = F * (static_cast<double>(s) + shift) / static_cast<double>(samples);
        const auto place = std::upper_bound(below.begin(), below.end(), share);
        const std::size_t lamp = std::min(static_cast<std::size_t>(place - below.begin()), below.size() - 1);
        const double own = below[lamp] - (lamp == 0 ? 0.0 : below[lamp - 1]);
        if (!(own > 0.0)) {
            continue;
        }
        const double root = std::sqrt(fraction(even_u(s) + shift_u)), part = fraction(even_v(s) + shift_v);
        const SurfacePoint y = scene_.mesh.at(group.triangles[lamp], root * (1.0 - part), root * part);
        const Vec3 way = y.position - x.position;
        const double cosines = x.normal.dot(way) * -y.normal.dot(way);
        const double r2 = way.squaredNorm();
        if (x.normal.dot(way) > 0.0 && cosines > 0.0) {
            worker.segments.push_back({x.position, y.position, x.face, y.face});
            worker.weight.push_back(cosines / (r2 * r2) * scene_.mesh.areas[y.face] / own);
        }
    }
}

Lamps::Choice Lamps::choose(const SurfacePoint& x, RandomStream& stream, Worker& worker) const {
    const Mesh& mesh = scene_.mesh;
    const double at = stream.uniform();
    const auto pick = [&](const std::vector<double>& below) {
        const auto place = std::upper_bound(below.begin(), below.end(), at * below.back());
        const std::size_t lamp = std::min(static_cast<std::size_t>(place - below.begin()), below.size() - 1);
        const double own = below[lamp] - (lamp == 0 ? 0.0 : below[lamp - 1]);
        return std::pair(lamp, own / below.back());
    };
    if (triangles_.size() > few) {
        const auto [lamp, probability] = pick(power_);
        return {triangles_[lamp], probability, -1.0};
    }
    worker.form_factor.clear();
    double sum = 0.0;
    for (const Index t : triangles_) {
        const double F = t == x.face ? 0.0
                                     : lambert_form_factor(x.position, x.normal, mesh.corner(t, 0), mesh.corner(t, 1),
                                                           mesh.corner(t, 2));
        sum += F * scene_.materials[mesh.material[t]].emission.mean();
        worker.form_factor.push_back(sum);
    }
    if (!(sum > 0.0)) {
        return {};
    }
    const auto [lamp, probability] = pick(worker.form_factor);
    return {triangles_[lamp], probability,
            probability * sum / scene_.materials[mesh.material[triangles_[lamp]]].emission.mean()};
}

Rgb Lamps::sample(const SurfacePoint& x, RandomStream& stream, Worker& worker) const {
    const Choice choice = choose(x, stream, worker);
    if (choice.triangle == none || choice.triangle == x.face || !(choice.probability > 0.0)) {
        return Rgb::Zero();
    }
    const Mesh& mesh = scene_.mesh;
    const Vec3 &a = mesh.corner(choice.triangle, 0), &b = mesh.corner(choice.triangle, 1),
               &c = mesh.corner(choice.triangle, 2);
    // Far away the point-to-point kernel hardly varies over the lamp. Near by it is not bounded: there the closed form
    // takes its place, and the shadow ray goes to a place above the horizon.
    const double size = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    const bool near = ((a + b + c) / 3.0 - x.position).squaredNorm() < 9.0 * size;
    SurfacePoint y;
    double cosine_x = 0.0, cosine_y = 0.0, r2 = 1.0;
    for (int attempt = 0; attempt < (near ? 32 : 1) && !(cosine_x > 0.0); ++attempt) {
        const double root = std::sqrt(stream.uniform()), part = stream.uniform();
        y = mesh.at(choice.triangle, root * (1.0 - part), root * part);
        const Vec3 way = y.position - x.position;
        cosine_x = x.normal.dot(way);
        cosine_y = -y.normal.dot(way);
        r2 = way.squaredNorm();
    }
    if (!(cosine_x > 0.0 && cosine_y > 0.0)) {
        return Rgb::Zero();
    }
    const double F = !near ? cosine_x * cosine_y / (std::numbers::pi * r2 * r2) * mesh.areas[y.face]
                     : choice.form_factor >= 0.0 ? choice.form_factor
                                                 : lambert_form_factor(x.position, x.normal, a, b, c);
    const Segment segment{x.position, y.position, x.face, y.face};
    std::uint8_t blocked = 0;
    visibility_.occluded(std::span(&segment, 1), std::span(&blocked, 1));
    ++worker.cast;
    if (blocked != 0) {
        return Rgb::Zero();
    }
    return scene_.materials[scene_.mesh.material[y.face]].emission * (F / choice.probability);
}

} // namespace difusa
