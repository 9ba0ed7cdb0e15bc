// Glossy reflection in spherical harmonics: the light that leaves a point of a glossy surface as a function of
// direction.
#pragma once

#include <difusa/algebra/spherical_harmonics.h>
#include <difusa/mesh/glossy_lobe.h>

#include <span>
#include <vector>

namespace difusa {

/// In the frame of the surface, in which its normal is z. The radiance that leaves is continued below the surface by
/// its mirror image, so that there is no edge at the horizon: of the harmonics only those with even l + m remain.
///
/// An irradiance of 1 from the direction ω_i leaves as pi times the radiance sum_k F_k(ω_i) Y_k(ω_o), with
///     F_k(ω_i) = 2 pi ∫ f(ω_i, ω_o) Y_k(ω_o) dω_o  over the hemisphere.
/// For these isotropic lobes F_lm depends on the azimuth phi of ω_i as cos(m phi), or sin(|m| phi), and on the angle to
/// the normal as tabulated.
class LobeHarmonics {
  public:
    static constexpr int most_order = 20;

    /// The order is at most that.
    LobeHarmonics(const GlossyLobe& lobe, const SphericalHarmonics& harmonics);

    /// The harmonics with even l + m: their numbers (SphericalHarmonics::number).
    const std::vector<std::size_t>& numbers() const { return numbers_; }

    /// F_k for each of `numbers`, for a unit vector in the frame of the surface with z >= 0.
    void at(const Vec3& in, std::span<double> F) const;

    /// What an irradiance of 1 from all sides evenly leaves as: 1 in all directions, the coefficient sqrt(4 pi) of Y_0.
    static double even();

    /// The share of the square of what leaves at normal incidence, less its mean, that the harmonics hold: how well
    /// they resolve the lobe. 1 if there is no lobe.
    double resolved() const { return resolved_; }

  private:
    struct Band {
        int l, m;
    };
    std::vector<Band> bands_; ///< m >= 0
    std::vector<std::size_t> numbers_;
    std::vector<double> table_; ///< F at phi = 0, of each band in turn for each angle
    int order_;
    double resolved_ = 1.0;
};

} // namespace difusa
