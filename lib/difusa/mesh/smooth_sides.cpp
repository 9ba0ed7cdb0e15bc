#include <difusa/mesh/smooth_sides.h>

#include <Eigen/Geometry>

#include <cmath>

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

Twins part_materials(const Mesh& mesh, Twins twin, const std::vector<char>& seams) {
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
        const bool seam = !seams.empty() && seams[s] != 0;
        if (mesh.material[triangle_of(s)] != mesh.material[triangle_of(other)] || !same_colours || seam) {
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

} // namespace difusa
