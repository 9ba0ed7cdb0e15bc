// A mesh together with what its images beyond symmetry planes and periods put next to it.
#pragma once

namespace difusa {

struct Mesh;

/// The mesh, whose walls are known (settle_repetition), joined to the parts of its images that touch it: its own
/// triangles first, with their numbers, then those of images at most three triangles away from a point that both have,
/// and all that continue these in one plane. Points of images within twice 1e-6 of the mesh's diameter of others, as
/// far as the mesh may be beyond its walls, are these. The result has no walls; it is derived.
Mesh unfolded(const Mesh& mesh);

} // namespace difusa
