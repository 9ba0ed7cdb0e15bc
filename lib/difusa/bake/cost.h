// What a bake would take.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/result.h>
#include <difusa/lighting/direct_light.h>

namespace difusa {

/// Points at which light is gathered.
std::size_t gather_points(const ProjectionChoice& projection, std::size_t sites);

/// Points at which the error is estimated: BakeOptions::error_points, or an eighth of the sites, 128 to 4096.
std::size_t error_points(const BakeOptions& options, std::size_t sites);

/// Counts of rays and bytes for so many sites. Throws ResourceError, naming the remedy, if memory would not suffice.
BakeEstimate estimate_cost(const BakeResult& result, const Choices& choices, const DirectLight& lights,
                           std::size_t sites, const Execution& execution);

/// Casts the rays of a few sites to see how long all would take. Phase "time a sample of rays".
void time_sample(BakeEstimate& estimate, const BakeResult& result, const Choices& choices, const DirectLight& lights,
                 const SiteSet& sites, const Execution& execution);

} // namespace difusa
