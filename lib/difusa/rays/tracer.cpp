#include <difusa/rays/tracer.h>

#include <difusa/mesh/surface_sampling.h>

namespace difusa {

void Hemisphere::look(const SurfacePoint& x, std::size_t number) {
    const Mesh& mesh = tracer_.mesh();
    weights_ = pool_.rays(inset(mesh, x), number, rays_);
    const Vec3& n = x.face == none ? x.normal : mesh.normals[x.face];
    if (x.normal != n) {
        for (Ray& ray : rays_) {
            const double height = n.dot(ray.direction);
            ray.direction -= height < 0.0 ? Vec3(2.0 * height * n) : Vec3(Vec3::Zero());
        }
    }
    tracer_.first_hits(rays_, hits_);
}

} // namespace difusa
