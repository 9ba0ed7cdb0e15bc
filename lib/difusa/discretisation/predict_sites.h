// Predicts how many sites a sampler will place, by sampling small windows of the surface.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/mesh/mesh.h>

#include <cstdint>
#include <optional>

namespace difusa {

/// The number of sites that `sampler` places at `spacing`, with a relative standard error of at most 1 %.
///
/// Windows, cubes of a few spacings, are drawn with a probability proportional to the area inside them. Sites per area
/// in a window, times the area of the surface, is then an unbiased estimate of the count (Hansen and Hurwitz 1943); its
/// variance between windows determines how many are needed. Each is sampled with a margin around it, so that its border
/// has no effect.
///
/// Returns nothing if the windows would contain more than a quarter of the surface: sampling all of it is then just as
/// cheap; nor if the sampler does not cover surfaces evenly (Sampler::covers_evenly). It must not need rays, since
/// windows do not have the visibility of the scene.
std::optional<double> predict_sites(const Sampler& sampler, const Mesh& mesh, double spacing, std::uint64_t seed,
                                    const Execution& execution);

struct ExpectedSites {
    double count;
    bool exact; ///< the whole surface was sampled, with the random numbers that a bake with this seed uses
};

/// The same for any sampler, sampling the whole surface if windows do not apply; `limit` if there are more sites.
ExpectedSites expected_sites(const Sampler& sampler, const Mesh& mesh, const Visibility* visibility, double spacing,
                             std::size_t limit, std::uint64_t seed, const Execution& execution);

} // namespace difusa
