// Transport from surfel to surfel, without a basis: by fresh rays from a random point of each surfel.
#pragma once

#include <difusa/radiosity/system.h>
#include <difusa/transport/light_transport.h>

#include <cstdint>

namespace difusa {

/// What the basis of a bake cannot represent, such as light in a gap narrower than its sites are apart, is not missing
/// here, nor are the rays those of the bake. The noise of a surfel's few rays has the mean 0.
class SurfelTransport {
  public:
    /// `rays` from each surfel. Throws UsageError for glossy surfaces, which send different light in different
    /// directions.
    SurfelTransport(const RadiositySystem& system, std::size_t rays, std::uint64_t seed, const Execution& execution);

    /// z = D b + D (rho ∘ z), the irradiance of each surfel where the surfels send b, by iteration from `start` until
    /// no value changes by more than `tolerance` of the largest one, or, where little is absorbed, after 100
    /// iterations. All are #surfels by #channels.
    Values respond(const Values& rho, const Values& b, Values start, double tolerance,
                   const Execution& execution) const;

    std::size_t rays() const { return transport_.rays; } ///< cast

  private:
    LightTransport transport_;
};

} // namespace difusa
