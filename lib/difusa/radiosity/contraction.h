// Does the light of a surface die out, whatever lights it?
#pragma once

#include <difusa/discretisation/discretisation.h>
#include <difusa/transport/light_transport.h>

#include <cstdint>

namespace difusa {

/// The spectral radius of T, which tells whether bounces die out. It depends on reflectances, and on no light.
struct Contraction {
    std::uint64_t reflectance = 0; ///< reflectance_fingerprint of those it was found for
    double radius = 0.0;
    bool is_bound = false; ///< true: an upper bound (the norm); false: an estimate

    /// A radius within rounding of 1 counts as 1.
    bool dies_out() const { return radius < 1.0 - 1e-9; }
};

/// Of the reflectances of surfels, by channel.
std::uint64_t reflectance_fingerprint(const Values& reflectance);

/// With these reflectances of surfels: the spectral radius, or the norm where that is known from one product and below
/// 1. `reflectance` is left to the caller.
Contraction contraction_of(const Discretisation& discretisation, const LightTransport& transport, const Values& rho,
                           const Execution& execution);

} // namespace difusa
