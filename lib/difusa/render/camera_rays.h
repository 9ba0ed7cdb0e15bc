// Where a camera looks through each place of its picture.
#pragma once

#include <difusa/core/random.h>
#include <difusa/scene/camera.h>

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace difusa {

/// Places in a picture are (column, row) in pixels from its upper left corner: it covers [0, width] x [0, height].
class CameraRays {
  public:
    /// Throws std::invalid_argument if `up` is parallel to `towards`, either is zero, or the angle not in (0, pi).
    CameraRays(const Camera& camera, std::size_t width, std::size_t height);

    const Vec3& eye() const { return eye_; }

    /// Unit, through a place of the picture.
    Vec3 direction(double column, double row) const;

    /// Where a point of space is seen; nothing if it is beside or behind the eye.
    std::optional<std::array<double, 2>> place_of(const Vec3& point) const;

  private:
    Vec3 eye_, forward_;
    Vec3 across_, down_; ///< from the middle to the right and lower edge of the picture at distance 1
    double width_, height_;
};

/// k² places in the unit square, one in each cell of a grid of k by k, and also one in each of k² columns and rows:
/// multi-jittered (Chiu, Shirley and Wang 1994) with one shuffle for all rows and one for all columns (Kensler 2013).
/// The share of them on one side of a vertical or horizontal line is right to 1 / k².
std::vector<std::array<double, 2>> jittered_places(std::size_t k, RandomStream& stream);

} // namespace difusa
