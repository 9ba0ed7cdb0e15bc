// Sampler `patch-centres`: the centres of the patches of the refined mesh (difusa/discretisation/patch_mesh.h), for the
// basis `patch-constant`. The triangles are halved until no edge is longer than a multiple of the spacing at which
// there are about as many sites as with `poisson-disk`; since halving doubles them, a wanted number is met within a
// factor of about 1.5.
#include <difusa/discretisation/patch_mesh.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/plugin/plugin.h>

namespace {

class PatchCentres final : public difusa::Sampler {
  public:
    explicit PatchCentres(const difusa::Parameters& /*parameters*/) {}

    bool can_be_graded() const override { return false; }

    std::vector<difusa::SurfacePoint> sample(const difusa::Mesh& mesh, const difusa::Visibility* /*visibility*/,
                                             double spacing, std::size_t limit, difusa::RandomStream /*stream*/,
                                             const difusa::Execution& execution) const override {
        const double edge = difusa::PatchMesh::edge_for_patches(spacing);
        const difusa::PatchMesh patches(mesh, edge, limit, execution);
        std::vector<difusa::SurfacePoint> points;
        for (difusa::Index f = 0; f < patches.size(); ++f) {
            points.push_back(patches.centre(f));
        }
        return points;
    }
};

} // namespace

DIFUSA_PLUGIN(sampler, "patch-centres", PatchCentres,
              "Centres of the triangles of the refined mesh, for patch-constant.", {})
