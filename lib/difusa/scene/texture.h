// A picture on a surface.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/image.h>

namespace difusa {

/// Where texture coordinates point in a picture: (0, 0) is its lower left corner, (1, 1) its upper right one.
using TextureCoordinates = Eigen::Vector2d;

/// Interpolated bilinearly between the centres of pixels.
class Texture {
  public:
    enum class Wrap { repeat, clamp, mirror }; ///< what lies outside of [0,1]

    /// Throws std::invalid_argument for an empty image.
    explicit Texture(Image image, Wrap wrap_u = Wrap::repeat, Wrap wrap_v = Wrap::repeat);

    Rgb at(const TextureCoordinates& place) const;

    /// True if the channels of every pixel are equal.
    bool is_grey() const { return grey_; }

    /// The brightest any place can be, in each channel.
    const Rgb& brightest() const { return brightest_; }

  private:
    Image image_;
    Wrap wrap_u_, wrap_v_;
    Rgb brightest_ = Rgb::Zero();
    bool grey_ = true;
};

} // namespace difusa
