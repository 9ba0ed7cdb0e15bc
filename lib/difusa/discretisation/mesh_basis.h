// Common part of the bases of the classical method, whose elements belong to the patches or the vertices of a
// PatchMesh. They know nothing of what stands on a patch: light leaks under a wall whose foot is inside a patch.
#pragma once

#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/patch_elements.h>
#include <difusa/discretisation/patch_mesh.h>

#include <optional>
#include <string>
#include <vector>

namespace difusa {

class MeshBasis : public Basis {
  public:
    bool partition_of_unity() const override { return true; }
    bool coefficients_are_values() const override { return true; }
    bool interpolates() const override { return true; }
    std::size_t size() const override { return sites_; }

    /// Throws UsageError unless the sites are those of `sampler()` at their spacing, or if they are graded and that is
    /// possible, of elements of its patches; at most without those of dark regions.
    void bind(const Mesh& mesh, const SiteSet& sites, const Execution& execution = {}) override;

    const Substructure* substructure() const override { return elements_ ? &substructure_ : nullptr; }

  protected:
    /// True: one element for each vertex, with its site there. False: one for each patch, with its site at the centre.
    virtual bool on_vertices() const = 0;

    const PatchMesh& patches() const { return *patches_; }

    /// Element of a patch or vertex; none on dark regions. Not of graded sites.
    Index element(Index patch_or_vertex) const { return element_[patch_or_vertex]; }

    /// Element of the patch at a place, or of the part of it there.
    Index element_at(const PatchMesh::Place& place) const {
        return elements_ ? elements_->site(elements_->at(place)) : element_[place.patch];
    }

  private:
    void bind_elements(const Mesh& mesh, const SiteSet& sites, const Execution& execution);
    [[noreturn]] void refuse(const std::string& what) const;

    std::optional<PatchMesh> patches_;
    std::vector<Index> element_;            ///< #patches or #vertices
    std::optional<PatchElements> elements_; ///< of graded sites
    Substructure substructure_;             ///< likewise
    std::size_t sites_ = 0;
};

} // namespace difusa
