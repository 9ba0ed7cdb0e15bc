// How many sites a sampler will place, from samplings of small windows of the surface.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/mesh/mesh.h>

#include <cstdint>
#include <optional>

namespace difusa {

/// The number of sites that `sampler` places at `spacing`, with a relative standard error of at most 1 %.
///
/// Windows, cubes of a few spacings, are drawn with a probability proportional to the area in them. Sites per area in
/// a window, times the area of the surface, is then an unbiased estimate of the count (Hansen and Hurwitz 1943); its
/// variance between windows says how many are needed. Each is sampled with a margin around it, so that its border does
/// not matter.
///
/// Returns nothing if the windows would hold more than a quarter of the surface: it is as well to sample all of it. The
/// sampler must not need rays, since windows do not have the visibility of the scene.
std::optional<double> predict_sites(const Sampler& sampler, const Mesh& mesh, double spacing, std::uint64_t seed,
                                    const Execution& execution);

struct ExpectedSites {
    double count;
    bool exact; ///< all of the surface was sampled, with the random numbers that a bake with this seed uses
};

/// The same for any sampler, by sampling all of the surface where windows would not do; `limit` if there are more then.
ExpectedSites expected_sites(const Sampler& sampler, const Mesh& mesh, const Visibility* visibility, double spacing,
                             std::size_t limit, std::uint64_t seed, const Execution& execution);

} // namespace difusa
