// Powers of lamps for a wanted illuminance.
#include <difusa/bake/lamp_powers.h>
#include <difusa/bake/sensing.h>
#include <difusa/core/colour.h>
#include <difusa/core/error.h>

#include <support/lightings.h>
#include <support/saved_bakes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace difusa::lamp_powers_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Three lamps and a little sky.
Scene with_lamps() {
    Scene scene = test::bare_room();
    scene.sky = Rgb::Constant(0.1);
    scene.point_lights = {{Vec3(0.5, 0.5, 1.0), Rgb::Constant(2)}, {Vec3(1.5, 1.5, 1.2), Rgb(3, 2, 1)}};
    scene.point_lights[0].name = "left";
    scene.point_lights[1].name = "right";
    scene.materials[2].emission = Rgb::Constant(30);
    return scene;
}

RelightOptions with_places(const SavedTransport& saved) {
    RelightOptions how;
    how.bake = relight_defaults(saved);
    how.bake.error_points = 0;
    how.bake.final_gather = 64;
    for (int k = 0; k < 6; ++k) {
        how.bake.at.push_back({Vec3(0.3 + 0.25 * k, 1.7 - 0.2 * k, 0.3), Vec3(0, 0, 1)});
    }
    return how;
}

class Lamps : public testing::Test {
  protected:
    Lamps() {
        BakeOptions options = lit::quick(0.35, 32);
        options.every_surface = true;
        saved = test::through_file(lit::baked(with_lamps(), options));
        how = with_places(saved);
    }
    BakeResult grouped(const Scene& scene) const {
        RelightOptions own = how;
        own.bake.light_groups = true;
        own.evaluate = false;
        BakeResult result = relight(test::registry(), saved, scene, "scene", own, Execution{2, nullptr, nullptr});
        read_places(result, nullptr, Execution{2, nullptr, nullptr});
        return result;
    }
    /// What the places receive.
    Eigen::VectorXd reached(RelightOptions own) const {
        own.bake.light_groups = true;
        own.evaluate = false;
        BakeResult relit = relight(test::registry(), saved, with_lamps(), "scene", own, Execution{2, nullptr, nullptr});
        read_places(relit, nullptr, Execution{2, nullptr, nullptr});
        return relit.readings.H * luminance_weights;
    }

    /// Where shadow rays go, and the samples on bright surfels, depend on the powers.
    static constexpr double of_samples = 0.05;

    SavedTransport saved;
    RelightOptions how;
};

TEST_F(Lamps, MadeUpPowersAreRecovered) {
    const BakeResult result = grouped(with_lamps());
    const std::vector<GroupValues>& groups = result.readings.groups;
    ASSERT_EQ(groups.size(), 4U) << "lamp, left, right, sky";
    const double factors[] = {0.25, 3.0, 0.0, 1.0};
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(6);
    for (std::size_t g = 0; g < 4; ++g) {
        wanted += factors[g] * (groups[g].H * luminance_weights);
    }
    const LampPowers powers = lamp_powers(result, wanted);
    ASSERT_EQ(powers.factors.size(), 3U) << "the sky is no lamp";
    for (std::size_t g = 0; g < 3; ++g) {
        EXPECT_EQ(powers.factors[g].first, groups[g].name);
        EXPECT_NEAR(powers.factors[g].second, factors[g], 1e-10);
    }
    EXPECT_LE(powers.rms(), 1e-10);
    EXPECT_LE((powers.after - wanted).norm(), 1e-10);
}

TEST_F(Lamps, AreScaledInTheRelitScene) {
    const BakeResult result = grouped(with_lamps());
    const LampPowers powers = lamp_powers(result, Eigen::VectorXd::Constant(6, 5.0));
    EXPECT_LT(powers.rms(), (powers.before.array() - 5.0).matrix().norm() / std::sqrt(6.0)) << "better than before";
    EXPECT_THAT(powers.text(), HasSubstr("left x "));
    RelightOptions own = how;
    own.factors = powers.factors;
    EXPECT_LE((reached(own) - powers.after).norm(), of_samples * powers.after.norm());
}

TEST_F(Lamps, FactorsAreOnTheLightsInTheEnd) {
    how.change.scale = {{"left", 0.5}};
    how.change.emission = {{"lamp", Rgb::Constant(20.0)}};
    how.bake.point_lights.push_back({Vec3(0.5, 0.5, 0.6), Rgb::Constant(0.5)});
    const LampPowers powers = lamp_powers(grouped(with_lamps()), Eigen::VectorXd::Constant(6, 5.0));
    ASSERT_EQ(powers.factors.size(), 4U);
    EXPECT_EQ(powers.factors.back().first, "point");
    RelightOptions own = how;
    own.factors = powers.factors;
    EXPECT_LE((reached(own) - powers.after).norm(), of_samples * powers.after.norm());
    own.bake.sky = Rgb::Ones();
    own.change.scale = {{"sky", 2.0}};
    EXPECT_THAT([&] { reached(own); }, ThrowsMessage<UsageError>(HasSubstr("--sky replaces the sky")));
}

TEST_F(Lamps, AreRefusedWithoutPlacesOrLamps) {
    Scene sky = test::bare_room();
    sky.sky = Rgb::Ones();
    EXPECT_THAT([&] { lamp_powers(grouped(sky), Eigen::VectorXd::Ones(6)); },
                ThrowsMessage<UsageError>(HasSubstr("no lamp")));
    how.bake.at.clear();
    EXPECT_THROW(lamp_powers(grouped(with_lamps()), Eigen::VectorXd()), UsageError);
    LampPowers powers;
    EXPECT_THROW(relight_lamps(test::registry(), saved, how, 5.0, powers, Execution{}), UsageError);
}

} // namespace
} // namespace difusa::lamp_powers_test
