// Plugin kind "sampler": placement of the sites.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/random.h>
#include <difusa/mesh/mesh.h>

#include <vector>

namespace difusa {

class Visibility;

class Sampler {
  public:
    virtual ~Sampler() = default;

    /// True if `sample` needs rays; then `visibility` is not null.
    virtual bool needs_visibility() const { return false; }

    /// False if its sites are those of a mesh, so that none can be added where they would help.
    virtual bool can_be_graded() const { return true; }

    /// True if its sites cover the whole surface, and others may be added. Such a sampler may also get pieces of a
    /// surface, whose meshes have points, triangles, normals, areas and regions, and nothing else.
    bool covers_evenly() const { return can_be_graded() && !needs_visibility(); }

    /// Points no two of which are closer than `spacing` in site distance; of a mesh, about as many. Throws
    /// ResourceError if there would be more than `limit`, InputError if the sampler finds no surface at all.
    virtual std::vector<SurfacePoint> sample(const Mesh& mesh, const Visibility* visibility, double spacing,
                                             std::size_t limit, RandomStream stream,
                                             const Execution& execution) const = 0;
};

/// The spacing at which `sampler` gives about `count` sites (within 5 % if any spacing does), found by repeated
/// sampling; for a large surface only of windows (see predict_sites.h). Each region, and each side of a body, has a
/// site in any case: where these single sites are more than half of `count`, the spacing is one that gives half of
/// `count` besides them, so that surfaces large enough for several sites have them. For a sampler that sees less than a
/// fiftieth of the surface it gives fewer.
double spacing_for_count(const Sampler& sampler, const Mesh& mesh, const Visibility* visibility, std::size_t count,
                         std::uint64_t seed, const Execution& execution);

} // namespace difusa
