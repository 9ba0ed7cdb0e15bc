// Thermal scenes baked whole, against closed forms and identities.
#include <difusa/bake/relight.h>
#include <difusa/core/error.h>
#include <difusa/form_factors/enclosure.h>

#include <meshes.h>
#include <scratch_directory.h>
#include <support/lit_scenes.h>
#include <support/plugins.h>
#include <support/saved_bakes.h>
#include <support/thermal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa::thermal_bakes_test {
namespace {

using test::at_temperature;
using test::surface_of;
using test::thermal_scene;
using test::with_heat;
using test::with_net_flux;

double black(double temperature) {
    return excess_power(temperature, 0.0);
}

BakeResult baked(const Scene& scene, const BakeOptions& options) {
    return lit::baked(scene, options);
}

BakeOptions exactly_solved(double spacing, std::size_t rays = 64) {
    BakeOptions options = lit::quick(spacing, rays);
    options.solve.tolerance = 1e-13;
    return options;
}

/// Where everything is as warm, nothing exchanges heat, however warm the surroundings that it does not see are; what is
/// adiabatic or has a heat of 0 gets this temperature, too. Rounding, grown by the reflections: 1 / (1 - 0.9).
TEST(ThermalBake, AnIsothermalEnclosureExchangesNothing) {
    const double T = 350.0;
    const std::vector<Material> sides{at_temperature(T, 0.9), at_temperature(T, 0.1), with_net_flux(0.0, 0.5),
                                      with_heat(0.0, 0.3),    at_temperature(T, 1.0), at_temperature(T, 0.5)};
    for (const std::optional<double> surroundings : {std::optional<double>(), std::optional<double>(200.0)}) {
        const BakeResult result = baked(thermal_scene(test::closed_cube(), sides, surroundings), exactly_solved(0.25));
        const double rounding = 1e-11 * black(T);
        EXPECT_LE(result.thermal->at_vertices.net_flux.cwiseAbs().maxCoeff(), rounding);
        EXPECT_LE((result.thermal->at_vertices.temperature.array() - T).abs().maxCoeff(), 1e-11 * T);
        EXPECT_LE((result.thermal->at_vertices.irradiation.array() - black(T)).abs().maxCoeff(), rounding);
        EXPECT_LE(std::abs(result.thermal->imbalance()), 6.0 * rounding);
        for (const ThermalSurface& surface : result.thermal->surfaces) {
            EXPECT_NEAR(surface.mean_temperature, T, 1e-11 * T);
        }
    }
}

/// As warm as the surroundings: not even rounding is left.
TEST(ThermalBake, AsWarmAsTheSurroundings) {
    const Scene scene = thermal_scene(test::grid(2, 2), {at_temperature(280.0, 0.7)}, 280.0);
    const BakeResult result = baked(scene, lit::quick(0.3));
    EXPECT_EQ(result.thermal->at_vertices.net_flux.cwiseAbs().maxCoeff(), 0.0);
    EXPECT_EQ(result.thermal->heat, 0.0);
}

/// A convex body sees its surroundings alone: each face has what follows from its own condition, to the bit of the sky.
TEST(ThermalBake, AConvexBodyInItsSurroundings) {
    const double T0 = 250.0;
    const Mesh cube = difusa::box(Vec3::Zero(), Vec3::Ones(), 1, Front::outside);
    const std::vector<Material> sides{at_temperature(400.0, 0.8), at_temperature(0.0, 0.3),  with_net_flux(0.0, 0.5),
                                      with_net_flux(150.0, 0.7),  with_net_flux(-80.0, 0.9), with_heat(60.0, 0.6)};
    const BakeResult result = baked(thermal_scene(cube, sides, T0), lit::quick(0.4));
    const auto expect = [&](Index m, double temperature, double flux) {
        EXPECT_NEAR(surface_of(result, m).least_temperature, temperature, 1e-12 * T0) << m;
        EXPECT_NEAR(surface_of(result, m).largest_temperature, temperature, 1e-12 * T0) << m;
        EXPECT_NEAR(surface_of(result, m).heat, flux, 1e-11 * black(T0)) << m;
    };
    const auto warmed = [&](double flux, double e) {
        return std::pow((black(T0) + flux / e) / stefan_boltzmann, 0.25);
    };
    expect(0, 400.0, 0.8 * (black(400.0) - black(T0)));
    expect(1, 0.0, -0.3 * black(T0));
    expect(2, T0, 0.0);
    expect(3, warmed(150.0, 0.7), 150.0);
    expect(4, warmed(-80.0, 0.9), -80.0);
    expect(5, warmed(60.0, 0.6), 60.0);
    EXPECT_NEAR(result.thermal->to_surroundings, result.thermal->heat, 1e-10 * black(T0));
    // All goes to the surroundings or comes from there: half of what either side gives and takes.
    double given = 0.0, taken = 0.0;
    for (const ThermalSurface& surface : result.thermal->surfaces) {
        (surface.heat > 0.0 ? given : taken) += std::abs(surface.heat);
    }
    EXPECT_NEAR(result.thermal->exchanged, std::max(given, taken), 1e-10 * black(T0));
    EXPECT_EQ(result.thermal->to_backs, 0.0);
}

/// Nearly everything reflects all that arrives: a room of adiabatic walls, a small heater, and a small cold spot. What
/// one gives off the other takes in.
TEST(ThermalBake, AdiabaticWallsConverge) {
    Mesh mesh = test::closed_cube(5); // 300 triangles
    mesh.material.assign(mesh.triangles.size(), 0);
    mesh.material[0] = mesh.material[1] = 1;
    mesh.material[298] = mesh.material[299] = 2;
    const double q = 500.0;
    BakeOptions options = lit::quick(0.1, 512);
    const BakeResult result = baked(
        thermal_scene(mesh, {with_net_flux(0.0, 1.0), with_net_flux(q, 0.8), at_temperature(280.0, 0.9)}), options);
    EXPECT_GT(result.solution.spectral_radius, 0.95);
    EXPECT_LE(result.solution.solve.iterations, 40);
    const double heat = q / 25.0;
    EXPECT_NEAR(surface_of(result, 1).heat, heat, 1e-9 * heat);
    // The level of all temperatures follows from how many rays meet the cold spot: as many as its share of the area,
    // and no more uncertain than independent ones.
    const double met = static_cast<double>(result.system->transport().rays) / (6.0 * 25.0);
    EXPECT_NEAR(surface_of(result, 2).heat, -heat, 3.0 / std::sqrt(met) * heat);
    EXPECT_LE(3.0 / std::sqrt(met), 0.1);
}

/// Mirrored side walls make plates infinite: every ray from one meets the other, so nothing is left to chance, unless a
/// ray is cut off after too many mirrors.
struct Plates {
    double T1, T2, e1, e2;
    double exact() const { return excess_power(T1, T2) / (1.0 / e1 + 1.0 / e2 - 1.0); }
    /// Rounding, grown by the reflections.
    double tolerance() const { return 1e-11 * std::abs(excess_power(T1, T2)) / (1.0 - (1.0 - e1) * (1.0 - e2)); }
};

constexpr double narrow = 0.1;

BakeResult baked_plates(const Mesh& mesh, const std::vector<Material>& materials) {
    BakeOptions options = exactly_solved(0.05);
    options.mirror_depth = 256;
    BakeResult result = baked(thermal_scene(mesh, materials), options);
    EXPECT_EQ(result.system->transport().cut_off.maxCoeff(), 0.0);
    return result;
}

TEST(ThermalBake, InfinitePlates) {
    for (const Plates& plates : {Plates{500, 300, 0.8, 0.6}, Plates{300, 77, 0.05, 0.02}, Plates{400, 0, 1.0, 1.0},
                                 Plates{300.00, 300.01, 0.9, 0.5}}) {
        const Mesh mesh = test::mirrored_plates(narrow);
        const BakeResult result = baked_plates(
            mesh, {at_temperature(plates.T1, plates.e1), at_temperature(plates.T2, plates.e2), test::perfect_mirror()});
        EXPECT_NEAR(surface_of(result, 0).heat, plates.exact(), plates.tolerance());
        EXPECT_NEAR(surface_of(result, 1).heat, -plates.exact(), plates.tolerance());
        EXPECT_EQ(surface_of(result, 2).heat, 0.0);
        for (Eigen::Index v = 0; v < result.thermal->at_vertices.net_flux.rows(); ++v) {
            const Index m = mesh.material[result.mesh.vertices[static_cast<std::size_t>(v)].face];
            const double flux = m == 0 ? plates.exact() : m == 1 ? -plates.exact() : 0.0;
            EXPECT_NEAR(result.thermal->at_vertices.net_flux(v, 0), flux, plates.tolerance()) << m;
        }
    }
}

/// The flux of two plates, prescribed, has the temperature of the plate as its answer.
TEST(ThermalBake, PrescribedFluxAndHeatAreTheDualOfTemperatures) {
    const Plates plates{500, 300, 0.8, 0.6};
    for (const Material& given : {with_net_flux(plates.exact(), plates.e1), with_heat(plates.exact(), plates.e1)}) {
        const BakeResult result = baked_plates(test::mirrored_plates(narrow),
                                               {given, at_temperature(plates.T2, plates.e2), test::perfect_mirror()});
        for (const double temperature :
             {surface_of(result, 0).least_temperature, surface_of(result, 0).mean_temperature,
              surface_of(result, 0).largest_temperature}) {
            EXPECT_NEAR(temperature, plates.T1, 1e-9 * plates.T1);
        }
        EXPECT_NEAR(surface_of(result, 0).heat, plates.exact(), 1e-9 * plates.exact());
        EXPECT_NEAR(surface_of(result, 1).heat, -plates.exact(), 1e-9 * plates.exact());
    }
}

/// N sheets of one temperature each, both of whose sides radiate, between infinite plates.
TEST(ThermalBake, RadiationShields) {
    const double T1 = 600, T2 = 300, e = 0.8, es = 0.1;
    for (const int shields : {1, 2}) {
        Mesh mesh = test::mirrored_plates(narrow);
        std::vector<Material> materials{at_temperature(T1, e), at_temperature(T2, e), test::perfect_mirror()};
        for (int k = 0; k < shields; ++k) {
            const double z = narrow * (k + 1.0) / (shields + 1.0);
            difusa::add(mesh, difusa::rectangle(Vec3(0, 0, z), Vec3(1, 0, 0), Vec3(0, 1, 0)),
                        static_cast<Index>(3 + k));
            difusa::add(mesh, difusa::rectangle(Vec3(0, 0, z), Vec3(0, 1, 0), Vec3(1, 0, 0)),
                        static_cast<Index>(3 + k));
            materials.push_back(with_heat(0.0, es));
        }
        const BakeResult result = baked_plates(mesh, materials);
        const double outer = 1.0 / e + 1.0 / es - 1.0, inner = 2.0 / es - 1.0;
        const double q = excess_power(T1, T2) / (2.0 * outer + (shields - 1) * inner);
        const double tolerance = 1e-9 * excess_power(T1, T2);
        EXPECT_NEAR(surface_of(result, 0).heat, q, tolerance) << shields;
        EXPECT_NEAR(surface_of(result, 1).heat, -q, tolerance) << shields;
        for (int k = 0; k < shields; ++k) {
            const ThermalSurface& shield = surface_of(result, static_cast<Index>(3 + k));
            EXPECT_NEAR(shield.heat, 0.0, 1e-9 * q);
            EXPECT_EQ(shield.least_temperature, shield.largest_temperature);
            EXPECT_NEAR(black(shield.mean_temperature), black(T1) - q * (outer + k * inner), tolerance);
        }
    }
}

/// T -> k T makes all fluxes k⁴ times as large: the same operator, and the same random numbers.
TEST(ThermalBake, FluxesGrowWithTheFourthPower) {
    const auto scene = [](double k) {
        const double k4 = std::pow(k, 4);
        return thermal_scene(test::closed_cube(),
                             {at_temperature(400 * k, 0.9), at_temperature(300 * k, 0.5), with_net_flux(0.0, 0.5),
                              with_heat(30.0 * k4, 0.3), with_net_flux(-40.0 * k4, 0.8), at_temperature(250 * k, 1.0)},
                             280.0 * k);
    };
    const BakeResult one = baked(scene(1.0), exactly_solved(0.25)), more = baked(scene(1.5), exactly_solved(0.25));
    const ThermalValues &a = one.thermal->at_vertices, &b = more.thermal->at_vertices;
    const double k4 = std::pow(1.5, 4);
    EXPECT_LE((b.net_flux - k4 * a.net_flux).cwiseAbs().maxCoeff(), 1e-10 * k4 * black(400));
    EXPECT_LE((b.temperature - 1.5 * a.temperature).cwiseAbs().maxCoeff(), 1e-9 * 400);
}

/// Heat that is drawn is the mirror image of heat that is brought, to the bit, also where a small surface's is
/// evaluated at points and sampled, and in the estimate of errors.
TEST(ThermalBake, DrawnHeatIsNegativeHeat) {
    const auto result_of = [](double sign) {
        Mesh mesh = test::closed_cube(3);
        mesh.material.assign(mesh.triangles.size(), 0);
        mesh.material[4] = 1; // 1/54 of the surface: an area light
        mesh.material[40] = 2;
        add(mesh, difusa::box(Vec3(0.4, 0.3, 0.2), Vec3(0.6, 0.7, 0.5), 1, Front::outside), 3); // in between
        std::vector<Material> materials{at_temperature(300.0, 0.4), with_net_flux(sign * 100.0, 0.8),
                                        with_net_flux(sign * -20.0, 0.8)};
        materials.resize(9, with_net_flux(0.0, 1.0));
        BakeOptions options = lit::quick(0.3);
        options.error_points = 64;
        return baked(thermal_scene(mesh, materials), options);
    };
    const BakeResult brought = result_of(1.0), drawn = result_of(-1.0);
    ASSERT_GT(brought.solution.area_lights, 0U);
    EXPECT_EQ(brought.solution.area_lights, drawn.solution.area_lights);
    EXPECT_EQ(brought.output.H, Values(-drawn.output.H));
    EXPECT_EQ(brought.solution.h, Values(-drawn.solution.h));
    EXPECT_EQ(brought.solution.energy.absorbed[0], -drawn.solution.energy.absorbed[0]);
    EXPECT_EQ(brought.errors->error, drawn.errors->error);
    EXPECT_EQ(brought.error->total.high, drawn.error->total.high);
}

/// A ball in a ball. The formula is that of uniform radiosities; on polyhedra the irradiation varies.
/// A closed box whose temperatures follow from heat alone beside one at 300 K: whatever the rays and the solver leave
/// between them is no reason to find any.
TEST(ThermalBake, ABoxOnItsOwnHasNoTemperature) {
    Mesh mesh = box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside);
    for (Index& m : mesh.material) {
        m = std::min<Index>(m, 2);
    }
    add(mesh, box(Vec3(3, 0, 0), Vec3(4, 1, 1), 1, Front::inside), 3);
    const Scene scene = thermal_scene(
        mesh, {with_heat(50.0, 0.8), with_heat(-50.0, 0.8), with_heat(0.0, 0.5), at_temperature(300.0, 0.9)});
    BakeOptions options = lit::quick(0.4, 64);
    options.error_points = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        options.seed = seed;
        EXPECT_THROW(baked(scene, options), InputError) << seed;
    }
}

