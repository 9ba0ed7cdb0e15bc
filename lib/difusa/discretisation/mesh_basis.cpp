#include <difusa/discretisation/mesh_basis.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace difusa {

void MeshBasis::bind(const Mesh& mesh, const SiteSet& sites, const Execution& execution) {
    const double edge =
        on_vertices() ? PatchMesh::edge_for_vertices(sites.spacing) : PatchMesh::edge_for_patches(sites.spacing);
    patches_.emplace(mesh, edge, std::numeric_limits<Index>::max() - 1, execution);
    sites_ = sites.size();
    element_.assign(on_vertices() ? patches().vertex_count() : patches().size(), none);
    const auto refuse = [&](const std::string& what) {
        throw UsageError("the sites are not those of the mesh that this basis needs (" + what + "): use --sampler " +
                         sampler() + ", without --adaptive");
    };
    for (std::size_t j = 0; j < sites.size(); ++j) {
        const PatchMesh::Place place = patches().at(sites.points[j]);
        const auto largest = std::max_element(place.weight.begin(), place.weight.end());
        const Index own = on_vertices()
                              ? patches().corners(place.patch)[static_cast<std::size_t>(largest - place.weight.begin())]
                              : place.patch;
        // Sites have these coordinates up to rounding; a mesh of another spacing has others.
        if (std::abs(*largest - (on_vertices() ? 1.0 : 1.0 / 3.0)) > 1e-6) {
            refuse("site " + std::to_string(j) + " is at none of its places");
        }
        if (element_[own] != none) {
            refuse("two sites are at one place");
        }
        element_[own] = static_cast<Index>(j);
    }
    for (std::size_t k = 0; k < element_.size(); ++k) {
        const Index face =
            on_vertices() ? patches().vertex(static_cast<Index>(k)).face : patches().parent(static_cast<Index>(k));
        if (element_[k] == none && !sites.is_dark(mesh.region[face])) {
            refuse("a place has no site");
        }
    }
}

} // namespace difusa
