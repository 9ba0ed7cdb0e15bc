// The inside of a cylinder.
#pragma once

#include <difusa/study/references/reference.h>

namespace difusa {

struct CylinderParameters {
    double radius = 1.0;                    ///< unit of the scene
    double rho = 0.5;                       ///< in [0,1)
    double constant = 1.0, amplitude = 1.0; ///< of the emission, W/m²; |amplitude| <= constant
    int waves = 1;                          ///< n >= 1
};

/// An infinite cylinder around the z axis, seen from inside, with the emission E = constant + amplitude cos(n theta),
/// theta the angle around the axis. Points theta apart and z along are r² = c² + z² apart, c = 2 R sin(theta/2), with
/// the cosine c²/(2 R r) at both ends; integrated along the axis, the form factor is
///     R dtheta ∫ c⁴/(4 R² pi r⁴) dz = (1/4) |sin(theta/2)| dtheta,
/// so K cos(n theta) = lambda cos(n theta), lambda = 1/(1 - 4n²), and K 1 = 1:
///     B = constant/(1 - rho) + amplitude cos(n theta)/(1 - rho lambda),
///     the irradiance directly from E being constant + lambda amplitude cos(n theta).
class InsideOfCylinder final : public Reference {
  public:
    /// Throws UsageError if a parameter is outside its range.
    explicit InsideOfCylinder(const CylinderParameters& parameters);

    /// In the direction of x from the axis. Throws UsageError on the axis.
    ReferenceLight at(const Vec3& x, const Vec3& n) const override;

    /// What a cylinder of finite length, open or with black ends, lacks: B_infinite - B.
    struct Missing {
        double least, most; ///< W/m²
    };

    /// Bounds of it halfway between the ends. As for plates (plates.h): the region beyond the ends has the form factor
    /// 2 F(length/2), F(t) = cylinder_element_to_section, and a step goes farther than t with the probability 2 F(t):
    ///     least = rho min(B) 2 F(length/2),
    ///     most  = max(B) sum_k (rho^k - rho^(k+1)) min(1, 2 k F(length/2k)),   of order (R/length)³.
    Missing missing_in_the_middle(double length) const;

  private:
    CylinderParameters parameters_;
};

} // namespace difusa
