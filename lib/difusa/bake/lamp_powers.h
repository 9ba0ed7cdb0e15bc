// Which powers of the lamps light places as evenly as possible to a wanted level.
#pragma once

#include <difusa/bake/relight.h>

#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// The factors on light groups, none of them negative, with the least sum of squares of the deviations at the places.
struct LampPowers {
    std::vector<std::pair<std::string, double>> factors; ///< as for LightChange::scale
    Eigen::VectorXd wanted;                              ///< at each place, lux of a photometric bake, else W/m²
    Eigen::VectorXd before, after;                       ///< at each place: the lamps as they are, and with the factors
    double fixed = 0.0;                                  ///< mean of what suns and sky give, which stays as it is
    std::size_t too_bright = 0;                          ///< places where that is more than what is wanted

    bool photometric = false;

    double rms() const;       ///< root mean square of after - wanted
    std::string text() const; ///< one sentence for people
};

/// `result`: with light groups and its places read (bake/sensing.h). Lamps are the groups of emitting materials, point
/// lights and luminaires in which there is neither a sun nor the sky. Irradiances count by the luminance of their
/// channels (core/colour.h). `wanted`: at each place, first those on the surface, then the sensors. Throws UsageError
/// without places or lamps, and if no lamp reaches a place.
LampPowers lamp_powers(const BakeResult& result, const Eigen::VectorXd& wanted);

/// `relight` with the factors for one level at all places on top of the changes of the options; a note of the result
/// tells them. They are found from a first solution in which the light groups are kept apart. Throws what both throw.
BakeResult relight_lamps(const Registry& registry, const SavedTransport& saved, const RelightOptions& options,
                         double wanted, LampPowers& powers, const Execution& execution);

} // namespace difusa
