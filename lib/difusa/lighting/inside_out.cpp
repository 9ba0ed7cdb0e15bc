#include <difusa/lighting/inside_out.h>

#include <difusa/core/frame.h>
#include <difusa/core/random.h>
#include <difusa/mesh/borders.h>
#include <difusa/mesh/parity_sets.h>
#include <difusa/mesh/surface_sampling.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t most_samples = 256; ///< of a part at first sight
constexpr std::size_t samples_of_all = 1U << 17U;
constexpr std::size_t confirmation = 16; ///< times as many, at most, before a part is turned over
constexpr double least_enclosed = 0.9;   ///< share of rays that end in the part itself, for it to be leaky
constexpr double least_contrast = 10.0;  ///< of light on backs to light on fronts, likewise
constexpr int most_rounds = 3;

std::vector<ConnectedPart> connected_parts(const Scene& scene, std::vector<Index>& part_of_triangle) {
    const Mesh& mesh = scene.mesh;
    ParitySets sets(mesh.points.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        sets.join(a, b, false);
        sets.join(a, c, false);
    }
    const std::vector<char> emits = emitting_materials(scene);
    std::vector<Index> number(mesh.points.size(), none);
    std::vector<ConnectedPart> parts;
    part_of_triangle.resize(mesh.triangles.size());
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        Index& part = number[sets.find(mesh.triangles[t][0]).root];
        if (part == none) {
            part = static_cast<Index>(parts.size());
            parts.emplace_back();
        }
        part_of_triangle[t] = part;
        parts[part].triangles.push_back(t);
        parts[part].emits = parts[part].emits || emits[mesh.material[t]] != 0;
    }
    for (ConnectedPart& part : parts) { // divergence theorem, about a point of the part
        const Vec3& origin = mesh.corner(part.triangles.front(), 0);
        double area = 0.0;
        for (const Index t : part.triangles) {
            part.volume += mesh.areas[t] * mesh.normals[t].dot(mesh.corner(t, 0) - origin) / 3.0;
            area += mesh.areas[t];
        }
        const double rounding = 1e-9 * area * std::sqrt(area);
        part.volume = std::abs(part.volume) > rounding ? part.volume : 0.0;
    }
    return parts;
}

/// Whether a direction leaves the front of a face. One within the plane does not, whatever its rounding: a lamp, a sun
/// or a camera exactly in the plane of a face is seen from neither of its sides.
bool in_front(const Vec3& normal, const Vec3& way) {
    return normal.dot(way) > 1e-6 * way.norm();
}

/// What is seen from one side of a part: numbers of samples.
struct Outlook {
    std::size_t samples = 0;
    std::size_t own = 0;     ///< rays that end on the same side of the same part
    std::size_t others = 0;  ///< rays that end on other parts
    std::size_t escaped = 0; ///< rays that end nowhere
    std::size_t sky = 0;     ///< rays to a sky that shines, or towards a sun
    std::size_t lamps = 0;   ///< unobstructed segments to point lights and to the fronts of emitting faces
    std::size_t eye = 0;     ///< unobstructed segments to the camera

    bool sealed() const { return own == samples; }
    std::size_t light() const { return sky + lamps; }
};

SurfacePoint draw(const Mesh& mesh, const TriangleSampler& sampler, RandomStream& stream) {
    const double share = stream.uniform(), u = stream.uniform(), v = stream.uniform();
    return inset(mesh, sampler.at(share, u, v));
}

class Weighing {
  public:
    Weighing(const Scene& scene, const std::optional<Camera>& camera, const Visibility& engine, std::uint64_t seed)
        : scene_(scene), camera_(camera), engine_(engine), seed_(seed), parts_(connected_parts(scene, part_)),
          turned_(parts_.size(), 0), emitting_(emitting_triangles()), emitters_(scene.mesh, emitting_) {
        const std::vector<Material>& materials = scene.materials;
        for (const ConnectedPart& part : parts_) {
            // Double-sided faces have no wrong side; a part with some of them may have a volume all the same.
            const bool both = std::any_of(part.triangles.begin(), part.triangles.end(),
                                          [&](Index t) { return materials[scene.mesh.material[t]].double_sided; });
            candidate_.push_back(!both && part.volume != 0.0 && (part.volume < 0.0 || lights_inside_possible()) ? 1
                                                                                                                : 0);
        }
        const auto candidates = static_cast<std::size_t>(std::count(candidate_.begin(), candidate_.end(), 1));
        const std::size_t each = samples_of_all / std::max<std::size_t>(candidates, 1);
        samples_ = std::clamp<std::size_t>(each, 16, most_samples);
        confirming_samples_ = std::clamp<std::size_t>(8 * each, samples_, confirmation * samples_);
    }

