// Common part of the bases of the classical method, whose elements belong to the patches or the vertices of a
// PatchMesh. They know nothing of what stands on a patch: light leaks under a wall whose foot is inside a patch.
#pragma once

#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/patch_mesh.h>

#include <optional>
#include <vector>

namespace difusa {

class MeshBasis : public Basis {
  public:
    bool partition_of_unity() const override { return true; }
    bool coefficients_are_values() const override { return true; }
    bool interpolates() const override { return true; }
    std::size_t size() const override { return sites_; }

    /// Throws UsageError unless the sites are those of `sampler()` at their spacing, at most without those of dark
    /// regions.
    void bind(const Mesh& mesh, const SiteSet& sites, const Execution& execution = {}) override;

  protected:
    /// True: one element for each vertex, with its site there. False: one for each patch, with its site at the centre.
    virtual bool on_vertices() const = 0;

    const PatchMesh& patches() const { return *patches_; }

    /// Element of a patch or vertex; none on dark regions.
    Index element(Index patch_or_vertex) const { return element_[patch_or_vertex]; }

  private:
    std::optional<PatchMesh> patches_;
    std::vector<Index> element_; ///< #patches or #vertices
    std::size_t sites_ = 0;
};

} // namespace difusa