TEST(ThermalBake, ConcentricSpheres) {
    const double T1 = 500, T2 = 300, e1 = 0.8, e2 = 0.6;
    Mesh mesh = test::icosphere(2, 1.0);
    add(mesh, test::icosphere(2, 2.0, true), 1);
    double A1 = 0.0, A2 = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        (mesh.material[t] == 0 ? A1 : A2) += mesh.areas[t];
    }
    BakeOptions options = lit::quick(0.25, 256);
    options.error_points = 128;
    const BakeResult result = baked(thermal_scene(mesh, {at_temperature(T1, e1), at_temperature(T2, e2)}), options);
    const double expected = A1 * excess_power(T1, T2) / (1.0 / e1 + A1 / A2 * (1.0 / e2 - 1.0));
    // The surfels of a polyhedron of 320 faces see the inner one under form factors that differ by less than 2 % (its
    // radius, 1 to 0.97 in the middle of faces); what that makes of the heat is of second order, and the rest is the
    // error of the irradiation, as estimated.
    const double of_rays = result.error->total.high * (e1 * A1 + e2 * A2) / 2.0;
    EXPECT_NEAR(surface_of(result, 0).heat, expected, 0.02 * 0.02 * expected + of_rays);
    EXPECT_NEAR(surface_of(result, 1).heat, -expected, 0.02 * 0.02 * expected + of_rays);
    EXPECT_LE(of_rays, 0.02 * expected);
}

