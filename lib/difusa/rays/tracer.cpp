#include <difusa/rays/tracer.h>

namespace difusa {

void Sight::lift(const SurfacePoint& x) {
    const Vec3& n = tracer_.mesh().face_normal(x);
    if (x.normal != n) {
        for (Ray& ray : rays_) {
            const double height = n.dot(ray.direction);
            ray.direction -= height < 0.0 ? Vec3(2.0 * height * n) : Vec3(Vec3::Zero());
        }
    }
}

void Sight::cast(RandomStream* stream) {
    hits_.resize(rays_.size());
    tracer_.first_hits(rays_, hits_);
    reflected_.clear();
    glossy_hits_.clear();
    if (tracer_.mesh().mirrors.any() || (stream != nullptr && tracer_.mesh().glossy.any())) {
        follow_reflections(stream);
    }
}

/// Adds the ray, or rays, that go on from a hit.
void Sight::reflect(const Hit& hit, const Vec3& direction, double weight, const Rgb& colour, RandomStream* stream) {
    const Mesh& mesh = tracer_.mesh();
    if (hit.face == none || !hit.front) {
        return;
    }
    const auto go_on = [&](const Ray& ray, const Rgb& left) {
        if ((left > 0.0).any()) {
            reflected_rays_.push_back(ray);
            reflected_.push_back({{}, ray.direction, weight, left});
        }
    };
    if (const Index kind = mesh.mirrors.kind(hit.face); kind != none) {
        go_on(reflected_ray(mesh, hit, direction), colour * mesh.mirrors.reflectance[kind]);
    }
    if (const Index kind = stream != nullptr ? mesh.glossy.kind(hit.face) : none; kind != none) {
        glossy_hits_.push_back({hit, direction, weight, colour * mesh.glossy.kinds[kind].reflectance});
        const DrawnRay drawn = drawn_ray(mesh, hit, direction, mesh.normals[hit.face], *stream);
        go_on(drawn.ray, colour * drawn.colour);
    }
}

/// One generation after another: the rays that are reflected are cast on from there together.
void Sight::follow_reflections(RandomStream* stream) {
    reflected_rays_.clear();
    for (std::size_t d = 0; d < hits_.size(); ++d) {
        reflect(hits_[d], rays_[d].direction, weights_[d], Rgb::Ones(), stream);
    }
    std::size_t first = 0;
    for (std::size_t generation = 1; first < reflected_.size(); ++generation) {
        const std::size_t end = reflected_.size();
        if (generation > tracer_.mesh().mirrors.most) {
            for (std::size_t k = first; k < end; ++k) {
                reflected_[k].cut_off = true;
            }
            return;
        }
        reflected_hits_.resize(reflected_rays_.size());
        tracer_.first_hits(reflected_rays_, reflected_hits_);
        reflected_rays_.clear();
        for (std::size_t k = first; k < end; ++k) {
            reflected_[k].hit = reflected_hits_[k - first];
            const ReflectedHit now = reflected_[k]; // the list grows
            reflect(now.hit, now.direction, now.weight, now.colour, stream);
        }
        first = end;
    }
}

} // namespace difusa
