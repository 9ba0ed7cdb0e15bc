#include <difusa/rays/tracer.h>

namespace difusa {

void Sight::lift(const SurfacePoint& x) {
    const Vec3& n = x.face == none ? x.normal : tracer_.mesh().normals[x.face];
    if (x.normal != n) {
        for (Ray& ray : rays_) {
            const double height = n.dot(ray.direction);
            ray.direction -= height < 0.0 ? Vec3(2.0 * height * n) : Vec3(Vec3::Zero());
        }
    }
}

void Sight::cast() {
    hits_.resize(rays_.size());
    tracer_.first_hits(rays_, hits_);
    reflected_.clear();
    if (tracer_.mesh().mirrors.any()) {
        follow_reflections();
    }
}

/// One generation after another: the rays that meet a mirror are cast on from it together.
void Sight::follow_reflections() {
    const Mesh& mesh = tracer_.mesh();
    const Mirrors& mirrors = mesh.mirrors;
    const auto reflect = [&](const Hit& hit, const Vec3& direction, double weight, const Rgb& colour) {
        const Index kind = hit.face != none && hit.front ? mirrors.kind(hit.face) : none;
        if (kind != none && (colour * mirrors.reflectance[kind] > 0.0).any()) {
            reflected_rays_.push_back(reflected_ray(mesh, hit, direction));
            reflected_.push_back({{}, reflected_rays_.back().direction, weight, colour * mirrors.reflectance[kind]});
        }
    };
    reflected_rays_.clear();
    for (std::size_t d = 0; d < hits_.size(); ++d) {
        reflect(hits_[d], rays_[d].direction, weights_[d], Rgb::Ones());
    }
    std::size_t first = 0;
    for (std::size_t generation = 1; first < reflected_.size(); ++generation) {
        const std::size_t end = reflected_.size();
        if (generation > mirrors.most) {
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
            reflect(now.hit, now.direction, now.weight, now.colour);
        }
        first = end;
    }
}

} // namespace difusa
