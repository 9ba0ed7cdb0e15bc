#include <difusa/render/camera_rays.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace difusa {

CameraRays::CameraRays(const Camera& camera, std::size_t width, std::size_t height)
    : eye_(camera.eye), forward_(camera.towards.stableNormalized()), width_(static_cast<double>(width)),
      height_(static_cast<double>(height)) {
    const Vec3 right = forward_.cross(camera.up.stableNormalized());
    if (!(right.norm() > 1e-9) || !(camera.view_angle > 0.0 && camera.view_angle < std::numbers::pi)) {
        throw std::invalid_argument(
            "camera: needs a direction, an up vector not parallel to it, and an angle below 180 degrees");
    }
    const double half = std::tan(0.5 * camera.view_angle);
    across_ = half * width_ / height_ * right.normalized();
    down_ = half * forward_.cross(right).normalized();
}

Vec3 CameraRays::direction(double column, double row) const {
    return (forward_ + (2.0 * column / width_ - 1.0) * across_ + (2.0 * row / height_ - 1.0) * down_).normalized();
}

std::optional<std::array<double, 2>> CameraRays::place_of(const Vec3& point) const {
    const Vec3 way = point - eye_;
    const double depth = way.dot(forward_);
    if (!(depth > 0.0)) {
        return std::nullopt;
    }
    const double x = way.dot(across_) / (depth * across_.squaredNorm());
    const double y = way.dot(down_) / (depth * down_.squaredNorm());
    return std::array<double, 2>{0.5 * (x + 1.0) * width_, 0.5 * (y + 1.0) * height_};
}

std::vector<std::array<double, 2>> jittered_places(std::size_t k, RandomStream& stream) {
    const auto shuffled = [&] {
        std::vector<std::size_t> order(k);
        std::iota(order.begin(), order.end(), std::size_t{0});
        for (std::size_t i = k; i > 1; --i) {
            std::swap(order[i - 1], order[stream.below(i)]);
        }
        return order;
    };
    const std::vector<std::size_t> of_row = shuffled(), of_column = shuffled();
    const auto n = static_cast<double>(k);
    std::vector<std::array<double, 2>> places;
    places.reserve(k * k);
    for (std::size_t j = 0; j < k; ++j) {
        for (std::size_t i = 0; i < k; ++i) {
            const double x = (static_cast<double>(of_row[j]) + stream.uniform()) / n;
            const double y = (static_cast<double>(of_column[i]) + stream.uniform()) / n;
            places.push_back({(static_cast<double>(i) + x) / n, (static_cast<double>(j) + y) / n});
        }
    }
    return places;
}

} // namespace difusa
