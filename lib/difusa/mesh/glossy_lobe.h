// Glossy reflection: how a surface that is neither matt nor a mirror spreads the light of one direction.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <vector>

namespace difusa {

/// Which lobe, and how narrow it is.
struct LobeShape {
    enum class Model {
        phong, ///< (n + 2) / (2 pi) cosⁿ of the angle to the mirror direction, in the symmetric form (E. Lafortune and
               ///< Y. Willems, "Using the modified Phong reflectance model for physically based rendering", 1994)
        ggx ///< D G / (4 cos cos) with the microfacets of GGX and the correlated masking of Smith (B. Walter et al.,
            ///< "Microfacet models for refraction through rough surfaces", 2007; E. Heitz, "Understanding the
            ///< masking-shadowing function in microfacet-based BRDFs", 2014); no Fresnel factor
    };
    Model model = Model::phong;
    /// Phong: the exponent n; GGX: the roughness, whose square is the width alpha of the distribution of microfacets.
    double sharpness = 32.0;
    static constexpr double least_exponent = 1.0, most_exponent = 10000.0, least_roughness = 0.03;
    bool operator==(const LobeShape&) const = default;
};

/// A lobe that loses nothing: the light that the formula above loses at the angle of incidence theta, 1 - E(theta),
/// comes back spread by (1 - E(theta_i)) (1 - E(theta_o)) / (pi (1 - mean E)), as after many reflections between
/// microfacets (C. Kulla and A. Conty, "Revisiting physically based shading at Imageworks", 2017). What is reflected is
/// therefore exactly the reflectance, from every direction, and the BRDF is symmetric.
class GlossyLobe {
  public:
    explicit GlossyLobe(const LobeShape& shape);

    const LobeShape& shape() const { return shape_; }

    /// The BRDF of a reflectance of 1, in 1/sr: unit vectors away from the surface with the unit normal n, 0 if either
    /// points below it.
    double value(const Vec3& n, const Vec3& in, const Vec3& out) const;

    /// A direction by which light may have come that leaves in the direction `out`.
    struct Draw {
        Vec3 direction;
        double weight = 0.0; ///< BRDF times cosine over the density; 0: the direction is below the surface
    };

    /// From three numbers in [0, 1): the weights have the expectation 1.
    Draw draw(const Vec3& n, const Vec3& out, const std::array<double, 3>& u) const;

    /// E: the share of the light from a direction with this cosine that the formula itself reflects.
    double reflected(double cosine) const;

    /// `draw` of the formula itself in the frame in which the normal is z, with value / density and not the cosine: may
    /// point below the surface, where it is 0.
    Draw draw_lobe(const Vec3& out, double u, double v) const;

    /// The part that brings back the rest, in 1/sr.
    double rest(double cosine_in, double cosine_out) const {
        return (1.0 - reflected(cosine_in)) * (1.0 - reflected(cosine_out)) * rest_;
    }

  private:
    double lobe(const Vec3& in, const Vec3& out) const;
    double density(const Vec3& in, const Vec3& out) const;
    double reflected_by_formula(double cosine) const;
    double lambda(double cosine) const;
    double facets(double cosine) const;

    LobeShape shape_;
    double alpha2_ = 1.0;           ///< of GGX, squared
    std::vector<double> reflected_; ///< E at cosines from 0 to 1
    double rest_ = 0.0;             ///< 1 / (pi (1 - mean E)), or 0 if nothing is lost
};

} // namespace difusa
