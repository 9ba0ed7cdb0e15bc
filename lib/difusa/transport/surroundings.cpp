#include <difusa/transport/surroundings.h>

namespace difusa {

void Surroundings::look(const SurfacePoint& x, std::size_t number) {
    const std::span<const double> weight = pool_.rays(x, number, rays_);
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
    sky_ = back_ = 0.0;
    for (std::size_t d = 0; d < hits_.size(); ++d) {
        const Hit& hit = hits_[d];
        if (hit.face == none) {
            sky_ += weight[d];
        } else if (!hit.front) {
            back_ += weight[d];
        } else {
            points_.push_back(mesh_.at(hit.face, hit.u, hit.v));
            weights_.push_back(weight[d]);
        }
    }
}

} // namespace difusa
