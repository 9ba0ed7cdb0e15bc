// A ball over a disc under a sun directly above: two unknown functions of one variable each.
#pragma once

#include <difusa/algebra/quadrature.h>
#include <difusa/study/references/reference.h>

#include <cstddef>
#include <vector>

namespace difusa {

/// The disc of radius R lies in the plane z = 0 around the origin and faces up; the ball of radius r has its centre at
/// (0, 0, h). The sun gives an unshaded horizontal surface the irradiance mu.
struct BallOverDiscParameters {
    double R = 40.0, r = 5.0, h = 20.0; ///< unit of the scene
    double beta = 0.9, delta = 0.9;     ///< reflectance of the ball and of the disc
    double mu = 0.9;                    ///< W/m²
};

/// The radiosity of ball and disc (T ch. 7, with the ball's area element r² cos(alpha) dtheta dalpha).
///
/// Between latitude alpha on the ball and distance u from the centre of the disc, the point-to-point form factor
/// integrated over the longitude tau between them is
///     G(alpha, u) = (2/pi) (h + r sin alpha) ∫_0^tau0 (s cos tau - c) / (A - C cos tau)² dtau,
///     s = u cos alpha,  c = r + h sin alpha,  A = u² + r² + h² + 2 h r sin alpha,  C = 2 u r cos alpha,
/// with cos tau0 = c/s clamped to [-1,1], where the disc's point passes the tangent plane of the ball. It has a closed
/// form: with X = A - C cos tau0
///     I1 = ∫ dtau / (A - C cos tau)      = 2/√(A²-C²) atan(√((A+C)/(A-C)) tan(tau0/2)),
///     I2 = ∫ dtau / (A - C cos tau)²     = (C sin(tau0)/X + A I1) / (A²-C²),
///     I3 = ∫ cos tau dtau / (A - C cos tau)² = (sin(tau0)/X + C I2) / A.
/// Neither body sees itself, so the indirect irradiances solve
///     H_ball(alpha) = ∫ delta (mu [u > r] + H_disc(u)) G u du,
///     H_disc(u)     = ∫ beta (mu max(0, sin alpha) + H_ball(alpha)) G r² cos alpha dalpha.
/// They are analytic between the latitudes whose tangent planes touch the rim of the disc or of the shadow,
///     alpha = ±atan(v/h) - asin(r/√(h²+v²)), v = R, r,
/// and between u = 0, r and R, with half-integer powers of the distance from these points. On panels between them, none
/// longer than its distance from the other body, they are interpolated in a variable in which such powers are smooth,
/// and the integrals are split where G has a kink.
class BallOverDisc final : public Reference {
  public:
    /// Doubles the nodes of a panel until no indirect irradiance changes by more than `tolerance` times the largest.
    /// Throws UsageError if a length is not positive, h <= r, a reflectance is outside [0,1], mu <= 0 or the tolerance
    /// is below 1e-12; NotConverged if the bodies are so close that the tolerance would need too many unknowns.
    explicit BallOverDisc(const BallOverDiscParameters& parameters, double tolerance = 1e-9);

    /// At latitude alpha in [-pi/2, pi/2]. Throws UsageError if it is outside.
    ReferenceLight ball(double alpha) const;

    /// At distance u in [0, R] from the centre of the disc; the shadow's rim u = r counts as shaded. Throws UsageError
    /// if u is outside.
    ReferenceLight disc(double u) const;

    /// On whichever of the two surfaces is closer to x, in its direction from the ball's centre or at its distance from
    /// the axis (at most R). Throws UsageError on the disc if n points down.
    ReferenceLight at(const Vec3& x, const Vec3& n) const override;

    const BallOverDiscParameters& parameters() const { return parameters_; }

    /// Largest change of an indirect irradiance, W/m², when the nodes were last doubled: a bound in practice, since the
    /// rule converges faster than any power.
    double error_estimate() const { return error_; }

    /// Number of nodes on both bodies.
    std::size_t size() const { return ball_.node.size() + disc_.node.size(); }

    /// Powers in W. Escaped is computed from the form factors to the outside, so incoming = absorbed + escaped is a
    /// check.
    struct Power {
        double incoming = 0.0, absorbed = 0.0, escaped = 0.0;
    };
    Power power() const;

  private:
    struct Panel {
        double from, to;
    };
    /// The indirect irradiance of one body, interpolated on each panel at the nodes of `rule_`.
    struct Side {
        std::vector<Panel> panels;
        std::vector<double> node, weight, H; ///< latitude or distance, quadrature weight, value; panel after panel
    };
    /// The light one body sends to a point of the other: direct + sum_j indirect_j H_j.
    struct Row {
        double direct = 0.0, form_factor = 0.0;
        std::vector<double> indirect;
        double of(const std::vector<double>& H) const;
    };

    double G(double alpha, double u) const;
    Row from_disc(double alpha) const;
    Row from_ball(double u) const;
    template <class Kernel, class Direct>
    Row row(const Side& sender, double albedo, std::vector<double> kinks, const Kernel& kernel,
            const Direct& direct) const;
    double direct_ball(double alpha) const;
    double direct_disc(double u) const;
    /// Halves the pieces between `ends` until none is longer than its midpoint allows.
    template <class Longest> static std::vector<Panel> divide(const std::vector<double>& ends, const Longest& longest);
    void place_nodes(Side& side) const;
    void solve(std::size_t nodes);
    std::vector<double> samples() const; ///< indirect irradiances, at eight points per panel
    void refine(double tolerance);

    BallOverDiscParameters parameters_;
    double R_, r_; ///< in units of h
    QuadratureRule rule_, fine_;
    std::vector<double> barycentric_;
    Side ball_, disc_;
    double error_ = 0.0;
};

} // namespace difusa
