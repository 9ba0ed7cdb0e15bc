// Sampler `poisson-disk`: maximal Poisson-disk sampling of the surface (difusa/discretisation/poisson_disk.h).
#include <difusa/discretisation/poisson_disk.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/plugin/plugin.h>

namespace {

class PoissonDisk final : public difusa::Sampler {
  public:
    explicit PoissonDisk(const difusa::Parameters& /*parameters*/) {}

    std::vector<difusa::SurfacePoint> sample(const difusa::Mesh& mesh, const difusa::Visibility* /*visibility*/,
                                             double spacing, std::size_t limit, difusa::RandomStream stream,
                                             const difusa::Execution& execution) const override {
        return difusa::poisson_disk(mesh, spacing, limit, stream, execution);
    }
};

} // namespace

DIFUSA_PLUGIN(sampler, "poisson-disk", PoissonDisk, "Maximal Poisson-disk sampling: blue noise without gaps.", {})
