// A box seen from inside whose radiosity is prescribed and whose emission is computed to match.
#pragma once

#include <difusa/algebra/quadrature.h>
#include <difusa/study/references/reference.h>

#include <functional>

namespace difusa {

/// The box [0,a] x [0,b] x [0,c], closed, reflectance rho. For a chosen B on its faces, smooth on each,
///     E = B - rho K B,   H = K B.
/// K B is an integral over the five other faces of tensor form in variables that follow its kernel up to the edges.
/// Over a face at right angles, x0 from the point, with zeta the height over the point's plane and v along the common
/// edge,
///     ∫∫ x0 zeta / (pi (x0² + zeta² + v²)²) B dv dzeta,   zeta = x0 sinh s, v = √(x0² + zeta²) sinh t
///     = (1/pi) ∫ sinh s / cosh² s ∫ B / cosh³ t dt ds;
/// over the face opposite, at the distance d,
///     ∫∫ d² / (pi (d² + u² + v²)²) B dv du,              u = d sinh s, v = √(d² + u²) sinh t
///     = (1/pi) ∫ 1 / cosh² s ∫ B / cosh³ t dt ds.
/// On the scale of s and t these are smooth, however small x0 is, with poles pi/2 off the real axis; Gauss-Legendre
/// panels of bounded length therefore converge geometrically, and on an edge itself yield the limit from the point's
/// face, at a corner the limit along the bisector.
class ManufacturedBox final : public Reference {
  public:
    /// Radiosity in W/m² at x with the inward normal n of its face.
    using Radiosity = std::function<double(const Vec3& x, const Vec3& n)>;

    /// `tolerance`: of K B as a share of the largest |B|; the nodes of a panel are doubled until it holds at points
    /// that include edges and corners. Throws UsageError if a size is not positive, rho not in [0,1], the tolerance
    /// below 1e-12, or B is not finite or E negative at one of the 9 x 9 points tested on each face (raise B's mean, or
    /// lower rho); NotConverged if 24 nodes per panel do not suffice, as for a B that is not smooth.
    ManufacturedBox(const Vec3& size, double rho, Radiosity radiosity, double tolerance = 1e-8);

    /// B = mean + amplitude cos(pi waves x/a) cos(pi waves y/b) cos(pi waves z/c), continuous across the edges. Its E
    /// is non-negative if mean (1 - rho) >= |amplitude| (1 + rho), since K takes averages.
    static Radiosity waves(const Vec3& size, double mean, double amplitude, double waves);

    /// On the face whose inward normal is closest to n, at its point closest to x. H_direct is unknown. Throws
    /// UsageError if x is farther from that face than a millionth of the box's largest size.
    ReferenceLight at(const Vec3& x, const Vec3& n) const override;

    /// Results at the points tested: largest error of K B, W/m², and smallest E.
    double error_estimate() const { return error_; }
    double least_emission() const { return least_emission_; }

  private:
    double irradiance(const Vec3& x, int axis, const QuadratureRule& rule) const;

    Vec3 size_;
    double rho_, tolerance_;
    Radiosity radiosity_;
    QuadratureRule rule_; ///< of one panel
    double error_ = 0.0, least_emission_ = 0.0;
};

} // namespace difusa
