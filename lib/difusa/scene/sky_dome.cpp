#include <difusa/scene/sky_dome.h>

#include <difusa/core/colour.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace difusa {

GradientSky::GradientSky(const Rgb& zenith, const Rgb& horizon, const Rgb& ground, const Vec3& up)
    : zenith_(zenith), horizon_(horizon), ground_(ground), up_(up) {}

Rgb GradientSky::radiance(const Vec3& towards) const {
    const double sine = up_.dot(towards);
    return sine < 0.0 ? ground_ : Rgb(horizon_ + sine * (zenith_ - horizon_));
}

bool GradientSky::is_grey() const {
    return equal_channels(zenith_) && equal_channels(horizon_) && equal_channels(ground_);
}

ImageSky::ImageSky(Image image, double scale, const Vec3& up, const Vec3& ahead)
    : image_(std::move(image)), up_(up), ahead_((ahead - ahead.dot(up) * up).normalized()), right_(ahead_.cross(up_)) {
    if (image_.pixels.empty() || image_.pixels.size() != image_.width * image_.height) {
        throw std::invalid_argument("the image of a sky has no pixels");
    }
    for (std::array<float, 3>& pixel : image_.pixels) {
        for (float& channel : pixel) {
            channel *= static_cast<float>(scale);
            if (!(channel >= 0.0F) || !std::isfinite(channel)) {
                throw std::invalid_argument("the image of a sky has pixels that are negative or not finite");
            }
        }
    }
}

Vec3 ImageSky::direction(double column, double row) const {
    const double azimuth = (column / static_cast<double>(image_.width) - 0.5) * 2.0 * std::numbers::pi;
    const double polar = row / static_cast<double>(image_.height) * std::numbers::pi;
    return std::cos(polar) * up_ + std::sin(polar) * (std::cos(azimuth) * ahead_ + std::sin(azimuth) * right_);
}

Rgb ImageSky::radiance(const Vec3& towards) const {
    const double azimuth = std::atan2(towards.dot(right_), towards.dot(ahead_));
    const double polar = std::acos(std::clamp(towards.dot(up_), -1.0, 1.0));
    const auto width = static_cast<std::int64_t>(image_.width), height = static_cast<std::int64_t>(image_.height);
    const double column = (azimuth / (2.0 * std::numbers::pi) + 0.5) * static_cast<double>(width) - 0.5;
    const double row = polar / std::numbers::pi * static_cast<double>(height) - 0.5;
    const double left = std::floor(column), top = std::floor(row);
    const auto pixel = [&](std::int64_t i, std::int64_t j) {
        return rgb_of(image_.at(static_cast<std::size_t>((i % width + width) % width),
                                static_cast<std::size_t>(std::clamp<std::int64_t>(j, 0, height - 1))));
    };
    const auto i = static_cast<std::int64_t>(left), j = static_cast<std::int64_t>(top);
    const auto along = [&](std::int64_t at) -> Rgb {
        return (1.0 - (column - left)) * pixel(i, at) + (column - left) * pixel(i + 1, at);
    };
    return (1.0 - (row - top)) * along(j) + (row - top) * along(j + 1);
}

bool ImageSky::is_grey() const {
    return std::all_of(image_.pixels.begin(), image_.pixels.end(),
                       [](const std::array<float, 3>& p) { return equal_channels(rgb_of(p)); });
}

double ImageSky::solid_angle(std::size_t row) const {
    const double step = std::numbers::pi / static_cast<double>(image_.height);
    return 2.0 * std::numbers::pi / static_cast<double>(image_.width) *
           (std::cos(static_cast<double>(row) * step) - std::cos(static_cast<double>(row + 1) * step));
}

double ImageSky::mean() const {
    double mean = 0.0;
    for (std::size_t row = 0; row < image_.height; ++row) {
        for (std::size_t column = 0; column < image_.width; ++column) {
            mean += rgb_of(image_.at(column, row)).mean() * solid_angle(row) / (4.0 * std::numbers::pi);
        }
    }
    return mean;
}

double ImageSky::solid_angle_above(double radiance) const {
    double sum = 0.0;
    for (std::size_t at = 0; at < image_.pixels.size(); ++at) {
        sum += brightness(at) > radiance ? solid_angle(at / image_.width) : 0.0;
    }
    return sum;
}

double ImageSky::brightness(std::size_t pixel) const {
    return rgb_of(image_.pixels[pixel]).mean();
}

ImageSky::Region ImageSky::region(std::size_t first, double threshold, std::uint16_t mark,
                                  std::vector<std::uint16_t>& marks) const {
    const std::size_t width = image_.width, height = image_.height;
    Region result{{first}, 0.0};
    marks[first] = mark;
    for (std::size_t next_of = 0; next_of < result.pixels.size(); ++next_of) {
        const std::size_t at = result.pixels[next_of], column = at % width, row = at / width;
        result.size += solid_angle(row);
        for (int side = 0; side < 4; ++side) {
            if ((side == 2 && row == 0) || (side == 3 && row + 1 == height)) {
                continue;
            }
            const std::size_t next = side == 0   ? row * width + (column + 1) % width
                                     : side == 1 ? row * width + (column + width - 1) % width
                                     : side == 2 ? at - width
                                                 : at + width;
            if (marks[next] < mark && brightness(next) > threshold) {
                marks[next] = mark;
                result.pixels.push_back(next);
            }
        }
    }
    return result;
}

Sun ImageSky::cut(const Region& region, double threshold) {
    Rgb irradiance = Rgb::Zero();
    Vec3 towards = Vec3::Zero();
    for (const std::size_t at : region.pixels) {
        const std::size_t column = at % image_.width, row = at / image_.width;
        const Rgb bright = rgb_of(image_.pixels[at]);
        const double kept = threshold / bright.mean();
        const Rgb taken = (1.0 - kept) * bright * solid_angle(row);
        irradiance += taken;
        towards += taken.mean() * direction(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
        for (float& channel : image_.pixels[at]) {
            channel *= static_cast<float>(kept);
        }
    }
    return {towards.normalized(), irradiance, "sky", true};
}

std::vector<Sun> ImageSky::split_suns(double limit) {
    constexpr double largest_sun = 0.01; // sr: 6.5 degrees across
    const double threshold = limit * mean();
    std::vector<Sun> suns;
    if (!(threshold > 0.0)) {
        return suns;
    }
    // Regions above the threshold times 2^level that lie within too large ones above half of it; a pixel's mark is one
    // more than the highest level at which its region is known.
    struct Step {
        std::vector<std::size_t> pixels;
        std::uint16_t level;
    };
    std::vector<std::uint16_t> marks(image_.pixels.size(), 0);
    std::vector<Step> open;
    for (std::size_t first = 0; first < image_.pixels.size(); ++first) {
        if (marks[first] == 0 && brightness(first) > threshold) {
            open.push_back({{first}, 0});
        }
        while (!open.empty()) {
            const Step step = std::move(open.back());
            open.pop_back();
            const double raised = std::ldexp(threshold, step.level);
            const auto mark = static_cast<std::uint16_t>(step.level + 1);
            for (const std::size_t seed : step.pixels) {
                if (marks[seed] >= mark || !(brightness(seed) > raised)) {
                    continue;
                }
                Region found = region(seed, raised, mark, marks);
                if (found.size <= largest_sun) {
                    suns.push_back(cut(found, raised));
                } else {
                    open.push_back({std::move(found.pixels), mark});
                }
            }
        }
    }
    return suns;
}

} // namespace difusa
