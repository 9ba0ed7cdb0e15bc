#include <difusa/rays/surroundings.h>

#include <difusa/mesh/surface_sampling.h>

#include <numbers>

namespace difusa {

void Surroundings::look(const SurfacePoint& x, std::size_t number) {
    const std::span<const double> weight = pool_.rays(inset(mesh_, x), number, rays_);
    const Vec3& n = mesh_.normals[x.face];
    if (x.normal != n) {
        for (Ray& ray : rays_) {
            const double height = n.dot(ray.direction);
            ray.direction -= height < 0.0 ? Vec3(2.0 * height * n) : Vec3(Vec3::Zero());
        }
    }
    visibility_.first_hits(rays_, hits_);
    points_.clear();
    weights_.clear();
    escaped_.clear();
    escaped_weights_.clear();
    sky_ = back_ = 0.0;
    for (std::size_t d = 0; d < hits_.size(); ++d) {
        const Hit& hit = hits_[d];
        if (hit.face == none) {
            sky_ += weight[d];
            escaped_.push_back(rays_[d].direction);
            escaped_weights_.push_back(weight[d]);
        } else if (!hit.front) {
            back_ += weight[d];
        } else {
            points_.push_back(mesh_.at(hit.face, hit.u, hit.v));
            weights_.push_back(weight[d]);
        }
    }
}

Rgb dome_irradiance(const Scene& scene, const Surroundings& around) {
    Rgb sum = Rgb::Zero();
    for (std::size_t d = 0; scene.dome && d < around.escaped().size(); ++d) {
        sum += around.escaped_weights()[d] * scene.dome->radiance(around.escaped()[d]);
    }
    return std::numbers::pi * sum;
}

} // namespace difusa
