#include <difusa/render/specular_paths.h>

#include <span>

namespace difusa {

Hit first_shown(const Mesh& mesh, const Visibility& visibility, Ray ray, bool cull_backs) {
    Hit hit;
    double before = 0.0;
    for (int passed = 0; passed < 65536; ++passed) {
        visibility.first_hits(std::span(&ray, 1), std::span(&hit, 1));
        if (hit.face == none || hit.front || !cull_backs) {
            hit.t += before;
            return hit;
        }
        before += hit.t;
        if (mesh.repetition.any()) { // the face may be that of an image: past it by more than rounding
            const double step = hit.t + 0x1p-30 * (hit.t + mesh.diameter() / ray.direction.norm());
            before += step - hit.t;
            ray.origin += step * ray.direction;
            continue;
        }
        ray.origin = mesh.at(hit.face, hit.u, hit.v).position;
        ray.face = hit.face;
    }
    return {};
}

void SpecularPaths::follow(const Hit& hit, const Vec3& direction, RandomStream& stream,
                           std::vector<SeenInMirror>& sights, std::vector<SeenGloss>& glossy) const {
    const bool is_glossy = hit.face != none && hit.front && mesh_.glossy.kind(hit.face) != none;
    const std::size_t rays = is_glossy ? glossy_rays_ : 1;
    for (std::size_t k = 0; k < rays; ++k) {
        follow_one(hit, direction, 1.0 / static_cast<double>(rays), stream, sights, glossy);
    }
}

void SpecularPaths::follow_one(Hit hit, Vec3 direction, double share, RandomStream& stream,
                               std::vector<SeenInMirror>& sights, std::vector<SeenGloss>& glossy) const {
    Rgb colour = Rgb::Constant(share);
    for (std::size_t depth = 0; depth < mesh_.mirrors.most && hit.face != none && hit.front; ++depth) {
        Ray next;
        if (const Index kind = mesh_.mirrors.kind(hit.face); kind != none) {
            next = reflected_ray(mesh_, hit, direction);
            colour *= mesh_.mirrors.reflectance[kind];
        } else if (const Index gloss = mesh_.glossy.kind(hit.face); gloss != none) {
            const SurfacePoint at = mesh_.shaded(mesh_.at(hit.face, hit.u, hit.v));
            glossy.push_back({at, gloss, direction, colour * mesh_.glossy.kinds[gloss].reflectance});
            const DrawnRay drawn = drawn_ray(mesh_, hit, direction, at.normal, stream);
            next = drawn.ray;
            colour *= drawn.colour;
        } else {
            return;
        }
        if (!(colour > 0.0).any()) {
            return;
        }
        direction = next.direction;
        visibility_.first_hits(std::span(&next, 1), std::span(&hit, 1));
        sights.push_back({hit, direction, colour});
    }
}

} // namespace difusa
