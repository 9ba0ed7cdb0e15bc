#include <difusa/mesh/surface_sampling.h>

#include <difusa/mesh/smooth_sides.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
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

namespace {

/// What of the plane of a triangle is around one of its corners: the joined triangles in that plane.
struct FlatFan {
    Vec3 first = Vec3::Zero(); ///< unit, along the side where it begins, counterclockwise
    double angle = 0.0;        ///< from there to where it ends
    double nearest = 0.0;      ///< distance to the nearest side opposite the corner
    bool is_whole = false;     ///< it is all around
};

bool is_flat(const Mesh& mesh, std::size_t side) {
    const Index other = mesh.twin[side];
    return other != none && (mesh.normals[side / 3] - mesh.normals[other / 3]).norm() <= same_normal;
}

/// The side that leaves the same point in the next triangle, clockwise, across the side that leaves it; likewise
/// counterclockwise, across the one that arrives there.
std::size_t clockwise(const Mesh& mesh, std::size_t side) {
    const std::size_t twin = mesh.twin[side];
    return twin - twin % 3 + (twin + 1) % 3;
}
std::size_t arriving(std::size_t side) {
    return side - side % 3 + (side + 2) % 3;
}

/// `side`: the one that leaves the corner.
FlatFan fan_around(const Mesh& mesh, std::size_t side) {
    FlatFan fan;
    std::size_t begin = side;
    for (std::size_t steps = 0; is_flat(mesh, begin) && steps < mesh.triangles.size(); ++steps) {
        begin = clockwise(mesh, begin);
        if (begin == side) {
            fan.is_whole = true;
            return fan;
        }
    }
    for (std::size_t at = begin;;) {
        const auto t = static_cast<Index>(at / 3), k = static_cast<Index>(at % 3);
        const Vec3& p = mesh.corner(t, k);
        const Vec3 out = mesh.corner(t, (k + 1) % 3) - p, in = mesh.corner(t, (k + 2) % 3) - p;
        const double height = 2.0 * mesh.areas[t] / (in - out).norm();
        fan.nearest = at == begin ? height : std::min(fan.nearest, height);
        fan.first = at == begin ? out.normalized() : fan.first;
        fan.angle += std::atan2(out.cross(in).norm(), out.dot(in));
        if (!is_flat(mesh, arriving(at)) || fan.angle > 2.0 * std::numbers::pi) {
            return fan;
        }
        at = mesh.twin[arriving(at)];
    }
}

/// x moved in the plane of its face to `position`, which may lie just outside of the face, in another one of the plane.
SurfacePoint moved_to(const Mesh& mesh, const SurfacePoint& x, const Vec3& position) {
    const auto [a, b, c] = mesh.corners(x.face);
    const Vec3 along = position - a, ab = b - a, ac = c - a, n = ab.cross(ac) / ab.cross(ac).squaredNorm();
    SurfacePoint moved = x;
    moved.position = position;
    moved.u = std::clamp(n.dot(along.cross(ac)), 0.0, 1.0);
    moved.v = std::clamp(n.dot(ab.cross(along)), 0.0, 1.0 - moved.u);
    return moved;
}

} // namespace

SurfacePoint inset(const Mesh& mesh, const SurfacePoint& x) {
    if (x.face == none) {
        return x;
    }
    // Well above the rounding of coordinates where the triangle is small relative to them.
    const double size = std::sqrt(mesh.areas[x.face]);
    const double least = std::min(0.25, std::max(0x1p-16, 0x1p-40 * mesh.magnitude() / size));
    const std::array<double, 3> share{1.0 - x.u - x.v, x.u, x.v}; // of each corner
    for (std::size_t k = 0; k < 3; ++k) {
        if (share[(k + 1) % 3] < least && share[(k + 2) % 3] < least) { // at corner k
            const FlatFan fan = fan_around(mesh, 3 * std::size_t{x.face} + k);
            if (fan.is_whole) {
                return x;
            }
            const Vec3& corner = mesh.corner(x.face, static_cast<Index>(k));
            const Vec3 centre = (mesh.corner(x.face, 0) + mesh.corner(x.face, 1) + mesh.corner(x.face, 2)) / 3.0;
            const Vec3 across = mesh.normals[x.face].cross(fan.first);
            const double step = std::min(3.0 * least * (centre - corner).norm(), 0.5 * fan.nearest);
            return moved_to(
                mesh, x, corner + step * (std::cos(0.5 * fan.angle) * fan.first + std::sin(0.5 * fan.angle) * across));
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t side = 3 * std::size_t{x.face} + (k + 1) % 3; // opposite corner k
        if (share[k] < least && !is_flat(mesh, side)) {
            const Vec3& a = mesh.corner(x.face, static_cast<Index>((k + 1) % 3));
            const Vec3 along = mesh.corner(x.face, static_cast<Index>((k + 2) % 3)) - a;
            const double height = 2.0 * mesh.areas[x.face] / along.norm();
            const Vec3 inwards = mesh.normals[x.face].cross(along).normalized();
            return moved_to(mesh, x, x.position + (least - share[k]) * height * inwards);
        }
    }
    return x;
}

} // namespace difusa
