// Less noise in gathers by fresh rays, where the operator has exact form factors.
#pragma once

#include <difusa/lighting/surfel_light.h>
#include <difusa/radiosity/field.h>
#include <difusa/transport/analytic_transport.h>

#include <cstddef>
#include <span>

namespace difusa {

/// Corrects gathers from some points by (W - R) b: R b is the light b of the surfels and the sky that their rays bring,
/// and W has, as the operator of the system, exact form factors in place of rays to surface that is seen whole
/// (transport/analytic_transport.h). This removes the noise of these rays; what is left is that of rays elsewhere, and
/// of the light's variation within surfels. Averaged over all rays it is 0, up to the errors of linear kernels over
/// groups of surfels (transport/analytic_factors.h).
class ExactCorrection {
  public:
    /// For fields with FieldParts::sent. The errors of linear kernels are to stay below the noise of `rays` rays.
    /// Keeps references.
    ExactCorrection(const FieldParts& field, std::span<const SurfacePoint> x, std::size_t rays,
                    const Execution& execution);

    /// Of the gather from all points whose rays are the rows of this transport (GatheredRows).
    Irradiance of(LightTransport by_rays, const Execution& execution) const;

  private:
    const FieldParts& field_;
    Values sky_; ///< pi times the radiance of its parts, in the columns of FieldParts::sent; no rows: dark
    FactorsOfPoints factors_;
};

/// FieldParts::sent. `means`: of the smooth light over the surfels; `sharp`: besides, that of sharp sources; `uneven`:
/// that of emitters with a texture or pattern. Neither where bright surfels are sampled (BrightSurfels::places): noise
/// of rays is then not that of such light.
Values light_sent(const SurfelLight& light, const Values& means, bool sharp, bool uneven, int channels);

} // namespace difusa
