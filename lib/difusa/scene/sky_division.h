// The sky in parts: the 145 of Tregenza (P. Tregenza, "Subdivision of the sky hemisphere for luminance measurements",
// Lighting Research and Technology 19, 1987) and Reinhart's finer ones, in the order that Radiance has them in.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/scene.h>

#include <vector>

namespace difusa {

/// A part of the sphere between two elevations and two azimuths, radians. Azimuths are counted from north over east.
struct SkyCell {
    Index part = 0;
    double low = 0.0, high = 0.0; ///< elevations
    double from = 0.0, to = 0.0;  ///< azimuths; to - from is at most 2 pi

    double solid_angle() const;
};

/// Part 0 is the ground, all that is below the horizon. Then come seven bands of 30, 30, 24, 24, 18, 12 and 6 parts,
/// from the horizon up, each band divided `factor` times in elevation and its parts as often in azimuth: row by row, in
/// each of them eastward, and the first part of each row has north in its middle. The last part is the cap around the
/// zenith. All rows are equally high, and the cap has half of that as its radius: 90 degrees / (7 factor + 1/2).
class SkyDivision {
  public:
    static constexpr int most = 16; ///< largest factor

    /// `up`: unit; `north`: any direction that is not vertical. Throws UsageError for a vertical north, and for a
    /// factor below 1 or above `most`.
    SkyDivision(int factor, const Vec3& up, const Vec3& north);

    int factor() const { return factor_; }
    const Vec3& up() const { return up_; }
    const Vec3& north() const { return north_; }

    /// 144 factor² + 2.
    Index count() const { return static_cast<Index>(cells_.size()); }

    /// The part that contains the unit direction.
    Index at(const Vec3& towards) const;

    /// The whole of a part.
    const SkyCell& cell(Index part) const { return cells_[part]; }

    /// The middle of a part; of the ground straight down.
    Vec3 centre(Index part) const;

    /// A direction of a cell, uniform by solid angle if u and v are uniform in [0,1].
    Vec3 direction(const SkyCell& cell, double u, double v) const;

    /// The integral of w over the unit directions w of the cell: its product with a normal that the whole cell is above
    /// is the cell's projected solid angle.
    Vec3 moment(const SkyCell& cell) const;

    /// Whether no direction of the cell is below the plane with the normal n, but for rounding.
    bool is_above(const SkyCell& cell, const Vec3& n) const;

    /// Each part above the horizon cut into rows times columns of equal solid angle, about `each` of them, and the
    /// ground in the same cells mirrored in the horizon: they cover the sphere.
    std::vector<SkyCell> cells(std::size_t each) const;

    /// Mean radiance of each part, W/(m² sr), #parts by 3, of 8 by 8 directions at equal solid angles (of the ground,
    /// of 64 by 64).
    Values mean_radiances(const SkyDome& sky) const;

    /// Irradiance of level ground that sees all of the sky, W/m², for the radiances of the parts: exact. #columns.
    Eigen::RowVectorXd level_irradiance(const Values& radiance) const;

  private:
    Vec3 along(double elevation, double azimuth) const;
    int factor_;
    Vec3 up_, north_, east_;
    double height_;              ///< of a row
    std::vector<Index> first_;   ///< part of each row, and the cap
    std::vector<SkyCell> cells_; ///< #parts
};

} // namespace difusa
