// A surface with everything that light transport over it needs, without a bake.
#pragma once

#include <difusa/discretisation/discretisation.h>
#include <difusa/radiosity/reflected_transport.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/gathered.h>
#include <difusa/transport/kernel.h>
#include <difusa/transport/pairwise.h>

#include <support/sited.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace difusa::test {

struct Discretised {
    Scene scene;
    std::shared_ptr<Visibility> engine;
    Discretisation discretisation;

    Discretised(Scene made, SiteSet sites, const std::string& engine_name, const std::string& basis)
        : scene(std::move(made)), engine(plugin<Visibility>(engine_name)) {
        engine->build(scene.mesh);
        discretisation = discretise(scene.mesh, std::make_shared<SiteSet>(std::move(sites)), plugin<Basis>(basis), {},
                                    false, 1, Execution{});
    }
    Discretised(Scene made, double spacing, const std::string& engine_name, const std::string& basis)
        : Discretised(made, poisson_sites(made.mesh, spacing), engine_name, basis) {}
    Discretised(const Discretised&) = delete;
    Discretised& operator=(const Discretised&) = delete;

    const SiteSet& sites() const { return *discretisation.sites; }
    Tracer tracer() const { return {scene.mesh, *engine}; }

    LightTransport gathered(std::size_t rays, const std::string& directions = "low-discrepancy",
                            std::uint64_t seed = 1) const {
        return difusa::gathered(tracer(), discretisation.points, *discretisation.surfels,
                                *plugin<Directions>(directions), rays, seed, Execution{});
    }
    LightTransport paired(const std::string& kernel, unsigned threads = 1, std::size_t rays = 16,
                          const MirrorPathOptions& over_mirrors = {}) const {
        return pairwise(tracer(), discretisation, *plugin<Kernel>(kernel), over_mirrors,
                        *plugin<Directions>("low-discrepancy"), rays, 1, Execution{threads, nullptr, nullptr});
    }

    /// The same on all surfels.
    Values on_surfels(double value) const {
        return Values::Constant(static_cast<Eigen::Index>(discretisation.surfels->size()), 1, value);
    }

    /// D b at the points.
    static Values gather(const LightTransport& transport, const Values& b) {
        Values h;
        transport.gather(b, {}, h, Execution{});
        return h;
    }

    /// Row sums of D.
    Values row_sums(const LightTransport& transport) const { return gather(transport, on_surfels(1.0)); }
};

/// The matrix of an operator.
inline Eigen::MatrixXd dense(const LinearOperator& A) {
    const auto n = static_cast<Eigen::Index>(A.columns());
    Values columns;
    A.apply(Values::Identity(n, n), columns, Execution{});
    return columns;
}

/// D, the columns of W that belong to the surfels, and the sum of those of the sky's parts: there are thousands of
/// these.
inline Eigen::MatrixXd dense_with_sky_summed(const LightTransport& transport) {
    const auto m = static_cast<Eigen::Index>(transport.surfels);
    Values x = Values::Zero(static_cast<Eigen::Index>(transport.W->columns()), m + 1), columns;
    x.topLeftCorner(m, m).setIdentity();
    x.bottomRightCorner(x.rows() - m, 1).setOnes();
    transport.W->apply(x, columns, Execution{});
    return columns;
}

} // namespace difusa::test