/// The errors of the materials do not depend on the output mesh.
TEST(ThermalBake, ErrorsOfMaterialsAreThoseOfTheSurface) {
    BakeOptions options = lit::quick(0.2);
    options.error_points = 256;
    const std::vector<Material> sides{at_temperature(400, 0.8), at_temperature(300, 0.5), at_temperature(300, 0.5),
                                      at_temperature(350, 0.9), at_temperature(500, 0.3), at_temperature(300, 0.7)};
    std::vector<BakeResult> results;
    for (const double spacing : {0.05, 10.0}) {
        options.output_spacing = spacing;
        results.push_back(baked(thermal_scene(test::closed_cube(), sides), options));
    }
    ASSERT_NE(results[0].mesh.vertices.size(), results[1].mesh.vertices.size());
    for (std::size_t m = 0; m < sides.size(); ++m) {
        EXPECT_GT(results[0].thermal->surfaces[m].error, 0.0);
        EXPECT_EQ(results[0].thermal->surfaces[m].error, results[1].thermal->surfaces[m].error);
    }
}

/// The heats of a closed enclosure add up to 0, but for the error of the irradiation: |sum Q| <= area times its rms.
TEST(ThermalBake, HeatIsBalanced) {
    BakeOptions options = lit::quick(0.15, 128);
    options.error_points = 256;
    const BakeResult result =
        baked(thermal_scene(test::closed_cube(),
                            {at_temperature(600, 0.8), at_temperature(300, 0.3), with_net_flux(0.0, 0.5),
                             with_net_flux(150.0, 0.7), with_heat(-80.0, 0.9), at_temperature(450, 1.0)}),
              options);
    EXPECT_LE(std::abs(result.thermal->heat), 6.0 * result.error->total.high);
    EXPECT_LE(result.error->total.high, 0.01 * black(600));
    EXPECT_NEAR(surface_of(result, 3).heat, 150.0, 1e-9 * 150.0);
    EXPECT_NEAR(surface_of(result, 4).heat, -80.0, 1e-4);
    EXPECT_EQ(result.thermal->to_surroundings, 0.0);
}

