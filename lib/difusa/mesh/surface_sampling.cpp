#include <difusa/mesh/surface_sampling.h>

#include <difusa/mesh/smooth_sides.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

/// What of the plane of a triangle is around one of its corners: joined triangles of about the same normal.
struct FlatFan {
    std::vector<std::size_t> sides; ///< that leave the corner, one in each triangle, counterclockwise
    std::vector<double> angles;     ///< of the triangles
    double nearest = std::numeric_limits<double>::infinity(); ///< distance to the sides opposite the corner
};

bool is_flat(const Mesh& mesh, std::size_t side) {
    const Index other = mesh.twin[side];
    return other != none && (mesh.normals[triangle_of(side)] - mesh.normals[triangle_of(other)]).norm() <= same_normal;
}

/// `side`: the one that leaves the corner. No triangles if they are all around.
FlatFan fan_around(const Mesh& mesh, std::size_t side) {
    FlatFan fan;
    std::size_t at = side;
    while (is_flat(mesh, at)) {
        at = after(mesh.twin[at]); // clockwise
        if (at == side) {
            return fan;
        }
    }
    for (;; at = mesh.twin[before(at)]) { // counterclockwise
        const Vec3& p = mesh.points[mesh.triangles[triangle_of(at)][at % 3]];
        const Vec3 out = mesh.points[mesh.triangles[triangle_of(at)][after(at) % 3]] - p;
        const Vec3 in = mesh.points[mesh.triangles[triangle_of(at)][before(at) % 3]] - p;
        fan.sides.push_back(at);
        fan.angles.push_back(std::atan2(out.cross(in).norm(), out.dot(in)));
        fan.nearest = std::min(fan.nearest, out.cross(in).norm() / (in - out).norm());
        if (!is_flat(mesh, before(at))) {
            return fan;
        }
    }
}

/// How far inside a point has to be, as shares of the corners of a triangle, of which 0 is a side.
struct Margin {
    double edge, within_plane;

    /// Well above the rounding of coordinates, also where the triangle is small relative to them. Sides within a plane
    /// need no more, but the normals beside them may differ a little, so that rays must not start just on them.
    static Margin of(const Mesh& mesh, Index triangle) {
        const double rounding = 0x1p-40 * mesh.magnitude() / std::sqrt(mesh.areas[triangle]);
        return {std::min(0.25, std::max(0x1p-16, rounding)), std::min(0.25, std::max(0x1p-26, rounding))};
    }

    /// For the share of the corner opposite this side.
    double at(const Mesh& mesh, std::size_t side) const { return is_flat(mesh, side) ? within_plane : edge; }
};

/// On the bisector of the angle that the plane of a triangle has at one of its corners, `step` away from it: in the
/// triangle of the fan that the bisector leads to, and inside of it.
SurfacePoint on_bisector(const Mesh& mesh, const FlatFan& fan, double step) {
    double rest = 0.5 * std::accumulate(fan.angles.begin(), fan.angles.end(), 0.0);
    std::size_t k = 0;
    while (k + 1 < fan.sides.size() && rest > fan.angles[k]) {
        rest -= fan.angles[k++];
    }
    const std::size_t side = fan.sides[k];
    const auto t = static_cast<Index>(triangle_of(side));
    const Vec3& p = mesh.points[mesh.triangles[t][side % 3]];
    const Vec3 out = mesh.points[mesh.triangles[t][after(side) % 3]] - p;
    const Vec3 in = mesh.points[mesh.triangles[t][before(side) % 3]] - p;
    // The law of sines for the components along both sides.
    const double sine = std::sin(fan.angles[k]);
    const Margin margin = Margin::of(mesh, t);
    std::array<double, 3> share{};
    share[after(side) % 3] =
        std::max(step * std::sin(fan.angles[k] - rest) / (sine * out.norm()), margin.at(mesh, before(side)));
    share[before(side) % 3] = std::max(step * std::sin(rest) / (sine * in.norm()), margin.at(mesh, side));
    return mesh.at(t, share[1] + (side % 3 == 1 ? 1.0 - share[0] - share[2] : 0.0),
                   share[2] + (side % 3 == 2 ? 1.0 - share[0] - share[1] : 0.0));
}

} // namespace

SurfacePoint inset(const Mesh& mesh, const SurfacePoint& x) {
    if (x.face == none) {
        return x;
    }
    const std::size_t first = 3 * std::size_t{x.face};
    const Margin margin = Margin::of(mesh, x.face);
    const std::array<double, 3> share{1.0 - x.u - x.v, x.u, x.v}; // of each corner
    double step = 0.0;                                            // towards the centre
    for (std::size_t k = 0; k < 3; ++k) {
        const double least = margin.at(mesh, after(first + k)); // the side opposite corner k
        step = share[k] < least ? std::max(step, (least - share[k]) / (1.0 / 3.0 - share[k])) : step;
    }
    if (step == 0.0) {
        return x;
    }
    SurfacePoint moved = mesh.at(x.face, x.u + step * (1.0 / 3.0 - x.u), x.v + step * (1.0 / 3.0 - x.v));
    for (std::size_t k = 0; k < 3; ++k) {
        if (share[(k + 1) % 3] < margin.edge && share[(k + 2) % 3] < margin.edge) { // at corner k
            const FlatFan fan = fan_around(mesh, first + k);
            if (!fan.sides.empty()) {
                const Vec3& corner = mesh.corner(x.face, static_cast<Index>(k));
                const Vec3 centre = mesh.at(x.face, 1.0 / 3.0, 1.0 / 3.0).position;
                moved =
                    on_bisector(mesh, fan, std::min(3.0 * margin.edge * (centre - corner).norm(), 0.5 * fan.nearest));
            }
        }
    }
    moved.normal = x.normal;
    return moved;
}

} // namespace difusa
