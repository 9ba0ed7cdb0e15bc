#include <difusa/discretisation/mesh_basis.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace difusa {

namespace {

constexpr std::size_t most_patches = std::numeric_limits<Index>::max() - 1;

} // namespace

void MeshBasis::refuse(const std::string& what) const {
    throw UsageError("the sites are not those of the mesh that this basis needs (" + what + "): use --sampler " +
                     sampler() + (can_be_subdivided() ? "" : ", without --adaptive"));
}

void MeshBasis::bind_elements(const Mesh& mesh, const SiteSet& sites, const Execution& execution) {
    patches_.emplace(mesh, PatchMesh::edge_for_patches(PatchElements::coarseness * sites.spacing), most_patches,
                     execution);
    sites_ = sites.size();
    try {
        elements_.emplace(patches(), sites.points);
    } catch (const UsageError& error) {
        refuse(error.what());
    }
    substructure_.patch.assign(sites.size(), none);
    substructure_.area.assign(sites.size(), 0.0);
    for (const Index node : elements_->elements()) {
        if (const Index site = elements_->site(node); site != none) {
            substructure_.patch[site] = elements_->patch(node);
            substructure_.area[site] = elements_->area(node);
            substructure_.levels = std::max(substructure_.levels, elements_->level(node));
        } else if (!sites.is_dark(mesh.region[patches().parent(elements_->patch(node))])) {
            refuse("a place has no site");
        }
    }
}

void MeshBasis::bind(const Mesh& mesh, const SiteSet& sites, const Execution& execution) {
    if (sites.graded && can_be_subdivided()) {
        bind_elements(mesh, sites, execution);
        return;
    }
    const double edge =
        on_vertices() ? PatchMesh::edge_for_vertices(sites.spacing) : PatchMesh::edge_for_patches(sites.spacing);
    patches_.emplace(mesh, edge, most_patches, execution);
    sites_ = sites.size();
    element_.assign(on_vertices() ? patches().vertex_count() : patches().size(), none);
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
