// Sampler `mesh-vertices`: the vertices of the refined mesh (difusa/discretisation/patch_mesh.h), for the basis
// `vertex-linear`. The triangles are halved until no edge is longer than a multiple of the spacing at which there are
// about as many sites as with `poisson-disk`; since halving doubles them, a wanted number is met within a factor of
// about 1.5.
#include <difusa/core/error.h>
#include <difusa/discretisation/patch_mesh.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/plugin/plugin.h>

namespace {

class MeshVertices final : public difusa::Sampler {
  public:
    explicit MeshVertices(const difusa::Parameters& /*parameters*/) {}

    bool can_be_graded() const override { return false; }

    std::vector<difusa::SurfacePoint> sample(const difusa::Mesh& mesh, const difusa::Visibility* /*visibility*/,
                                             double spacing, std::size_t limit, difusa::RandomStream /*stream*/,
                                             const difusa::Execution& execution) const override {
        const double edge = difusa::PatchMesh::edge_for_vertices(spacing);
        const difusa::PatchMesh patches(mesh, edge, 4 * limit, execution);
        std::vector<difusa::SurfacePoint> points;
        for (difusa::Index v = 0; v < patches.vertex_count(); ++v) {
            points.push_back(patches.vertex(v));
        }
        if (points.size() > limit) {
            throw difusa::ResourceError("the refined mesh has " + std::to_string(points.size()) +
                                        " vertices, but memory suffices for only " + std::to_string(limit) +
                                        ": give a larger --spacing");
        }
        return points;
    }
};

} // namespace

DIFUSA_PLUGIN(sampler, "mesh-vertices", MeshVertices, "Vertices of the refined mesh, for vertex-linear.", {})
