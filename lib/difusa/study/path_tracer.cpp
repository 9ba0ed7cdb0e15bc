#include <difusa/study/path_tracer.h>

#include <difusa/core/error.h>
#include <difusa/core/frame.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa {

namespace {

struct Path {
    std::size_t number;
    SurfacePoint at;
    Rgb weight;
    const GlossyLobe* lobe = nullptr;          ///< that it has been reflected by; null: diffusely
    Vec3 out = Vec3::Zero();                   ///< towards where it came from
    double kernel(const Vec3& towards) const { // of unit length; without the cosine
        return lobe == nullptr ? std::numbers::inv_pi : lobe->value(at.normal, towards, out);
    }
};

/// The emitting faces.
class Lamps {
  public:
    explicit Lamps(const Scene& scene) : mesh_(scene.mesh) {
        for (Index t = 0; t < mesh_.triangles.size(); ++t) {
            if ((scene.materials[mesh_.material[t]].emission > 0.0).any()) {
                faces_.push_back(t);
                below_.push_back(area() + mesh_.areas[t]);
            }
        }
    }
    double area() const { return below_.empty() ? 0.0 : below_.back(); }

    /// A point that is uniform by area.
    SurfacePoint draw(RandomStream& stream) const {
        const auto place = std::upper_bound(below_.begin(), below_.end(), stream.uniform() * area());
        const auto number = std::min<std::size_t>(static_cast<std::size_t>(place - below_.begin()), faces_.size() - 1);
        const double u = stream.uniform(), v = stream.uniform();
        return uniform_point(mesh_, faces_[number], u, v);
    }

  private:
    const Mesh& mesh_;
    std::vector<Index> faces_;
    std::vector<double> below_;
};

/// Sets the direction of the ray by which a path goes on; returns its weight. Around a shading normal, what would lead
/// below the face is mirrored at it, or lost if it is glossy, as in Sight::lift and drawn_ray.
double draw_ray(const Mesh& mesh, const Path& path, RandomStream& stream, Ray& ray) {
    const Vec3& face = mesh.normals[path.at.face];
    if (path.lobe != nullptr) {
        const double u = stream.uniform(), v = stream.uniform(), w = stream.uniform();
        const GlossyLobe::Draw drawn = path.lobe->draw(path.at.normal, path.out, {u, v, w});
        ray.direction = drawn.direction;
        return path.at.normal == face || face.dot(drawn.direction) > 0.0 ? drawn.weight : 0.0;
    }
    Vec3 t, b;
    tangents(path.at.normal, t, b);
    const double r = std::sqrt(stream.uniform()), angle = 2.0 * std::numbers::pi * stream.uniform();
    ray.direction = r * std::cos(angle) * t + r * std::sin(angle) * b + std::sqrt(1.0 - r * r) * path.at.normal;
    if (path.at.normal != face) {
        ray.direction -= 2.0 * std::min(0.0, face.dot(ray.direction)) * face;
    }
    return 1.0;
}

/// Reflects a path where it has arrived; false if it ends there (Russian roulette).
bool reflect(const Scene& scene, Path& path, RandomStream& stream) {
    const GlossySurfaces& glossy = scene.mesh.glossy;
    Rgb weight = path.weight * scene.reflectance(path.at);
    if (const Index kind = glossy.kind(path.at.face); kind != none) {
        const Rgb gloss = path.weight * glossy.kinds[kind].reflectance;
        const double share = gloss.sum() / (gloss + weight).sum();
        const bool glossily = stream.uniform() < share;
        path.lobe = glossily ? &glossy.lobe_of(kind) : nullptr;
        weight = glossily ? Rgb(gloss / share) : Rgb(weight / (1.0 - share));
    }
    if (!(weight > 0.0).any()) {
        return false;
    }
    const double survival = std::min(1.0, weight.maxCoeff());
    path.weight = weight / survival;
    return stream.uniform() < survival;
}

} // namespace

TracedLight trace_paths(const Scene& scene, const Visibility& visibility, const SurfacePoint& x, std::size_t paths,
                        RandomStream stream) {
    DIFUSA_REQUIRE(paths >= 2);
    const Mesh& mesh = scene.mesh;
    const Lamps lamps(scene);
    if (lamps.area() == 0.0) {
        return {};
    }
    std::vector<Path> open;
    for (std::size_t i = 0; i < paths; ++i) {
        open.push_back({i, x, Rgb::Ones()});
    }
    std::vector<Rgb> sum(paths, Rgb::Zero());
    std::vector<Segment> segments;
    std::vector<Rgb> light;
    std::vector<std::uint8_t> blocked;
    std::vector<Ray> rays;
    std::vector<double> weights; ///< of each ray
    std::vector<Hit> hits;
    while (!open.empty()) {
        segments.clear();
        light.clear();
        rays.clear();
        weights.clear();
        for (const Path& path : open) {
            const SurfacePoint y = lamps.draw(stream);
            const Vec3 way = y.position - path.at.position;
            const double r2 = way.squaredNorm();
            const double cosines = std::max(0.0, path.at.normal.dot(way)) * std::max(0.0, -y.normal.dot(way));
            light.push_back(cosines > 0.0 ? Rgb(path.weight * scene.emission(y) *
                                                (lamps.area() * cosines * path.kernel(way.normalized()) / (r2 * r2)))
                                          : Rgb(Rgb::Zero()));
            segments.push_back({path.at.position, y.position, path.at.face, y.face});
            rays.push_back({path.at.position, Vec3::Zero(), path.at.face});
            weights.push_back(draw_ray(mesh, path, stream, rays.back()));
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
            Path path{open[i].number, mesh.shaded(mesh.at(hits[i].face, hits[i].u, hits[i].v)),
                      weights[i] * open[i].weight, nullptr, -rays[i].direction};
            if (reflect(scene, path, stream)) {
                next.push_back(path);
            }
        }
        open = std::move(next);
    }
    TracedLight traced;
    const auto n = static_cast<double>(paths);
    for (const Rgb& s : sum) {
        traced.mean += s / n;
    }
    for (const Rgb& s : sum) {
        const Vec3 off = (s - traced.mean).matrix();
        traced.covariance += off * off.transpose() / (n * (n - 1.0));
    }
    return traced;
}

} // namespace difusa
