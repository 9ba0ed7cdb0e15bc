// The rays of a camera through points of its picture.
#pragma once

#include <difusa/core/random.h>
#include <difusa/scene/camera.h>

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace difusa {

/// Points in a picture are (column, row) in pixels from its upper left corner: it covers [0, width] x [0, height].
class CameraRays {
  public:
    /// Throws std::invalid_argument if `up` is parallel to `towards`, either is zero, or the angle not in (0, pi).
    CameraRays(const Camera& camera, std::size_t width, std::size_t height);

    const Vec3& eye() const { return eye_; }

    /// Unit direction through a point of the picture.
    Vec3 direction(double column, double row) const;

    /// Where a point in space appears; nothing if it is beside or behind the eye.
    std::optional<std::array<double, 2>> place_of(const Vec3& point) const;

  private:
    Vec3 eye_, forward_;
    Vec3 across_, down_; ///< from the centre to the right and lower edges of the picture at distance 1
    double width_, height_;
};

/// k² points in the unit square, one in each cell of a k by k grid, and also one in each of k² columns and rows:
/// multi-jittered (Chiu, Shirley and Wang 1994) with one shuffle for all rows and one for all columns (Kensler 2013).
/// The share of them on one side of a vertical or horizontal line is accurate to 1 / k².
std::vector<std::array<double, 2>> jittered_places(std::size_t k, RandomStream& stream);

} // namespace difusa
