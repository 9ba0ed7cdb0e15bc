#include <difusa/scene/texture.h>

#include <difusa/core/colour.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace difusa {

namespace {

/// Two neighbouring pixels along one axis, and the weight of the second.
struct Neighbours {
    std::size_t first, second;
    double part;
};

std::size_t wrapped(double pixel, std::size_t count, Texture::Wrap wrap) {
    const auto n = static_cast<double>(count);
    switch (wrap) {
    case Texture::Wrap::repeat:
        pixel -= n * std::floor(pixel / n);
        break;
    case Texture::Wrap::clamp:
        break;
    case Texture::Wrap::mirror:
        pixel -= 2.0 * n * std::floor(pixel / (2.0 * n));
        pixel = pixel < n ? pixel : 2.0 * n - 1.0 - pixel;
        break;
    }
    return pixel > 0.0 ? static_cast<std::size_t>(std::min(pixel, n - 1.0)) : 0; // NaN: any pixel, with a weight of NaN
}

Neighbours neighbours(double place, std::size_t count, Texture::Wrap wrap) {
    const double at = place * static_cast<double>(count) - 0.5, pixel = std::floor(at);
    return {wrapped(pixel, count, wrap), wrapped(pixel + 1.0, count, wrap), at - pixel};
}

} // namespace

Texture::Texture(Image image, Wrap wrap_u, Wrap wrap_v)
    : Texture(std::make_shared<const Image>(std::move(image)), wrap_u, wrap_v, TexturePlacement::Identity()) {}

Texture::Texture(std::shared_ptr<const Image> image, Wrap wrap_u, Wrap wrap_v, const TexturePlacement& placement)
    : image_(std::move(image)), wrap_u_(wrap_u), wrap_v_(wrap_v), placed_(placement != TexturePlacement::Identity()),
      placement_(placement) {
    if (!image_ || image_->pixels.empty() || image_->pixels.size() != image_->width * image_->height) {
        throw std::invalid_argument("a texture needs an image with pixels");
    }
    for (const std::array<float, 3>& pixel : image_->pixels) {
        brightest_ = brightest_.max(rgb_of(pixel));
        grey_ = grey_ && equal_channels(rgb_of(pixel));
    }
}

Rgb Texture::at(const TextureCoordinates& coordinates) const {
    const TextureCoordinates place = on_image(coordinates);
    const Neighbours u = neighbours(place[0], image_->width, wrap_u_);
    const Neighbours v = neighbours(1.0 - place[1], image_->height, wrap_v_); // rows run downwards
    const auto along = [&](std::size_t row) -> Rgb {
        return (1.0 - u.part) * rgb_of(image_->at(u.first, row)) + u.part * rgb_of(image_->at(u.second, row));
    };
    return (1.0 - v.part) * along(v.first) + v.part * along(v.second);
}

double Texture::pixels(const std::array<TextureCoordinates, 3>& corners) const {
    const TextureCoordinates a = on_image(corners[0]), b = on_image(corners[1]) - a, c = on_image(corners[2]) - a;
    return 0.5 * std::abs(b[0] * c[1] - b[1] * c[0]) * static_cast<double>(image_->width) *
           static_cast<double>(image_->height);
}

Rgb Texture::mean() const {
    Rgb sum = Rgb::Zero();
    for (const std::array<float, 3>& pixel : image_->pixels) {
        sum += rgb_of(pixel);
    }
    return sum / static_cast<double>(image_->pixels.size());
}

} // namespace difusa
