// Exchange between the surfaces of an enclosure by their form factors, against networks and a naive elimination.
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/form_factors/closure.h>
#include <difusa/form_factors/enclosure.h>
#include <difusa/study/references/form_factors.h>

#include <meshes.h>
#include <support/refusal.h>
#include <support/thermal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa::enclosure_test {
namespace {

using test::at_temperature;
using test::thermal_scene;
using test::with_heat;
using test::with_net_flux;

/// sigma T⁴.
double black(double temperature) {
    return stefan_boltzmann * std::pow(temperature, 4);
}

FormFactors factors_of(const Scene& scene, const Surfaces& surfaces, double tolerance) {
    return form_factors(scene.mesh, surfaces, {tolerance}, Execution{});
}

/// Between materials, backs apart.
struct Solved {
    Surfaces surfaces;
    Enclosure enclosure;
    double flux(const std::string& name) const { return at(name).state.net_flux; }
    double temperature(const std::string& name) const { return at(name).state.temperature; }
    double heat(const std::string& name) const { return at(name).area * flux(name); }
    const EnclosureSurface& at(const std::string& name) const {
        for (std::size_t i = 0; i < surfaces.size(); ++i) {
            if (surfaces.name[i] == name) {
                return enclosure.surfaces[i];
            }
        }
        throw InternalError("no surface " + name);
    }
};

Enclosure solve(const Scene& scene, const FormFactors& F, const Surfaces& surfaces) {
    std::vector<Index> material(surfaces.size());
    for (std::size_t t = 0; t < surfaces.of.size(); ++t) {
        material[surfaces.of[t]] = scene.mesh.material[t];
    }
    return solve_enclosure(scene, F, material, surfaces.name, Execution{1});
}

/// `close`: makes the factors those of a closed surface exactly. Of two surfaces, one of which does not see itself,
/// they are then exact but for rounding.
Solved by_material(Scene scene, double tolerance = 1e-8, bool close = false) {
    settle_thermal(scene);
    const Surfaces surfaces = with_backs_apart(scene.mesh, surfaces_by_material(scene.mesh, scene.materials));
    FormFactors F = factors_of(scene, surfaces, tolerance);
    if (close) {
        enforce_closure(F);
    }
    return {surfaces, solve(scene, F, surfaces)};
}

/// b - rho F b = E by elimination, everything in absolute terms, in a cube whose factors are known in closed form.
std::vector<double> radiosities_in_cube(const std::vector<Material>& sides) {
    std::vector<std::vector<double>> M(6, std::vector<double>(7));
    for (std::size_t i = 0; i < 6; ++i) {
        const Thermal& thermal = *sides[i].thermal;
        const bool fixed = thermal.given == Thermal::Given::temperature;
        const double rho = fixed ? 1.0 - thermal.emissivity : 1.0;
        for (std::size_t j = 0; j < 6; ++j) {
            const double F = i == j ? 0.0 : i / 2 == j / 2 ? 0.199824895698387 : 0.200043776075403;
            M[i][j] = (i == j ? 1.0 : 0.0) - rho * F;
        }
        M[i][6] = fixed ? thermal.emissivity * black(thermal.value) : thermal.value;
    }
    for (std::size_t k = 0; k < 6; ++k) { // diagonally dominant: no pivoting
        for (std::size_t i = 0; i < 6; ++i) {
            if (i != k) {
                const double factor = M[i][k] / M[k][k];
                for (std::size_t j = k; j < 7; ++j) {
                    M[i][j] -= factor * M[k][j];
                }
            }
        }
    }
    std::vector<double> b;
    for (std::size_t k = 0; k < 6; ++k) {
        b.push_back(M[k][6] / M[k][k]);
    }
    return b;
}

TEST(Enclosure, CubeWithAllKindsOfSides) {
    const std::vector<Material> sides{at_temperature(600, 0.8, "0"),  at_temperature(300, 0.3, "1"),
                                      with_net_flux(0.0, 0.5, "2"),   with_net_flux(150.0, 0.7, "3"),
                                      with_net_flux(-80.0, 0.9, "4"), at_temperature(450, 1.0, "5")};
    const Solved solved = by_material(thermal_scene(test::closed_cube(), sides));
    const std::vector<double> b = radiosities_in_cube(sides);
    // The factors are within 1e-8: relative errors grow to some 1e-7 of the largest power.
    const double tolerance = 1e-7 * black(600);
    for (std::size_t i = 0; i < 6; ++i) {
        const EnclosureSurface& surface = solved.at(std::to_string(i));
        const Thermal& thermal = *sides[i].thermal;
        EXPECT_NEAR(surface.state.radiosity, b[i], tolerance) << i;
        if (thermal.given == Thermal::Given::temperature) {
            const double q = thermal.emissivity < 1.0
                                 ? thermal.emissivity / (1.0 - thermal.emissivity) * (black(thermal.value) - b[i])
                                 : surface.state.radiosity - surface.state.irradiation;
            EXPECT_NEAR(surface.state.net_flux, q, 10.0 * tolerance) << i;
        } else {
            const double power = b[i] + thermal.value * (1.0 - thermal.emissivity) / thermal.emissivity;
            EXPECT_NEAR(black(surface.state.temperature), power, tolerance) << i;
        }
    }
    EXPECT_NEAR(solved.enclosure.heat, solved.enclosure.to_surroundings, 1e-11 * black(600)); // reciprocity is exact
    EXPECT_NEAR(solved.enclosure.heat, 0.0, tolerance);
}

/// Two plates and what joins them, adiabatic: the network of three nodes.
TEST(Enclosure, ReradiatingWalls) {
    const double gap = 0.7, T1 = 700, T2 = 350, e1 = 0.6, e2 = 0.85;
    Mesh mesh = difusa::box(Vec3::Zero(), Vec3(1, 1, gap), 1, Front::inside);
    for (Index& m : mesh.material) {
        m = m == 4 ? 0 : m == 5 ? 1 : 2;
    }
    const Solved solved = by_material(thermal_scene(
        mesh, {at_temperature(T1, e1, "hot"), at_temperature(T2, e2, "cold"), with_net_flux(0.0, 0.3, "walls")}));
    const double F12 = opposite_rectangles(1.0, 1.0, gap), F1R = 1.0 - F12;
    const double between = 1.0 / (F12 + 1.0 / (2.0 / F1R));
    const double Q = (black(T1) - black(T2)) / ((1.0 - e1) / e1 + between + (1.0 - e2) / e2);
    EXPECT_NEAR(solved.heat("hot"), Q, 1e-7 * black(T1));
    EXPECT_NEAR(solved.heat("cold"), -Q, 1e-7 * black(T1));
    EXPECT_NEAR(solved.heat("walls"), 0.0, 1e-12);
    const double J1 = black(T1) - Q * (1.0 - e1) / e1, J2 = black(T2) + Q * (1.0 - e2) / e2;
    EXPECT_NEAR(black(solved.temperature("walls")), 0.5 * (J1 + J2), 1e-7 * black(T1)); // in the middle by symmetry
}

/// A cube in a cube: the formula of two surfaces, one of which does not see itself.
TEST(Enclosure, ConvexBodyInAnother) {
    const double T1 = 500, T2 = 300, e1 = 0.4, e2 = 0.7;
    Mesh mesh = test::moved(test::box({1, 1, 1}, 1), 1.0, Vec3::Constant(-0.5));
    difusa::add(mesh, test::moved(test::box({2, 2, 2}, 1, true), 1.0, Vec3::Constant(-1.0)), 1);
    const double expected = (black(T1) - black(T2)) / (1.0 / e1 + 0.25 * (1.0 / e2 - 1.0));
    const std::vector<Material> fixed{at_temperature(T1, e1, "in"), at_temperature(T2, e2, "out")};
    const Solved rough = by_material(thermal_scene(mesh, fixed), 1e-2);
    EXPECT_LE(std::abs(rough.flux("in") - expected), rough.at("in").net_flux_error);
    const Solved solved = by_material(thermal_scene(mesh, fixed), 1e-2, true);
    EXPECT_NEAR(solved.flux("in"), expected, 1e-9 * expected);
    EXPECT_NEAR(solved.heat("out"), -6.0 * expected, 1e-8 * expected);
    // The same heat, prescribed, as flux or as heat: the same temperature.
    for (const Material& inner : {with_net_flux(expected, e1, "in"), with_heat(6.0 * expected, e1, "in")}) {
        const Solved back = by_material(thermal_scene(mesh, {inner, fixed[1]}), 1e-2, true);
        EXPECT_NEAR(back.temperature("in"), T1, 1e-9 * T1);
        EXPECT_NEAR(back.heat("in"), 6.0 * expected, 1e-8 * expected);
    }
}

/// Three nested cubes, the middle one a thin sheet whose two sides have one temperature and exchange no heat in all.
TEST(Enclosure, RadiationShield) {
    const double T1 = 800, T2 = 300, e1 = 0.8, es = 0.05, e2 = 0.9;
    const auto cube = [](double size, bool inward) {
        return test::moved(test::box(Vec3::Constant(size), 1, inward), 1.0, Vec3::Constant(-0.5 * size));
    };
    Mesh mesh = cube(1.0, false);
    difusa::add(mesh, cube(2.0, true), 1);
    const std::size_t back = mesh.triangles.size();
    difusa::add(mesh, cube(2.0, false), 1);
    difusa::add(mesh, cube(3.0, true), 2);
    Scene scene = thermal_scene(
        mesh, {at_temperature(T1, e1, "in"), with_heat(0.0, es, "shield"), at_temperature(T2, e2, "out")});
    settle_thermal(scene);
    Surfaces surfaces = surfaces_by_material(scene.mesh, scene.materials);
    surfaces.name = {"in", "shield", "out", "shield (back)"};
    for (std::size_t t = back; t < back + 12; ++t) {
        surfaces.of[t] = 3;
    }
    FormFactors F = factors_of(scene, surfaces, 1e-2);
    enforce_closure(F);
    const Solved solved{surfaces, solve(scene, F, surfaces)};
    const double A1 = 6, As = 24, A2 = 54;
    const double inside = 1.0 / A1 * (1.0 / e1) + 1.0 / As * (1.0 / es - 1.0);
    const double outside = 1.0 / As * (1.0 / es) + 1.0 / A2 * (1.0 / e2 - 1.0);
    const double Q = (black(T1) - black(T2)) / (inside + outside);
    EXPECT_NEAR(solved.heat("in"), Q, 1e-8 * Q);
    EXPECT_NEAR(solved.heat("shield"), -Q, 1e-8 * Q);
    EXPECT_NEAR(solved.heat("shield (back)"), Q, 1e-8 * Q);
    EXPECT_EQ(solved.temperature("shield"), solved.temperature("shield (back)"));
    EXPECT_NEAR(black(solved.temperature("shield")), black(T1) - Q * inside, 1e-8 * black(T1));
}

TEST(Enclosure, PlatesInTheOpen) {
    const double T1 = 500, T2 = 400, T0 = 250;
    const Mesh mesh = [] {
        Mesh plates = test::grid(1, 1);
        difusa::add(plates, test::moved(test::grid(1, 1, 1.0, 1.0, true), 1.0, Vec3(0, 0, 0.5)), 1);
        return plates;
    }();
    const Solved solved =
        by_material(thermal_scene(mesh, {at_temperature(T1, 1.0, "low"), at_temperature(T2, 1.0, "high")}, T0));
    const double F = opposite_rectangles(1.0, 1.0, 0.5);
    EXPECT_NEAR(solved.flux("low"), black(T1) - F * black(T2) - (1.0 - F) * black(T0), 1e-7 * black(T1));
    EXPECT_NEAR(solved.flux("high"), black(T2) - F * black(T1) - (1.0 - F) * black(T0), 1e-7 * black(T1));
    EXPECT_NEAR(solved.enclosure.to_surroundings, solved.enclosure.heat, 1e-12 * black(T1));
}

/// What is said of the errors holds whatever the signs of those of the factors.
TEST(Enclosure, ErrorsOfTheFactorsAreCarriedOn) {
    const std::vector<Material> sides{at_temperature(600, 0.8),  at_temperature(300, 0.3), with_net_flux(0.0, 0.5),
                                      with_net_flux(150.0, 0.7), with_heat(-80.0, 0.9),    at_temperature(450, 1.0)};
    Scene scene = thermal_scene(test::closed_cube(), sides);
    settle_thermal(scene);
    const Surfaces surfaces = surfaces_by_material(scene.mesh, scene.materials);
    FormFactors F = factors_of(scene, surfaces, 1e-8);
    constexpr double error = 1e-4;
    for (FormFactors::Row& row : F.rows) {
        std::fill(row.error.begin(), row.error.end(), static_cast<float>(error));
    }
    const Enclosure right = solve(scene, F, surfaces);
    for (std::uint64_t draw = 0; draw < 20; ++draw) {
        RandomStream random(draw, "errors");
        FormFactors wrong = F;
        for (FormFactors::Row& row : wrong.rows) {
            for (double& factor : row.factor) {
                factor += error * (2.0 * random.uniform() - 1.0);
            }
        }
        const Enclosure other = solve(scene, wrong, surfaces);
        for (std::size_t i = 0; i < 6; ++i) { // to first order
            const EnclosureSurface &a = right.surfaces[i], &b = other.surfaces[i];
            EXPECT_LE(std::abs(a.state.net_flux - b.state.net_flux), 1.01 * a.net_flux_error + 1e-9) << i;
            EXPECT_LE(std::abs(a.state.temperature - b.state.temperature), 1.01 * a.temperature_error + 1e-9) << i;
        }
    }
}

TEST(Enclosure, RefusesWhatItCannotSolve) {
    const auto refused = [](const Scene& scene) {
        return test::refusal_of([&] { by_material(scene); }, "an enclosure");
    };
    const auto contains = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    contains(refused(thermal_scene(test::grid(1, 1), {at_temperature(300, 0.5, "plate")})), "the enclosure is open");
    // What errors add to a row sum is no opening.
    Scene cube = thermal_scene(test::closed_cube(), std::vector<Material>(6, at_temperature(300, 0.5)));
    settle_thermal(cube);
    const Surfaces surfaces = surfaces_by_material(cube.mesh, cube.materials);
    FormFactors rough = factors_of(cube, surfaces, 1e-6);
    for (double& factor : rough.rows[0].factor) {
        factor *= 1.002;
    }
    contains(test::refusal_of([&] { solve(cube, rough, surfaces); }, "overlaps"), "more than their errors explain");
    rough.rows[0].error.assign(rough.rows[0].factor.size(), 1e-3F);
    contains(test::refusal_of([&] { solve(cube, rough, surfaces); }, "rough factors"), "give a smaller --tolerance");
    contains(refused(thermal_scene(test::mirrored_plates(1.0),
                                   {at_temperature(300, 0.5), at_temperature(400, 0.5), test::perfect_mirror()})),
             "the material mirror is a mirror");
    contains(refused(thermal_scene(test::closed_cube(), std::vector<Material>(6, with_net_flux(0.0, 1.0)), 300.0)),
             "the temperatures are not determined");
    contains(refused(thermal_scene(test::closed_cube(), std::vector<Material>(6, with_heat(0.0, 1.0)), 300.0)),
             "the temperatures are not determined");
    // Heat that is supplied, or drawn, and can only go where errors of the factors lead it.
    for (const double heat : {5.0, -5.0}) {
        std::vector<Material> heated(6, with_net_flux(0.0, 0.8));
        heated[2] = with_heat(heat, 0.8);
        contains(refused(thermal_scene(test::closed_cube(), heated, 300.0)), "the temperatures are not determined");
    }
    std::vector<Material> drawn(6, at_temperature(300, 0.9));
    drawn[2] = with_net_flux(-450.0, 0.9, "sink");
    contains(refused(thermal_scene(test::closed_cube(), drawn)), "more heat is drawn from surface sink");
    drawn[2] = with_heat(-450.0, 0.9, "sink");
    contains(refused(thermal_scene(test::closed_cube(), drawn)), "the material sink would have to be colder than 0 K");
}

} // namespace
} // namespace difusa::enclosure_test
