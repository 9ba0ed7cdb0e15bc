// The skies available in a scene file.
#pragma once

#include <difusa/scene/image.h>
#include <difusa/scene/lights.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace difusa {

/// A sky that varies only with elevation: linear in the sine of the elevation from the horizon's radiance to the
/// zenith's, and the ground's radiance below. On unoccluded level ground it gives the irradiance pi (horizon + 2
/// zenith) / 3.
class GradientSky final : public SkyDome {
  public:
    /// Radiances in W/(m² sr), none negative; `up` is unit.
    GradientSky(const Rgb& zenith, const Rgb& horizon, const Rgb& ground, const Vec3& up);

    Rgb radiance(const Vec3& towards) const override;
    bool is_grey() const override;

  private:
    Rgb zenith_, horizon_, ground_;
    Vec3 up_;
};

/// Another sky, brighter or dimmer by a factor.
class ScaledSky final : public SkyDome {
  public:
    /// `factor`: not negative.
    ScaledSky(std::shared_ptr<const SkyDome> sky, double factor) : sky_(std::move(sky)), factor_(factor) {}

    Rgb radiance(const Vec3& towards) const override { return factor_ * sky_->radiance(towards); }
    bool is_grey() const override { return sky_->is_grey(); }

  private:
    std::shared_ptr<const SkyDome> sky_;
    double factor_;
};

/// An environment image in equirectangular (lat-long) layout: columns cover all azimuths, rows run from straight up to
/// straight down. The middle column is in the direction `ahead`, columns to its right are to the right of an observer
/// looking there. Interpolated bilinearly.
class ImageSky final : public SkyDome {
  public:
    /// Pixels times `scale` are radiances in W/(m² sr). `up` is unit; `ahead` is not parallel to it.
    /// Throws std::invalid_argument for an empty image, and for pixels that are negative or not finite.
    ImageSky(Image image, double scale, const Vec3& up, const Vec3& ahead);

    Rgb radiance(const Vec3& towards) const override;
    bool is_grey() const override;

    /// Features far brighter than the rest, above all a sun, would make the light of a few hundred rays noisy: removes
    /// them from the image and returns them as suns. A pixel is clipped where it exceeds `limit` > 0 times the mean
    /// radiance of the sphere; the excess of connected pixels, if they span no more than 0.01 sr, becomes one sun in
    /// the mean direction, with the irradiance they gave to a surface facing each of them. In a region that spans more,
    /// such as a sun with its halo, the threshold is doubled until it falls apart into such regions or has no pixel
    /// left: the sun takes the excess over its surroundings, and the image together with the suns gives the same light
    /// as the original image.
    std::vector<Sun> split_suns(double limit);

    /// The mean radiance of the sphere, over all channels, W/(m² sr).
    double mean() const;

    /// The solid angle of the pixels whose mean over the channels exceeds `radiance`, sr.
    double solid_angle_above(double radiance) const;

  private:
    /// Connected pixels, and the solid angle they span.
    struct Region {
        std::vector<std::size_t> pixels;
        double size;
    };
    Vec3 direction(double column, double row) const;
    double solid_angle(std::size_t row) const; ///< of a pixel
    double brightness(std::size_t pixel) const;
    /// The pixels above the threshold connected to `first` that have marks below `mark`, which they then get.
    Region region(std::size_t first, double threshold, std::uint16_t mark, std::vector<std::uint16_t>& marks) const;
    /// Removes the excess over the threshold from the image.
    Sun cut(const Region& region, double threshold);
    Image image_;
    Vec3 up_, ahead_, right_;
};

} // namespace difusa