/// Surfaces of uniform radiosity, ever smaller ones, come ever closer to the fields of a bake.
TEST(ThermalBake, EnclosuresConvergeToIt) {
    const std::vector<Material> sides{at_temperature(600, 0.8),  at_temperature(300, 0.3), with_net_flux(0.0, 0.5),
                                      with_net_flux(150.0, 0.7), at_temperature(300, 0.9), at_temperature(450, 0.6)};
    BakeOptions options = lit::quick(0.08, 512);
    options.error_points = 256;
    const BakeResult result = baked(thermal_scene(test::closed_cube(), sides), options);
    std::vector<double> off;
    for (const int n : {1, 2, 6}) {
        Scene scene = thermal_scene(test::closed_cube(n), sides);
        settle_thermal(scene);
        Surfaces surfaces;
        for (Index t = 0; t < scene.mesh.triangles.size(); ++t) { // two triangles make a square
            surfaces.of.push_back(t / 2);
        }
        std::vector<Index> material;
        for (std::size_t s = 0; 2 * s < surfaces.of.size(); ++s) {
            surfaces.name.push_back(std::to_string(s));
            material.push_back(scene.mesh.material[2 * s]);
        }
        const FormFactors F = form_factors(scene.mesh, surfaces, {1e-6}, Execution{2});
        const Enclosure enclosure = solve_enclosure(scene, F, material, surfaces.name, Execution{1});
        double largest = 0.0;
        for (Index m = 0; m < 6; ++m) {
            double heat = 0.0;
            for (const EnclosureSurface& surface : enclosure.surfaces) {
                heat += surface.material == m ? surface.area * surface.state.net_flux : 0.0;
            }
            largest = std::max(largest, std::abs(heat - surface_of(result, m).heat));
        }
        off.push_back(largest);
    }
    // The difference falls at least in proportion to their size, to below what the bake itself may be off by.
    EXPECT_GT(off[0], 2.0 * off[1]);
    EXPECT_GT(off[1], 3.0 * off[2]);
    EXPECT_LE(off[2], result.error->total.high);
    EXPECT_LE(result.error->total.high, 0.5 * off[0]); // it can tell them apart
}

