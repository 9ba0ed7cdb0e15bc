// The inside of a sphere: every point receives the same light.
#pragma once

#include <difusa/study/references/reference.h>

#include <functional>
#include <optional>

namespace difusa {

/// A closed sphere of radius R around the origin, seen from inside, with one reflectance rho and any emission E.
/// Two points x, y of it are |x-y| = 2 R cos(theta) apart with the same cosine at both ends, so the form factor
///     F(x,y) = cos² theta / (pi 4 R² cos² theta) = 1 / (4 pi R²)
/// is constant: the irradiance is the mean of B over the sphere. With <B> = <E> + rho <B>
///     H = <B> = <E> / (1 - rho),   directly from E: <E>,   B = E + rho H.
class InsideOfSphere final : public Reference {
  public:
    /// `emission` in W/m², a function of the unit vector from the origin to the point, non-negative. `mean` is its mean
    /// over the sphere; if absent, it is computed by Gauss-Legendre in the height and the trapezoidal rule in
    /// longitude, doubled until it changes by less than `tolerance` of the largest value found, which happens soon for
    /// a smooth emission. Throws UsageError if rho is not in [0,1), a value or the mean is negative or not finite;
    /// NotConverged if 1024 by 2048 nodes do not suffice, as for an emission with jumps: give its mean.
    InsideOfSphere(double rho, std::function<double(const Vec3&)> emission, std::optional<double> mean = {},
                   double tolerance = 1e-12);

    /// In the direction of x from the origin, whatever its length. Throws UsageError if x is the origin.
    ReferenceLight at(const Vec3& x, const Vec3& n) const override;

    double mean_emission() const { return mean_; }

  private:
    double rho_;
    std::function<double(const Vec3&)> emission_;
    double mean_ = 0.0;
};

} // namespace difusa
