#include <difusa/lighting/lambert.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

double lambert_sum(const Vec3& n, std::span<const Vec3> polygon) {
    double sum = 0.0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 &from = polygon[k], &to = polygon[k + 1 < polygon.size() ? k + 1 : 0];
        // Seen from x the front runs clockwise. Written as to × from, the direction would be lost to rounding for an
        // edge that is far away and short.
        const Vec3 cross = (to - from).cross(from);
        const double length = cross.norm();
        if (length > 0.0) {
            sum += std::atan2(length, from.dot(to)) * n.dot(cross) / length;
        }
    }
    return std::max(0.0, sum / (2.0 * std::numbers::pi));
}

double lambert_form_factor(const Vec3& x, const Vec3& n, const Vec3& a, const Vec3& b, const Vec3& c) {
    const std::array<Vec3, 3> p{a - x, b - x, c - x};
    if (p[0].dot((p[1] - p[0]).cross(p[2] - p[0])) >= 0.0) {
        return 0.0; // seen from behind, or edge-on
    }
    // Clipped to n·p >= 0: at most four corners remain.
    std::array<Vec3, 4> polygon;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &from = p[k], &to = p[(k + 1) % 3];
        const double from_height = n.dot(from), to_height = n.dot(to);
        if (from_height >= 0.0) {
            polygon[count++] = from;
        }
        if ((from_height > 0.0 && to_height < 0.0) || (from_height < 0.0 && to_height > 0.0)) {
            const double part = from_height / (from_height - to_height);
            polygon[count++] = from + part * (to - from);
        }
    }
    return lambert_sum(n, {polygon.data(), count});
}

} // namespace difusa
