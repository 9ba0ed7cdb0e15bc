// A spherical bowl under sun and sky: every point receives the same indirect light, lit or shaded.
#pragma once

#include <difusa/study/references/reference.h>

namespace difusa {

struct BowlParameters {
    double half_angle = 1.0;          ///< beta in (0, pi), from the lowest point to the rim, at the sphere's centre
    double rho = 0.8;                 ///< in [0,1]
    Vec3 towards_sun = Vec3::UnitZ(); ///< unit vector
    double sun = 1.0;                 ///< F0, irradiance of a surface facing the sun, W/m²
    double sky = 0.0;                 ///< irradiance of a surface that sees only sky, W/m²
};

/// The inside of the cap of a sphere around the origin up to the angle beta from its lowest point; the rim is level, at
/// the height -R cos beta. As on a whole sphere, the form factor between any two points is 1/(4 pi R²), so a point sees
/// the cap with the share f = (1 - cos beta)/2 of the sphere's area, and the sky with 1 - f.
///
/// Light passing the opening, a level disc of radius R sin beta, lands in the bowl: disc and cap bound a convex body.
/// From a sun at the elevation e0 > 0 that is F0 sin e0 pi R² sin² beta for any beta, since cap and sun lie on
/// different sides of the opening, so the cap never shades it. Averaged over the cap's area 2 pi R² (1 - cos beta) that
/// gives <H_direct> = (1 - f) F0 sin e0. With <B> = rho (<H_direct> + f <B>) everywhere
///     H_indirect = f <B> = rho f (1 - f) (F0 sin e0 + sky) / (1 - rho f)
/// (for craters: A. P. Ingersoll, T. Svitek and B. C. Murray, Icarus 100, 1992). With e0 <= 0 nothing enters from above
/// and the formula does not hold.
///
/// A point p with inward normal n is lit if n·s > 0 and the ray towards the sun, which meets the sphere again at
/// p + 2 R (n·s) s, does so above the rim. Some of the bowl is shaded if e0 < beta.
class Bowl final : public Reference {
  public:
    /// Throws UsageError if beta is not in (0, pi), rho not in [0,1], the sun not above the horizon, its direction not
    /// of unit length or an irradiance negative or not finite.
    explicit Bowl(const BowlParameters& parameters);

    /// At the point of the sphere in the direction of x from the origin, whatever its length. On a mesh slightly inside
    /// the sphere it may be slightly above the rim. Throws UsageError if x is the origin.
    ReferenceLight at(const Vec3& x, const Vec3& n) const override;

    /// Does the sun reach the point of the sphere in the direction of x?
    bool lit(const Vec3& x) const;

    double indirect() const;  ///< H_indirect, W/m²
    double share() const;     ///< f
    double elevation() const; ///< e0

  private:
    double from_sun(const Vec3& x) const;
    BowlParameters parameters_;
};

} // namespace difusa
