// The cost of a bake.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/result.h>
#include <difusa/lighting/direct_light.h>

namespace difusa {

/// Points where light is gathered.
std::size_t gather_points(const ProjectionChoice& projection, std::size_t sites);

/// Points where the error is estimated: BakeOptions::error_points, or an eighth of the sites, 400 to 4096; rounded up
/// to a multiple of ErrorPoints::groups.
std::size_t error_points(const BakeOptions& options, std::size_t sites);

/// Rays of each of the two gathers at such a point.
std::size_t error_rays(const BakeOptions& options);

/// Triangles of an output mesh that memory suffices for.
std::size_t most_output_triangles(const Execution& execution);

/// The mesh that fields are evaluated on.
OutputMesh output_mesh(const BakeResult& result, const Execution& execution);

/// Numbers of rays and bytes for this many sites. Throws ResourceError, with the remedy, if memory would not suffice.
BakeEstimate estimate_cost(const BakeResult& result, const Choices& choices, const DirectLight& lights,
                           std::size_t sites, const Execution& execution);

/// How many surfels to expect at the spacing of the sites; an upper estimate.
double expected_surfels(const BakeResult& result);

/// Fills in BakeEstimate::further_rays.
void count_further_rays(BakeEstimate& estimate, const BakeResult& result, const Execution& execution);

} // namespace difusa
