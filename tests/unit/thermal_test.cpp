// Thermal properties: what they make of materials, and what is refused.
#include <difusa/bake/relight.h>
#include <difusa/core/error.h>
#include <difusa/scene/scene.h>

#include <support/refusal.h>
#include <support/thermal.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace difusa::thermal_test {
namespace {

using test::at_temperature;
using test::thermal_scene;
using test::with_heat;
using test::with_net_flux;

/// Six sides: these materials, the last of them for all that remain.
Scene cube(std::vector<Material> materials, std::optional<double> surroundings = {}) {
    while (materials.size() < 6) {
        materials.push_back(materials.back());
    }
    return thermal_scene(test::closed_cube(), std::move(materials), surroundings);
}

TEST(Thermal, PowersAndTemperaturesAreInverse) {
    EXPECT_NEAR(excess_power(300.0, 0.0), 459.3, 0.05);
    EXPECT_EQ(excess_power(0.0, 0.0), 0.0);
    for (const double reference : {0.0, 2.7, 300.0, 3000.0}) {
        for (const double temperature : {0.0, 1.0, 299.0, 300.0, 1500.0}) {
            const double power = excess_power(temperature, reference);
            // T = (fourth power)^(1/4): rounding of the larger of the two fourth powers, over 4 T³.
            const double largest = std::max(temperature, reference);
            const double rounding = 8e-16 * std::pow(largest, 4) / (4.0 * std::pow(std::max(temperature, 1e-3), 3));
            const std::optional<double> back = temperature_of(power, reference);
            if (temperature > 0.0) {
                ASSERT_TRUE(back.has_value());
                EXPECT_NEAR(*back, temperature, rounding + 1e-15 * temperature) << reference;
            }
        }
    }
    EXPECT_FALSE(temperature_of(-excess_power(300.0, 0.0) * 1.001, 300.0).has_value());
}

TEST(Thermal, SmallDifferencesAreNotLost) {
    // 4 sigma T³ dT (1 + 3/2 dT/T + ...): the next term is (dT/T)², 1e-15.
    const double T = 300.0, dT = 1e-5;
    const double expected = 4.0 * stefan_boltzmann * T * T * T * dT * (1.0 + 1.5 * dT / T);
    // 300 + dT is rounded to a multiple of 2^-44.
    EXPECT_NEAR(excess_power(T + dT, T), expected, 0x1p-45 / dT * expected);
}

TEST(Thermal, MaterialsEmitAndReflect) {
    Material partial = at_temperature(400.0, 0.3);
    partial.mirror = Rgb::Constant(0.5);
    Scene scene = cube({at_temperature(400.0, 0.8), with_net_flux(-20.0, 0.6), with_net_flux(0.0, 1.0), partial,
                        with_heat(5.0, 0.9), at_temperature(300.0, 1.0)},
                       300.0);
    settle_thermal(scene);
    const double power = excess_power(400.0, 300.0);
    const std::vector<double> rho{0.2, 1.0, 1.0, 0.2, 0.1, 0.0}, E{0.8 * power, -20.0, 0.0, 0.3 * power, 0.0, 0.0};
    for (std::size_t m = 0; m < 6; ++m) {
        EXPECT_NEAR(scene.materials[m].reflectance[0], rho[m], 1e-15) << m;
        EXPECT_NEAR(scene.materials[m].emission[0], E[m], 1e-12) << m;
    }
    EXPECT_EQ(scene.thermal->reference, 300.0);
    EXPECT_TRUE(scene.is_grey());
    set_temperature(scene, 4, 350.0);
    EXPECT_NEAR(scene.materials[4].emission[0], 0.9 * excess_power(350.0, 300.0), 1e-12);
}

TEST(Thermal, StatesFollowFromTheIrradiation) {
    Scene scene = cube(
        {at_temperature(400.0, 0.8), with_net_flux(-20.0, 0.5), with_net_flux(0.0, 1.0), at_temperature(300.0, 1.0)},
        300.0);
    settle_thermal(scene);
    const double h = 50.0, black = excess_power(300.0, 0.0), own = excess_power(400.0, 300.0);
    const ThermalState fixed = *thermal_state(scene, 0, h), drawn = *thermal_state(scene, 1, h),
                       adiabatic = *thermal_state(scene, 2, h);
    EXPECT_EQ(fixed.temperature, 400.0);
    EXPECT_NEAR(fixed.net_flux, 0.8 * (own - h), 1e-12);
    EXPECT_NEAR(drawn.temperature, *temperature_of(h - 40.0, 300.0), 1e-12);
    EXPECT_NEAR(adiabatic.temperature, *temperature_of(h, 300.0), 1e-12);
    for (const ThermalState& state : {fixed, drawn, adiabatic}) {
        EXPECT_NEAR(state.irradiation, h + black, 1e-12);
        EXPECT_NEAR(state.radiosity, state.irradiation + state.net_flux, 1e-11);
        EXPECT_NEAR(state.net_flux, state.emissivity * (excess_power(state.temperature, 0.0) - state.irradiation),
                    1e-10);
    }
    EXPECT_FALSE(thermal_state(scene, 1, -black).has_value());
    EXPECT_EQ(thermal_state(scene, 2, -2.0 * black)->temperature, 0.0); // an undershoot
}

TEST(Thermal, WithoutSurroundingsTheMeanIsTheReference) {
    Scene scene = cube({at_temperature(400.0, 0.8), at_temperature(200.0, 0.1), with_net_flux(0.0, 1.0)});
    settle_thermal(scene);
    EXPECT_NEAR(std::pow(scene.thermal->reference, 4), 0.5 * (std::pow(400.0, 4) + std::pow(200.0, 4)), 1e-3);
    Scene even = cube({at_temperature(321.1, 0.8), with_net_flux(0.0, 1.0)});
    settle_thermal(even);
    EXPECT_EQ(even.thermal->reference, 321.1);
    EXPECT_EQ(even.materials[0].emission[0], 0.0);
}

TEST(Thermal, OtherScenesAreLeftAlone) {
    Scene scene = cube({Material()});
    scene.materials[0].emission = Rgb::Constant(3.0);
    settle_thermal(scene);
    EXPECT_FALSE(scene.thermal.has_value());
    EXPECT_EQ(scene.materials[0].emission[0], 3.0);
}

TEST(Thermal, WhatCannotBeIsRefused) {
    const auto refused = [](Scene scene) {
        return test::refusal_of([&] { settle_thermal(scene); }, "a thermal scene");
    };
    const auto contains = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    contains(refused(cube({at_temperature(300, 0.8, "a"), Material()})), "has no thermal properties");
    contains(refused(cube({Material()}, 300.0)), "has no thermal properties");
    contains(refused(cube({at_temperature(-1, 0.8, "cold")})), "the material cold has the temperature -1 K");
    contains(refused(cube({at_temperature(nan, 0.8)})), "from 0 to 1e6 K");
    contains(refused(cube({at_temperature(300, 1.1)})), "the emissivity 1.1");
    contains(refused(cube({with_net_flux(5, 0.0), at_temperature(300, 1)})), "cannot give away or take in heat");
    contains(refused(cube({with_heat(5, 0.0), at_temperature(300, 1)})), "cannot give away or take in heat");
    contains(refused(cube({with_net_flux(5, 1.0)})), "no temperature is known");
    contains(refused(cube({at_temperature(300, 1)}, -5.0)), "the surroundings have the temperature -5 K");
    Scene lit = cube({at_temperature(300, 1)});
    lit.sky = Rgb::Ones();
    contains(refused(lit), "has no lights and no sky");
    Scene shiny = cube({at_temperature(300, 0.8)});
    shiny.materials[0].mirror = Rgb::Constant(0.5);
    contains(refused(shiny), "at most what it does not absorb");
}

BakeOptions coarse() {
    return lit::quick(0.25, 32);
}

TEST(Thermal, OptionsThatAskForLightAreRefused) {
    const auto refused = [](const BakeOptions& options) {
        try {
            lit::baked(cube({at_temperature(300, 0.5)}), options);
        } catch (const UsageError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    BakeOptions sky = coarse(), groups = coarse(), lux = coarse(), at = coarse(), grid = coarse();
    sky.sky = Rgb::Ones();
    groups.light_groups = true;
    lux.units = "photometric";
    at.at.push_back({Vec3::Constant(0.5), Vec3::UnitZ()});
    grid.grids.push_back({"0", 0.0, 0.5, 0.0});
    for (const auto& [options, text] : std::vector<std::pair<BakeOptions, std::string>>{
             {sky, "--sky"}, {groups, "--light-groups"}, {lux, "--units"}, {at, "--at"}, {grid, "--grid"}}) {
        EXPECT_EQ(refused(options).rfind(text, 0), 0U) << refused(options);
    }
}

TEST(Thermal, MoreThanArrivesCannotBeDrawn) {
    const std::string flux = test::refusal_of(
        [] {
            lit::baked(cube({with_net_flux(-400.0, 0.5, "sink"), at_temperature(300, 0.9)}), coarse());
        },
        "a sink");
    EXPECT_NE(flux.find("more heat is drawn from the material sink than arrives"), std::string::npos) << flux;
    const std::string heat = test::refusal_of(
        [] {
            lit::baked(cube({with_heat(-900.0, 0.5, "sink"), at_temperature(300, 0.9)}), coarse());
        },
        "a sink");
    EXPECT_NE(heat.find("the material sink would have to be colder than 0 K"), std::string::npos) << heat;
}

TEST(Thermal, OpenSurfacesNeedSurroundings) {
    Mesh open = test::closed_cube();
    open.triangles.pop_back();
    open.material.pop_back();
    open.original_face.pop_back();
    open.derive();
    const Scene scene = thermal_scene(open, std::vector<Material>(6, at_temperature(300, 0.5)));
    const std::string refused = test::refusal_of([&] { lit::baked(scene, coarse()); }, "an open cube");
    EXPECT_NE(refused.find("of the radiation leaves the surface"), std::string::npos) << refused;
    Scene within = scene;
    within.thermal = ThermalSetting{250.0};
    EXPECT_GT(lit::baked(within, coarse()).thermal->to_surroundings, 0.0);
}

TEST(Thermal, UndeterminedTemperaturesAreRefused) {
    // A closed cube whose net fluxes are all prescribed, in surroundings that it does not see.
    EXPECT_THROW(lit::baked(cube({with_net_flux(0.0, 0.5)}, 300.0), coarse()), NotConverged);
    EXPECT_THROW(lit::baked(cube({with_heat(0.0, 0.5)}, 300.0), coarse()), InputError);
}

} // namespace
} // namespace difusa::thermal_test
