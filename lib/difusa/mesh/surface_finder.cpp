#include <difusa/mesh/surface_finder.h>

namespace difusa {

std::optional<SurfaceFinder::Found> SurfaceFinder::nearest(const Vec3& position, const Vec3& normal) const {
    // Which of two faces at an edge is meant shows at any point that is off the surface by more than rounding.
    const double ahead = 1e-4 * mesh_.diameter();
    const NearestSurface::Place place = surface_.nearest({position, normal, position + ahead * normal});
    if (place.triangle == none) {
        return std::nullopt;
    }
    return Found{mesh_.at(place.triangle, place.weight[1], place.weight[2]), place.distance};
}

} // namespace difusa
