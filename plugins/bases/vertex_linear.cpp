// Basis `vertex-linear`: hat functions. The surface is refined to triangles of the size that the spacing says, and
// element i is 1 at vertex i, 0 at all others, and linear on each triangle. The sites are the vertices (sampler
// `mesh-vertices`). A partition of unity that interpolates, of second order on even meshes; the classical choice for
// Gouraud shading (L 53).
#include <difusa/discretisation/mesh_basis.h>
#include <difusa/plugin/plugin.h>

namespace {

class VertexLinear final : public difusa::MeshBasis {
  public:
    explicit VertexLinear(const difusa::Parameters& /*parameters*/) {}

    std::string sampler() const override { return "mesh-vertices"; }

    void evaluate(const difusa::SurfacePoint& x, difusa::BasisRow& row) const override {
        row.clear();
        const difusa::PatchMesh::Place place = patches().at(x);
        for (std::size_t k = 0; k < 3; ++k) {
            const difusa::Index own = element(patches().corners(place.patch)[k]);
            if (own != difusa::none && place.weight[k] > 0.0) {
                row.element.push_back(own);
                row.weight.push_back(place.weight[k]);
            }
        }
    }
    using Basis::evaluate;

  protected:
    bool on_vertices() const override { return true; }
};

} // namespace

DIFUSA_PLUGIN(basis, "vertex-linear", VertexLinear,
              "Hat functions on the vertices of the refined mesh, of the classical method.", {})
