// Maximal Poisson-disk sampling of the surface under the site distance of T 4.1, at one spacing or a graded one.
//
// First, darts are thrown evenly over the area. The remaining gaps are then searched for: the triangles are divided
// into pieces; a piece fully covered by one site is done; into any other a dart is thrown, the piece is halved at its
// longest edge, and both halves are queued for the next round.
//
// All darts of a round have random priorities: those become sites that would if they were thrown one at a time by
// priority (SiteGrid::insert). The work is thus shared between threads, with the result of serial dart throwing.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/random.h>
#include <difusa/discretisation/size_field.h>
#include <difusa/mesh/mesh.h>

#include <vector>

namespace difusa {

/// No two sites are closer than `spacing` D, and no surface point is farther than D (1 + 2^-20) from its nearest site,
/// or than D and four steps of the coordinates where these are coarser: every face region, wall side and small object
/// has sites, whatever the shape of the triangles. Throws ResourceError if there would be more than `limit`.
std::vector<SurfacePoint> poisson_disk(const Mesh& mesh, double spacing, std::size_t limit, RandomStream stream,
                                       const Execution& execution);

/// Adds sites to `sites`, which cover the surface at the spacing `size.largest()`: for the spacings D_k = 2^(-k/2)
/// `size.largest()` in turn, k = 1, 2, ..., until every point x with size(x) + slope D_k / 6 < rounding D_k (constants
/// of SizeField) has a site within D_k. No new site is closer to another than the D_k it was added for. Throws
/// ResourceError if there would be more than `limit`.
std::vector<SurfacePoint> refine_sites(const Mesh& mesh, std::vector<SurfacePoint> sites, const SizeField& size,
                                       std::size_t limit, RandomStream stream, const Execution& execution);

} // namespace difusa
