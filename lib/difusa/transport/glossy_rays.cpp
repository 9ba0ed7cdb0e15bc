#include <difusa/transport/glossy_rays.h>

namespace difusa {

GlossyRays::GlossyRays(const Mesh& mesh, const Surfels& surfels, std::span<const SurfacePoint> points)
    : surfels_(std::make_shared<GlossySurfels>(mesh, surfels)), keeps_all_(points.size(), 0), rays_(points.size()) {
    region_.reserve(points.size());
    normal_.reserve(points.size());
    for (std::size_t j = 0; j < points.size(); ++j) {
        region_.push_back(mesh.region[points[j].face]);
        normal_.push_back(points[j].normal);
        for (Index lobe = 0; lobe < mesh.glossy.lobes.size(); ++lobe) {
            keeps_all_[j] = keeps_all_[j] != 0 || reflects(lobe, j) ? 1 : 0;
        }
    }
}

std::size_t GlossyRays::bytes() const {
    std::size_t sum = points() * (sizeof(Index) + sizeof(Vec3) + sizeof(char) + sizeof(std::vector<Ray>));
    for (const std::vector<Ray>& rays : rays_) {
        sum += rays.size() * sizeof(Ray);
    }
    return sum;
}

} // namespace difusa
