#include "surface.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace scenes {

std::size_t Surface::triangle_count() const {
    std::size_t count = 0;
    for (const Face& face : faces_) {
        count += face.corners.size() - 2;
    }
    return count;
}

unsigned Surface::add(Material material) {
    materials.push_back(std::move(material));
    return static_cast<unsigned>(materials.size() - 1);
}

unsigned Surface::point(const Vector& place) {
    // Adding 0 turns -0 into 0.
    const std::array<double, 3> key{place.x + 0.0, place.y + 0.0, place.z + 0.0};
    const auto [entry, is_new] = number_.try_emplace(key, static_cast<unsigned>(points_.size()));
    if (is_new) {
        points_.push_back({key[0], key[1], key[2]});
    }
    return entry->second;
}

void Surface::face(std::vector<unsigned> corners, unsigned material) {
    if (corners.size() < 3 || material >= materials.size()) {
        throw std::logic_error("a face needs three corners and a known material");
    }
    faces_.push_back({std::move(corners), material});
}

void Surface::polygon(const std::vector<Vector>& corners, unsigned material) {
    std::vector<unsigned> numbers;
    for (const Vector& corner : corners) {
        numbers.push_back(point(corner));
    }
    face(std::move(numbers), material);
}

void add_lattice_box(Surface& surface, const std::array<int, 3>& cells,
                     const std::function<Vector(int, int, int)>& place, const std::array<unsigned, 6>& material,
                     bool inward) {
    for (unsigned side = 0; side < 6; ++side) {
        const std::size_t axis = side / 2;
        const bool high = side % 2 == 1;
        // (axis, u, v) is right-handed for an outward front on the high side, left-handed on the low one.
        const std::size_t u = high != inward ? (axis + 1) % 3 : (axis + 2) % 3;
        const std::size_t v = 3 - axis - u;
        for (int j = 0; j < cells[v]; ++j) {
            for (int i = 0; i < cells[u]; ++i) {
                std::array<unsigned, 4> corner{};
                for (std::size_t k = 0; k < 4; ++k) {
                    std::array<int, 3> lattice{};
                    lattice[axis] = high ? cells[axis] : 0;
                    lattice[u] = i + (k == 1 || k == 2 ? 1 : 0);
                    lattice[v] = j + (k >= 2 ? 1 : 0);
                    corner[k] = surface.point(place(lattice[0], lattice[1], lattice[2]));
                }
                surface.face({corner[0], corner[1], corner[2]}, material[side]);
                surface.face({corner[0], corner[2], corner[3]}, material[side]);
            }
        }
    }
}

void add_box(Surface& surface, const Vector& low, const Vector& high, const std::array<int, 3>& cells,
             const std::array<unsigned, 6>& material, bool inward) {
    const auto between = [](double a, double b, int i, int n) {
        return i == n ? b : a + (b - a) * i / n; // the far end exactly, so that adjoining parts fit
    };
    add_lattice_box(
        surface, cells,
        [&](int i, int j, int k) {
            return Vector{between(low.x, high.x, i, cells[0]), between(low.y, high.y, j, cells[1]),
                          between(low.z, high.z, k, cells[2])};
        },
        material, inward);
}

void add_ball(Surface& surface, const Vector& centre, double radius, int n, unsigned material) {
    // The tangent makes equal steps on the cube equal angles from the centre.
    const auto spread = [n](int i) { return std::tan(std::numbers::pi / 4.0 * (2 * i - n) / n); };
    add_lattice_box(
        surface, {n, n, n},
        [&](int i, int j, int k) {
            const double x = spread(i), y = spread(j), z = spread(k);
            const double scale = radius / std::sqrt(x * x + y * y + z * z);
            return Vector{centre.x + scale * x, centre.y + scale * y, centre.z + scale * z};
        },
        {material, material, material, material, material, material}, false);
}

} // namespace scenes
