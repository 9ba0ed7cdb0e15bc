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
    /// For fields with FieldParts::sent. Means over groups of surfels are to be as accurate as `rays` rays. Keeps
    /// references.
    ExactCorrection(const FieldParts& field, std::span<const SurfacePoint> x, std::size_t rays,
                    const Execution& execution);

    /// Of the gather from all points with so many rays and directions of this seed, which are cast again.
    Irradiance of(std::size_t rays, std::uint64_t seed, const Execution& execution) const;

  private:
    const FieldParts& field_;
    std::span<const SurfacePoint> x_;
    Values sky_; ///< pi times the radiance of its parts, in the columns of FieldParts::sent; no rows: dark
    FactorsOfPoints factors_;
};

/// FieldParts::sent. `means`: of the smooth light over the surfels; `bright`: the light of sharp sources comes beside.
Values light_sent(const SurfelLight& light, const Values& means, bool bright, int channels);

} // namespace difusa
