// Two parallel plates facing each other.
#pragma once

#include <difusa/study/references/reference.h>

namespace difusa {

struct PlatesParameters {
    double E1 = 1.0, E2 = 0.0;     ///< emission of the plate z = 0 and of the plate z = gap, W/m²
    double rho1 = 0.5, rho2 = 0.5; ///< in [0,1], their product below 1
    double gap = 1.0;              ///< unit of the scene
};

/// Infinite plates z = 0, facing up, and z = gap, facing down. Each fills the other's view, so H1 = B2, H2 = B1 and
///     B1 = (E1 + rho1 E2) / (1 - rho1 rho2),   B2 = (E2 + rho2 E1) / (1 - rho1 rho2);
/// the irradiance directly from the other's emission is H1 = E2, H2 = E1.
class Plates final : public Reference {
  public:
    /// Throws UsageError if a parameter is outside its range.
    explicit Plates(const PlatesParameters& parameters);

    /// On the plate facing as n does: plate 1 if n points up, otherwise plate 2.
    ReferenceLight at(const Vec3& x, const Vec3& n) const override;

    /// What square plates of side L, with nothing else around them, lack compared with infinite ones, B_infinite - B.
    struct Missing {
        double least, most; ///< W/m²
    };

    /// Bounds of it in the middle of a plate (1 or 2). The difference e solves e1 = rho1 (K e2 + B2 (1 - F)) with the
    /// infinite B2 and the form factor F(x) of the square plate. Hence least = rho1 B2 (1 - F(middle)).
    /// Followed back bounce by bounce, e1 is the mean, over walks between infinite plates, of B where they first leave
    /// the square, times w_k = rho1 rho2 rho1 ... (k factors) for leaving at step k. A step goes farther than t to the
    /// side with the probability gap²/(gap² + t²), the share of the view not covered by a disc of radius t; a walk that
    /// is outside after at most k steps has made one longer than L/(2k). So it has left by step k with a probability of
    /// at most q_k = min(1, k gap²/(gap² + (L/2k)²)), and, summed by parts,
    ///     most = max(B1, B2) sum_k (w_k - w_{k+1}) q_k,   of order (gap/L)².
    Missing missing_in_the_middle(int plate, double side) const;

  private:
    double B(int plate) const;
    PlatesParameters parameters_;
};

} // namespace difusa
