// A mesh together with what its images beyond symmetry planes and periods put next to it.
#pragma once

namespace difusa {

struct Mesh;

/// The mesh, whose walls are known (settle_repetition), joined to the parts of its images that touch it: its own
/// triangles first, with their numbers, then those of images at most three triangles away from a point that both have,
/// all that continue these in one plane, and the facets beyond. Of images of images only those that touch the mesh
/// itself are there. Points of images that lie within 2e-6 of the mesh's diameter of another point, twice what a mesh
/// may reach beyond a wall, are taken to be that point. The result has no walls; it is derived.
Mesh unfolded(const Mesh& mesh);

} // namespace difusa
