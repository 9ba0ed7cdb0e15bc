// Inside of a sphere every point is lit alike by every other: the kernel is the constant 1/(4 pi R²), so for constant
// rho and any E(x) the irradiance is H = <E>/(1-<rho>), <> the mean over the area.
#include <difusa/radiosity/system.h>
#include <difusa/scene/light_groups.h>

#include <support/discretised.h>
#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace difusa::sphere_test {
namespace {

constexpr double rho = 0.6;
constexpr std::size_t N = 128;

/// A sphere seen from inside; its northern half emits 5, its southern half 1.
Scene two_halves(const Mesh& mesh) {
    Scene scene = test::uniform_scene(mesh, rho, 1.0);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].emission = Rgb::Constant(5.0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        scene.mesh.material[t] = mesh.at(t, 1.0 / 3, 1.0 / 3).position.z() > 0.0 ? 1 : 0;
    }
    return scene;
}

struct Solved {
    Values h;      ///< irradiance at the sites
    Values weight; ///< ∫ of the field = sum of weight · h
    EnergyBalance energy;
};

Solved solve(const Scene& scene, const SiteSet& sites, const std::string& basis, const std::string& engine) {
    const test::Discretised made(scene, sites, engine, basis);
    const auto system = std::make_shared<RadiositySystem>(
        SystemParts{std::shared_ptr<const Scene>(std::shared_ptr<void>(), &made.scene), made.engine,
                    test::plugin<Directions>("low-discrepancy"), test::plugin<Solver>("krylov"), made.discretisation,
                    made.gathered(N), 1});
    LightingOptions options{all_lights(scene)};
    options.solve.tolerance = 1e-12;
    const Solution solution = system->solve(system->parts().scene, options, Execution{});
    const std::vector<double>& integrals = made.discretisation.integrals;
    const Eigen::Map<const Eigen::VectorXd> A(integrals.data(), static_cast<Eigen::Index>(integrals.size()));
    return {solution.irradiance, made.discretisation.projection->transposed(A), solution.energy};
}

TEST(SphereFromInside, IrradianceIsTheMeanEmissionOverOneLessReflectance) {
    const Mesh mesh = test::icosphere(3, 2.0, true);
    const Scene scene = two_halves(mesh);
    double emitted = 0.0, square = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const double E = scene.materials[scene.mesh.material[t]].emission[0];
        emitted += mesh.areas[t] * E / mesh.area;
        square += mesh.areas[t] * E * E / mesh.area;
    }
    const double exact = emitted / (1.0 - rho);
    // The first term of the error is the noise of the direct light of N rays, variance at most e Var(E)/N (scrambled
    // nets, Owen 1997); later bounces average over sites and add less than rho/(1-rho) of the same in the mean square.
    // The facets of this sphere differ from it by 1 - cos(4°) or so: 0.3 % of the light goes astray.
    const double deviation = std::sqrt(std::numbers::e * (square - emitted * emitted) / static_cast<double>(N));
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.45);
    for (const std::string& engine : test::plugin_names<Visibility>()) {
        for (const std::string& basis : test::plugin_names<Basis>()) {
            SCOPED_TRACE(engine + ", " + basis);
            const Solved solved = solve(scene, sites, basis, engine);
            double mean = 0.0, area = 0.0;
            for (std::size_t j = 0; j < sites.size(); ++j) {
                EXPECT_NEAR(solved.h(static_cast<Eigen::Index>(j), 0), exact,
                            5.0 * deviation / (1.0 - rho) + 0.003 * exact);
                mean += solved.weight(static_cast<Eigen::Index>(j), 0) * solved.h(static_cast<Eigen::Index>(j), 0);
                area += solved.weight(static_cast<Eigen::Index>(j), 0);
            }
            // In the mean over the sphere the noise of the sites' sets cancels: 32 independent ones at the least.
            EXPECT_NEAR(mean / area, exact, 5.0 * deviation / (1.0 - rho) / std::sqrt(32.0) + 0.003 * exact);
        }
    }
}

TEST(SphereFromInside, WhatIsEmittedIsAbsorbed) {
    const Scene scene = two_halves(test::icosphere(3, 2.0, true));
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.45);
    for (const std::string& engine : test::plugin_names<Visibility>()) {
        for (const std::string& basis : test::plugin_names<Basis>()) {
            if (!test::plugin<Basis>(basis)->partition_of_unity()) {
                continue;
            }
            const Solved solved = solve(scene, sites, basis, engine);
            const EnergyBalance& energy = solved.energy;
            double emitted = 0.0;
            for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
                emitted += scene.mesh.areas[t] * scene.materials[scene.mesh.material[t]].emission[0];
            }
            EXPECT_NEAR(energy.emitted[0], emitted, 1e-12 * emitted);
            EXPECT_EQ(energy.escaped[0], 0.0);
            EXPECT_EQ(energy.blocked[0], 0.0);
            EXPECT_EQ(energy.from_sky[0], 0.0);
            // absorbed = (1-rho) ∫ h, and <h> is within the bound of the test above: 5 sqrt(4 e/128)/sqrt(32)/3 = 0.086
            // relative to <E> = 3, plus the facets.
            EXPECT_LT(std::abs(energy.imbalance[0]), 0.09) << basis << " " << engine;
            EXPECT_NEAR(energy.absorbed[0] + energy.imbalance[0] * emitted, emitted, 1e-12 * emitted);
        }
    }
}

TEST(Energy, BalancesExactlyInAFurnace) {
    for (const Mesh& mesh : {test::l_room(), test::room_with_block()}) {
        Scene scene = test::uniform_scene(mesh, rho, 1.0);
        scene.materials.push_back(scene.materials[0]);
        const SiteSet sites = test::poisson_sites(scene.mesh, 0.25);
        for (const std::string& basis : test::plugin_names<Basis>()) {
            if (test::plugin<Basis>(basis)->partition_of_unity()) {
                const Solved solved = solve(scene, sites, basis, "cgal");
                EXPECT_LT(std::abs(solved.energy.imbalance[0]), 1e-11) << basis;
            }
        }
    }
}

} // namespace
} // namespace difusa::sphere_test
