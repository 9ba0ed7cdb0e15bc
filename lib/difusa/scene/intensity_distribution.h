// The luminous intensity distribution of a luminaire, in the angles it was measured in.
#pragma once

#include <difusa/core/types.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// The angle systems of goniophotometry, as in ANSI/IESNA LM-63-2002, chapter 3. In a luminaire's own axes, in which
/// gamma 0 is along -z, and photometric horizontal along +x:
/// - C: planes through the vertical axis, counterclockwise seen from above; gamma from straight down, 0 to 180;
/// - B: planes through the horizontal axis y, of vertical angle 0 straight down and 90 along +x; in each of them the
///   horizontal angle from there, -90 to 90, positive towards -y (clockwise seen from above);
/// - A: planes through the vertical axis, of horizontal angle 0 along +x, clockwise seen from above; in each of them
/// the
///   vertical angle from the horizontal, -90 (straight down) to 90.
enum class PhotometryType : std::uint8_t { C, B, A };

/// Intensities on a grid of angles, interpolated linearly in both angles. Immutable.
class IntensityDistribution {
  public:
    /// As tabulated: the angles in degrees, ascending. `plane`: C, or the angle between planes of B and A; `in_plane`:
    /// the other one. `value`: plane after plane, any unit, not negative.
    struct Table {
        PhotometryType type = PhotometryType::C;
        std::vector<double> plane, in_plane, value;
    };

    /// Planes of C that end at 0, 90 or 180 (or span from 90 to 270), and angles of A and B that start at 0, stand for
    /// symmetric ones; planes of C that end before 360 go on to the first. Throws std::invalid_argument for a table of
    /// other size, with angles outside their range or not ascending, values that are negative or not finite, and none
    /// above 0.
    explicit IntensityDistribution(Table table);

    /// In the unit direction `away` in the luminaire's axes, in the unit of the table; 0 where nothing is tabulated.
    double intensity(const Vec3& away) const;

    /// The largest of the table, which is above 0.
    double largest() const { return largest_; }

    /// `intensity` over `largest`.
    double relative(const Vec3& away) const { return intensity(away) / largest_; }

    /// The integral of `intensity` over the sphere, exactly: in each cell the mean of both planes times their angle,
    /// and over the angle theta from the pole, from a to b, of I_a + (I_b - I_a) (theta - a) / (b - a):
    /// I_a cos a - I_b cos b + (I_b - I_a) (sin b - sin a) / (b - a).
    double flux() const;

    /// The same below the horizontal plane of a distribution of type C.
    double downward_flux() const;

    /// The angle from (0, 0, -1) beyond which no cell of the table has more than a tenth of the largest intensity: half
    /// of the field angle of a beam downwards, up to the next angle tabulated. At most pi.
    double beyond_beam() const { return beyond_beam_; }

  private:
    double find_beyond_beam() const;
    double flux_up_to(double theta) const;
    double at_plane(std::size_t plane, std::size_t row, double share) const;

    /// In radians: plane angle, from `zero_` towards `side_`, and angle from `pole_`.
    std::vector<double> plane_, theta_;
    std::vector<double> value_; ///< by plane
    bool even_ = false;         ///< the same in all planes
    bool closed_ = false;       ///< the planes go all around
    double largest_ = 0.0, beyond_beam_ = 0.0;
    Vec3 pole_, zero_, side_;
};

} // namespace difusa
