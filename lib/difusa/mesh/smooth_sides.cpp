#include <difusa/mesh/smooth_sides.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>

namespace difusa {

Twins join_smooth_sides(const Mesh& mesh, double crease_angle) {
    Twins twin = mesh.twin;
    for (std::size_t s = 0; s < twin.size(); ++s) {
        const Index other = twin[s];
        if (other == none) {
            continue;
        }
        const std::size_t f = triangle_of(s), g = triangle_of(other);
        const Vec3 &n_f = mesh.normals[f], &n_g = mesh.normals[g];
        const double turn = std::atan2(n_f.cross(n_g).norm(), n_f.dot(n_g));
        if (mesh.region[f] != mesh.region[g] || turn > crease_angle) {
            twin[s] = twin[other] = none;
        }
    }
    return twin;
}

Twins part_materials(const Mesh& mesh, Twins twin) {
    const auto colour = [&](std::size_t corner) -> const Rgb& {
        return mesh.corner_reflectance[corner / 3][corner % 3];
    };
    for (std::size_t s = 0; s < twin.size(); ++s) {
        const std::size_t other = twin[s];
        if (other == none) {
            continue;
        }
        const bool same_colours = mesh.corner_reflectance.empty() || ((colour(s) == colour(after(other))).all() &&
                                                                      (colour(after(s)) == colour(other)).all());
        if (mesh.material[triangle_of(s)] != mesh.material[triangle_of(other)] || !same_colours) {
            twin[s] = twin[other] = none;
        }
    }
    return twin;
}

std::pair<std::vector<Index>, Index> number_fans(const Twins& twin) {
    std::vector<Index> fan(twin.size(), none);
    Index count = 0;
    for (std::size_t start = 0; start < twin.size(); ++start) {
        if (fan[start] != none) {
            continue;
        }
        const auto walk = [&](auto step) {
            for (std::size_t corner = step(start); corner != none && fan[corner] == none; corner = step(corner)) {
                fan[corner] = count;
            }
        };
        fan[start] = count;
        walk([&](std::size_t corner) -> std::size_t { return twin[before(corner)]; });
        walk([&](std::size_t corner) -> std::size_t { return twin[corner] == none ? none : after(twin[corner]); });
        ++count;
    }
    return {std::move(fan), count};
}

std::vector<Vec3> corner_normals(const Mesh& mesh, const Twins& smooth) {
    const auto [fan, count] = number_fans(smooth);
    std::vector<Vec3> sum(count, Vec3::Zero());
    std::vector<double> total(count, 0.0);
    for (std::size_t c = 0; c < fan.size(); ++c) {
        const Vec3& tip = mesh.points[point_at(mesh, c)];
        const Vec3 a = mesh.points[point_at(mesh, after(c))] - tip, b = mesh.points[point_at(mesh, before(c))] - tip;
        const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
        sum[fan[c]] += angle * mesh.normals[triangle_of(c)];
        total[fan[c]] += angle;
    }
    for (std::size_t i = 0; i < count; ++i) {
        // The remainder of a sum that cancels is rounding error with an arbitrary direction.
        const double length = sum[i].norm();
        sum[i] = length > 1e-9 * total[i] ? Vec3(sum[i] / length) : Vec3::Zero();
    }
    std::vector<Vec3> normals(fan.size());
    for (std::size_t c = 0; c < fan.size(); ++c) {
        normals[c] = sum[fan[c]];
    }
    return normals;
}

Vec3 shading_normal(const Mesh& mesh, const std::vector<Vec3>& corner_normals, Index face, double u, double v) {
    const std::size_t first = 3 * std::size_t{face};
    const Vec3 mean =
        (1.0 - u - v) * corner_normals[first] + u * corner_normals[first + 1] + v * corner_normals[first + 2];
    // A flat wall gets exactly the normal of its faces, not one that differs in the last place; and a normal leaving
    // the front of its own face would shade it from behind.
    const Vec3& face_normal = mesh.normals[face];
    const bool flat = (mean - face_normal).norm() <= 8.0 * std::numeric_limits<double>::epsilon();
    return !flat && mean.dot(face_normal) > 0.0 ? Vec3(mean.normalized()) : face_normal;
}

} // namespace difusa