    FrontVerdict verdict(const Execution& execution) {
        std::vector<JudgedPart> faults;
        for (int round = 0; round < most_rounds; ++round) {
            bool changed = false;
            faults.clear();
            for (std::size_t p = 0; p < parts_.size(); ++p) {
                if (candidate_[p] == 0 || turned_[p] != 0) {
                    continue;
                }
                execution.check();
                if (const auto fault = fault_of(p)) {
                    faults.push_back({p, *fault});
                    changed = changed || *fault == FrontFault::inside_out;
                    turned_[p] = *fault == FrontFault::inside_out ? 1 : 0;
                }
            }
            if (!changed) {
                break;
            }
        }
        std::erase_if(faults, [](const JudgedPart& f) { return f.fault == FrontFault::inside_out; });
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            if (turned_[p] != 0) {
                faults.push_back({p, FrontFault::inside_out});
            }
        }
        std::sort(faults.begin(), faults.end(), [](const auto& a, const auto& b) { return a.part < b.part; });
        return {std::move(parts_), std::move(faults)};
    }

  private:
    bool lights_inside_possible() const { return camera_ || !scene_.point_lights.empty() || !emitters_.empty(); }

    std::vector<Index> emitting_triangles() const {
        const std::vector<char> emits = emitting_materials(scene_);
        std::vector<Index> all;
        for (Index t = 0; t < scene_.mesh.triangles.size(); ++t) {
            if (emits[scene_.mesh.material[t]] != 0) {
                all.push_back(t);
            }
        }
        return all;
    }

    /// What is seen from the fronts (side 1) or backs (-1) of a part, as the mesh is now.
    Outlook look(std::size_t p, double side, std::size_t samples) const {
        const Mesh& mesh = scene_.mesh;
        Outlook sight;
        sight.samples = samples;
        RandomStream stream(seed_, side > 0.0 ? "fronts" : "backs", p);
        const TriangleSampler part(mesh, parts_[p].triangles);
        std::vector<Ray> rays, suns;
        std::vector<Segment> lamps, eyes;
        for (std::size_t i = 0; i < samples; ++i) {
            const SurfacePoint x = draw(mesh, part, stream);
            const Vec3 n = side * x.normal;
            const double u = stream.uniform(), angle = 2.0 * std::numbers::pi * stream.uniform();
            rays.push_back({x.position, cosine_direction(n, u, angle), x.face});
            if (!scene_.suns.empty()) {
                const Sun& sun = scene_.suns[i % scene_.suns.size()];
                if (in_front(n, sun.towards) && (sun.irradiance > 0.0).any()) {
                    suns.push_back({x.position, sun.towards, x.face});
                }
            }
            if (!scene_.point_lights.empty()) {
                const PointLight& lamp = scene_.point_lights[i % scene_.point_lights.size()];
                if (in_front(n, lamp.position - x.position) && (lamp.intensity > 0.0).any()) {
                    lamps.push_back({x.position, lamp.position, x.face, none});
                }
            }
            if (!emitters_.empty()) {
                const SurfacePoint y = draw(mesh, emitters_, stream);
                const Vec3 way = y.position - x.position;
                const double facing = turned_[part_[y.face]] != 0 ? 1.0 : -1.0;
                if (in_front(n, way) && in_front(facing * y.normal, way)) {
                    lamps.push_back({x.position, y.position, x.face, y.face});
                }
            }
            if (camera_ && in_front(n, camera_->eye - x.position)) {
                eyes.push_back({x.position, camera_->eye, x.face, none});
            }
        }
        std::vector<Hit> hits(rays.size());
        engine_.first_hits(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit& hit = hits[i];
            if (hit.face == none) {
                ++sight.escaped;
                sight.sky += (scene_.sky_radiance(rays[i].direction.normalized()) > 0.0).any() ? 1 : 0;
            } else if (part_[hit.face] != p) {
                ++sight.others;
            } else {
                sight.own += hit.front == (side > 0.0) ? 1 : 0;
            }
        }
        hits.resize(suns.size());
        engine_.first_hits(suns, hits);
        sight.sky += static_cast<std::size_t>(
            std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return hit.face == none; }));
        sight.lamps = unobstructed(lamps);
        sight.eye = unobstructed(eyes);
        return sight;
    }

    std::size_t unobstructed(const std::vector<Segment>& segments) const {
        std::vector<std::uint8_t> blocked(segments.size());
        engine_.occluded(segments, blocked);
        return static_cast<std::size_t>(std::count(blocked.begin(), blocked.end(), std::uint8_t{0}));
    }

    std::optional<FrontFault> fault_of(std::size_t p) const {
        return parts_[p].volume < 0.0 ? fault_of_inward(p) : fault_of_outward(p);
    }

    /// Fronts face the inside.
    std::optional<FrontFault> fault_of_inward(std::size_t p) const {
        const Outlook fronts = look(p, 1.0, samples_);
        if (parts_[p].emits || fronts.lamps > 0 || fronts.eye > 0) {
            return std::nullopt; // a room
        }
        const auto enclosed = static_cast<double>(fronts.own) / static_cast<double>(fronts.samples);
        if (!fronts.sealed() && fronts.others == 0 && enclosed < least_enclosed) {
            return std::nullopt;
        }
        const Outlook backs = look(p, -1.0, samples_);
        if (backs.light() == 0) {
            return std::nullopt;
        }
        if (fronts.sealed()) {
            const Outlook again = look(p, 1.0, confirming_samples_);
            // No number of rays proves that there is no hole, and a small one may light a hall.
            if (again.sealed() && again.light() == 0 && again.eye == 0 &&
                !has_border(scene_.mesh, parts_[p].triangles)) {
                return FrontFault::inside_out;
            }
            return again.eye > 0 || again.lamps > 0 ? std::nullopt : std::optional(FrontFault::leaky);
        }
        if (fronts.others > 0) {
            return fronts.escaped == 0 ? std::optional(FrontFault::dark_room) : std::nullopt;
        }
        return least_contrast * static_cast<double>(fronts.light()) < static_cast<double>(backs.light())
                   ? std::optional(FrontFault::leaky)
                   : std::nullopt;
    }

    /// Fronts face outwards.
    std::optional<FrontFault> fault_of_outward(std::size_t p) const {
        const Outlook backs = look(p, -1.0, samples_);
        const bool holds_light = backs.lamps > 0 || (parts_[p].emits && backs.others > 0);
        if (backs.escaped > 0 || !(holds_light || backs.eye > 0)) {
            return std::nullopt;
        }
        const Outlook fronts = look(p, 1.0, samples_);
        if (!backs.sealed() && fronts.others > 0) {
            return std::nullopt; // an open cupboard in a room, perhaps
        }
        if (backs.eye > 0 || (fronts.light() == 0 && fronts.others == 0)) {
            const Outlook again = look(p, -1.0, confirming_samples_);
            return again.escaped == 0 ? std::optional(FrontFault::inside_out) : std::nullopt;
        }
        return backs.lamps > 0 ? std::optional(FrontFault::shut_light) : std::nullopt;
    }

    const Scene& scene_;
    const std::optional<Camera>& camera_;
    const Visibility& engine_;
    const std::uint64_t seed_;
    std::vector<Index> part_; ///< of each triangle
    std::vector<ConnectedPart> parts_;
    std::vector<char> turned_; ///< parts found inside out
    std::vector<char> candidate_;
    std::vector<Index> emitting_; ///< triangles
    TriangleSampler emitters_;
    std::size_t samples_ = 0, confirming_samples_ = 0;
};

} // namespace

FrontVerdict judge_fronts(const Scene& scene, const std::optional<Camera>& camera, const Visibility& engine,
                          std::uint64_t seed, const Execution& execution) {
    return Weighing(scene, camera, engine, seed).verdict(execution);
}

} // namespace difusa
