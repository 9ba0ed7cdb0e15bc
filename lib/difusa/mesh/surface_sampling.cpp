#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace difusa {

std::vector<SurfacePoint> even_points(const Mesh& mesh, std::size_t count, RandomStream stream) {
    std::vector<double> below(mesh.areas.size());
    std::partial_sum(mesh.areas.begin(), mesh.areas.end(), below.begin());
    std::vector<SurfacePoint> points;
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double share = (static_cast<double>(i) + stream.uniform()) / static_cast<double>(count) * below.back();
        const auto place = std::upper_bound(below.begin(), below.end(), share);
        const auto face = static_cast<Index>(std::min<std::ptrdiff_t>(place - below.begin(), std::ssize(below) - 1));
        const double u = stream.uniform(), v = stream.uniform();
        points.push_back(uniform_point(mesh, face, u, v));
    }
    return points;
}

SurfacePoint inset(const Mesh& mesh, const SurfacePoint& x) {
    if (x.face == none) {
        return x;
    }
    // Well above the rounding of coordinates where the triangle is small relative to them.
    const double size = std::sqrt(mesh.areas[x.face]);
    const double least = std::min(0.25, std::max(0x1p-16, 0x1p-40 * mesh.magnitude() / size));
    const double nearest = std::min({x.u, x.v, 1.0 - x.u - x.v});
    if (nearest >= least) {
        return x;
    }
    const double step = (least - nearest) / (1.0 / 3.0 - nearest);
    SurfacePoint moved = mesh.at(x.face, x.u + step * (1.0 / 3.0 - x.u), x.v + step * (1.0 / 3.0 - x.v));
    moved.normal = x.normal;
    return moved;
}

} // namespace difusa
