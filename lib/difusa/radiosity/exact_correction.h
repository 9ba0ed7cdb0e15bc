// Less noise in gathers by fresh rays, where the operator has exact form factors.
#pragma once

#include <difusa/lighting/surfel_light.h>
#include <difusa/radiosity/field.h>
#include <difusa/transport/analytic_transport.h>

#include <cstdint>
#include <memory>
#include <span>

namespace difusa {

/// Corrects gathers from some points by (W - R) b: R b is the light b of the surfels and the sky that their rays bring,
/// and W has, as the operator of the system, exact form factors in place of rays to surface that is seen whole
/// (transport/analytic_transport.h). Its mean over all rays is 0. It takes their noise with it, so that what is left is
/// that of rays elsewhere, and of the light's variation within surfels.
class ExactCorrection {
  public:
    /// `means`: as of Field::gather_by_surfels; `light`: of the surfels; `rays`: means over groups of surfels are to be
    /// as accurate as so many. Keeps references.
    ExactCorrection(const FieldParts& field, std::span<const SurfacePoint> x, const Values& means,
                    const SurfelLight& light, std::size_t rays, const Execution& execution);

    /// The system's operator has exact form factors.
    static bool is_for(const FieldParts& field);

    /// Of the gather from all points with so many rays and directions of this seed, which are cast again.
    Irradiance of(std::size_t rays, std::uint64_t seed, const Execution& execution) const;

  private:
    const FieldParts& field_;
    std::span<const SurfacePoint> x_;
    Values b_;   ///< #surfels: what they send of direct and of indirect light, of each set
    Values sky_; ///< likewise, of its parts; no rows: dark
    FactorsOfPoints factors_;
};

} // namespace difusa
