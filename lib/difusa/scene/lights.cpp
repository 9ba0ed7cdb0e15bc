#include <difusa/scene/lights.h>

#include <numbers>

namespace difusa {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;

} // namespace

Vec3 Sun::towards_disc(const std::array<double, 2>& place) const {
    const double radius = disc * std::sqrt(place[0]), azimuth = turn * place[1];
    const Vec3 across = towards.unitOrthogonal(), other = towards.cross(across);
    return std::sqrt(1.0 - radius * radius) * towards +
           radius * (std::cos(azimuth) * across + std::sin(azimuth) * other);
}

Vec3 PointLight::place(const std::array<double, 2>& uv) const {
    if (is_round) {
        const double radius = std::sqrt(uv[0]), azimuth = turn * uv[1];
        return position + half_length * radius * std::cos(azimuth) * c0 + half_width * radius * std::sin(azimuth) * c90;
    }
    return position + half_length * (2.0 * uv[0] - 1.0) * c0 + half_width * (2.0 * uv[1] - 1.0) * c90;
}

double PointLight::mean_kernel(const Vec3& x, const Vec3& n) const {
    if (!is_extended()) {
        return kernel(position, x, n);
    }
    constexpr double most = 48.0;
    constexpr std::array<double, 3> node{0.11270166537925831, 0.5, 0.88729833462074169},
        weight{5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0};
    const Vec3 way = x - position;
    const auto beyond = [](double at, double half) { return std::max(0.0, std::abs(at) - half); };
    const double distance =
        Vec3(beyond(way.dot(c0), half_length), beyond(way.dot(c90), half_width), way.dot(direction)).norm();
    const auto parts = [&](double size) {
        return std::clamp(std::ceil(2.0 * size / std::max(distance, 1e-300)), 2.0, most);
    };
    // Rectangles: along c0 and c90. Ellipses: along the radius and around.
    const double size = 2.0 * std::max(half_length, half_width);
    const double across = is_round ? parts(0.5 * size) : parts(2.0 * half_length);
    const double around = is_round ? std::max(4.0, parts(0.5 * turn * size)) : parts(2.0 * half_width);
    double sum = 0.0;
    for (double i = 0.0; i < across; ++i) {
        for (double j = 0.0; j < around; ++j) {
            for (std::size_t k = 0; k < 9; ++k) {
                const double u = (i + node[k / 3]) / across, v = (j + node[k % 3]) / around;
                const Vec3 from = place({is_round ? u * u : u, v});
                sum += weight[k / 3] * weight[k % 3] * (is_round ? 2.0 * u : 1.0) * kernel(from, x, n);
            }
        }
    }
    return sum / (across * around);
}

} // namespace difusa
