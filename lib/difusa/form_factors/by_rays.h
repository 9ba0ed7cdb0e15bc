// Form factors counted by rays: the hits of a set of directions, or of pixels of a hemicube.
#pragma once

#include <difusa/form_factors/form_factors.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/tracer.h>

#include <cstdint>

namespace difusa {

/// F_ij as the weight of the rays from i that meet the front of j first: `points` points on each triangle, distributed
/// evenly from a random place on, each with a set of directions from the pool. With directions distributed as the
/// cosine this is the Nusselt disc (L 38); with the pixels of a hemicube and their delta factors it is the hemicube (L
/// 39-45). The errors are standard errors from the differences between the points. Reciprocity is not enforced.
///
/// The same bits for any number of threads. Journal and progress: phase "form factors". Throws UsageError if `points`
/// is less than 2: from one, errors cannot be estimated; Interrupted if cancelled.
FormFactors form_factors_by_rays(const Tracer& tracer, const Surfaces& surfaces, const DirectionPool& pool,
                                 std::size_t points, std::uint64_t seed, const Execution& execution);

} // namespace difusa
