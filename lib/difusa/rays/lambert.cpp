#include <difusa/rays/lambert.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

double lambert_edge(const Vec3& n, const Vec3& from, const Vec3& to) {
    // Seen from x the front runs clockwise. Written as to × from, the direction would be lost to rounding for an edge
    // that is far away and short.
    const Vec3 cross = (to - from).cross(from);
    const double length = cross.norm();
    return length > 0.0 ? std::atan2(length, from.dot(to)) * n.dot(cross) / length / (2.0 * std::numbers::pi) : 0.0;
}

double lambert_sum(const Vec3& n, std::span<const Vec3> polygon) {
    double sum = 0.0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        sum += lambert_edge(n, polygon[k], polygon[k + 1 < polygon.size() ? k + 1 : 0]);
    }
    return std::max(0.0, sum);
}

double lambert_form_factor(const Vec3& x, const Vec3& n, const Vec3& a, const Vec3& b, const Vec3& c) {
    const std::array<Vec3, 3> triangle{a, b, c};
    return lambert_form_factor(x, n, triangle);
}

double lambert_form_factor(const Vec3& x, const Vec3& n, std::span<const Vec3> polygon) {
    DIFUSA_REQUIRE(polygon.size() >= 3 && polygon.size() <= most_lambert_corners);
    Vec3 normal = Vec3::Zero();
    for (std::size_t k = 2; k < polygon.size(); ++k) {
        normal += (polygon[k - 1] - polygon[0]).cross(polygon[k] - polygon[0]);
    }
    if ((polygon[0] - x).dot(normal) >= 0.0) {
        return 0.0; // seen from behind, or edge-on
    }
    // Clipped to n·p >= 0, which adds a corner at most.
    std::array<Vec3, most_lambert_corners + 1> seen;
    std::size_t count = 0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 from = polygon[k] - x, to = polygon[k + 1 < polygon.size() ? k + 1 : 0] - x;
        const double from_height = n.dot(from), to_height = n.dot(to);
        if (from_height >= 0.0) {
            seen[count++] = from;
        }
        if ((from_height > 0.0 && to_height < 0.0) || (from_height < 0.0 && to_height > 0.0)) {
            const double part = from_height / (from_height - to_height);
            seen[count++] = from + part * (to - from);
        }
    }
    return lambert_sum(n, {seen.data(), count});
}

} // namespace difusa
