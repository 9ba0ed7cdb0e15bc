#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace difusa {

TriangleSampler::TriangleSampler(const Mesh& mesh, std::span<const Index> triangles)
    : mesh_(mesh), triangles_(triangles) {
    below_.reserve(triangles.size());
    double sum = 0.0;
    for (const Index t : triangles) {
        below_.push_back(sum += mesh.areas[t]);
    }
}

SurfacePoint TriangleSampler::at(double share, double u, double v) const {
    const auto place = std::upper_bound(below_.begin(), below_.end(), share * area());
    const auto k = std::min<std::ptrdiff_t>(place - below_.begin(), std::ssize(below_) - 1);
    return uniform_point(mesh_, triangles_[static_cast<std::size_t>(k)], u, v);
}

std::vector<SurfacePoint> even_points(const Mesh& mesh, std::size_t count, RandomStream stream) {
    std::vector<Index> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), Index{0});
    const TriangleSampler sampler(mesh, all);
    std::vector<SurfacePoint> points;
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double share = (static_cast<double>(i) + stream.uniform()) / static_cast<double>(count);
        const double u = stream.uniform(), v = stream.uniform();
        points.push_back(mesh.shaded(sampler.at(share, u, v)));
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
