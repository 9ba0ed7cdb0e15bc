// An image on a surface.
#pragma once

#include <difusa/mesh/mesh.h>
#include <difusa/scene/image.h>

#include <array>
#include <memory>

namespace difusa {

/// The placement of a texture on the surface: its coordinates are this times (u, v, 1) of the corners' u and v.
using TexturePlacement = Eigen::Matrix<double, 2, 3>;

/// Interpolated bilinearly between pixel centres.
class Texture {
  public:
    enum class Wrap { repeat, clamp, mirror }; ///< handling of coordinates outside [0,1]

    /// Throws std::invalid_argument for an empty image.
    explicit Texture(Image image, Wrap wrap_u = Wrap::repeat, Wrap wrap_v = Wrap::repeat);

    /// Several textures may share an image.
    Texture(std::shared_ptr<const Image> image, Wrap wrap_u, Wrap wrap_v, const TexturePlacement& placement);

    Rgb at(const TextureCoordinates& place) const;

    /// The coordinates on the image of a point with these on the surface.
    TextureCoordinates on_image(const TextureCoordinates& place) const {
        return placed_ ? TextureCoordinates(placement_ * place.homogeneous()) : place;
    }

    /// How many pixels a triangle with these corners shows, repeated ones included.
    double pixels(const std::array<TextureCoordinates, 3>& corners) const;

    /// True if the channels of every pixel are equal.
    bool is_grey() const { return grey_; }

    /// The largest value anywhere, per channel.
    const Rgb& brightest() const { return brightest_; }

    /// The mean over all pixels.
    Rgb mean() const;

  private:
    std::shared_ptr<const Image> image_;
    Wrap wrap_u_, wrap_v_;
    bool placed_ = false; ///< false: the placement changes nothing
    TexturePlacement placement_ = TexturePlacement::Identity();
    Rgb brightest_ = Rgb::Zero();
    bool grey_ = true;
};

} // namespace difusa