TEST(ThermalBake, IsTheSameForAnyNumberOfThreadsAndRelit) {
    const auto scene = [](double T) {
        return thermal_scene(test::closed_cube(),
                             {at_temperature(T, 0.9), at_temperature(300, 0.5), with_net_flux(0.0, 0.5),
                              with_heat(30.0, 0.3), with_net_flux(-40.0, 0.8), at_temperature(250, 1.0)});
    };
    BakeOptions options = test::relightable("gather", "");
    options.error_points = 48;
    const BakeResult one = bake(test::registry(), scene(400), "scene", options, Execution{1});
    const BakeResult four = bake(test::registry(), scene(400), "scene", options, Execution{4});
    EXPECT_EQ(one.thermal->at_vertices.temperature, four.thermal->at_vertices.temperature);
    EXPECT_EQ(one.thermal->at_vertices.net_flux, four.thermal->at_vertices.net_flux);
    EXPECT_EQ(one.errors->error, four.errors->error);
    const BakeResult warmer = bake(test::registry(), scene(420), "scene", options, Execution{1});
    const SavedTransport saved = test::through_file(one);
    RelightOptions how;
    how.bake = relight_defaults(saved);
    how.bake.error_points = 48;
    const BakeResult relit = relight(test::registry(), saved, scene(420), "scene", how, Execution{1});
    EXPECT_EQ(relit.thermal->at_vertices.temperature, warmer.thermal->at_vertices.temperature);
    EXPECT_EQ(relit.thermal->at_vertices.net_flux, warmer.thermal->at_vertices.net_flux);
    how.change.emission.emplace_back("side", Rgb::Ones());
    EXPECT_THROW(relight(test::registry(), saved, scene(420), "scene", how, Execution{1}), UsageError);
}

/// Whatever solver, basis and projection: infinite plates, whose fields are constant.
TEST(ThermalBake, AnySolverBasisAndGather) {
    const std::vector<Material> sides{at_temperature(400, 0.9), with_net_flux(-50.0, 0.5), with_net_flux(0.0, 0.5),
                                      with_net_flux(40.0, 0.8), at_temperature(250, 1.0),  at_temperature(250, 1.0)};
    const Scene scene = thermal_scene(test::closed_cube(), sides);
    const BakeResult expected = baked(scene, exactly_solved(0.25));
    for (const std::string& solver : test::plugin_names<Solver>()) {
        BakeOptions options = exactly_solved(0.25);
        options.solver = solver;
        options.solve.tolerance = 1e-9;
        options.solve.max_iterations = 100000;
        const BakeResult result = baked(scene, options);
        EXPECT_LE(
            (result.thermal->at_vertices.irradiation - expected.thermal->at_vertices.irradiation).cwiseAbs().maxCoeff(),
            1e-6 * black(400))
            << solver;
    }
}

} // namespace
} // namespace difusa::thermal_bakes_test
