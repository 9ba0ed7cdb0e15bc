// Gradients of goals against differences, and against the contributions of lights.
#include <difusa/bake/goals.h>
#include <difusa/core/error.h>
#include <difusa/output/gradient_table.h>
#include <difusa/radiosity/goal_gradient.h>
#include <difusa/radiosity/response.h>
#include <difusa/scene/light_groups.h>

#include <support/lightings.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace difusa::goal_gradient_test {
namespace {

/// Sharp lights, an area light, a textured emitter that is none, and a sky.
Scene many_lights() {
    Scene scene = test::bare_room();
    scene.sky = Rgb(0.5, 0.6, 0.7);
    scene.suns = {{Vec3(0.3, -0.5, 2).normalized(), Rgb(3, 2, 1)}};
    scene.materials[2].emission = Rgb(20, 18, 15);
    scene.materials[3].emission = Rgb(1, 2, 1);
    scene.materials[3].emission_texture = scene.materials[0].reflectance_texture = test::checks();
    scene.materials[1].reflectance = Rgb(0.8, 0.3, 0.1);
    return scene;
}

std::vector<Goal> some_goals(const Scene& scene) {
    Goal panel{"panel", {}, {}}, places{"places", {}, {scene.mesh.at(0, 0.3, 0.3), scene.mesh.at(9, 0.2, 0.4)}};
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        if (scene.mesh.material[t] == 1) {
            panel.triangles.push_back(t);
        }
    }
    return {panel, places};
}

class Gradients : public testing::Test {
  protected:
    Gradients() {
        BakeOptions options = lit::quick(0.35, 32);
        options.every_surface = true;
        result = lit::baked(many_lights(), options);
        how.solve.tolerance = 1e-13;
        how.first_bounce = FirstBounce::operator_only;
    }

    Solution solve(const Scene& scene) {
        LightingOptions own = how;
        own.sets = light_groups(scene);
        return result.system->solve(std::make_shared<Scene>(scene), own, Execution{});
    }
    std::vector<GoalGradient> gradients(const Scene& scene) {
        return goal_gradients(solve(scene), goals, 2000, 1, how.solve, Execution{});
    }

    BakeResult result;
    LightingOptions how;
    std::vector<Goal> goals = some_goals(many_lights());
};

/// Linear in the light: the groups are all of it, and each is what its lights alone give.
TEST_F(Gradients, GroupsAddUpToTheMean) {
    const Scene scene = many_lights();
    const std::vector<GoalGradient> all = gradients(scene);
    const LightSets sets = light_groups(scene);
    ASSERT_EQ(all.size(), 2U);
    for (const GoalGradient& each : all) {
        ASSERT_EQ(each.groups.rows(), static_cast<Eigen::Index>(sets.count()));
        const Rgb sum = each.groups.colwise().sum().transpose().array();
        EXPECT_LE((sum - each.value).abs().maxCoeff(), 1e-10 * each.value.maxCoeff()) << each.name;
        EXPECT_GT(each.groups.minCoeff(), 0.0) << each.name;
    }
    Scene dark = scene; // of a sky alone, without what shadow rays depend on
    dark.suns.clear();
    dark.materials[2].emission = dark.materials[3].emission = Rgb::Zero();
    const std::vector<GoalGradient> sky = gradients(dark);
    for (std::size_t g = 0; g < 2; ++g) {
        const auto row = static_cast<Eigen::Index>(sets.sky);
        EXPECT_LE((sky[g].value.matrix().transpose() - all[g].groups.row(row)).norm(), 1e-10 * sky[g].value.maxCoeff());
    }
}

/// Central differences: an error of the square of the step, 1e-8 of the third derivative, and of rounding over it.
TEST_F(Gradients, OfReflectancesAreLimitsOfDifferences) {
    const Scene scene = many_lights();
    const std::vector<GoalGradient> all = gradients(scene);
    constexpr double step = 1e-4;
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        Scene more = scene, less = scene;
        more.materials[m].reflectance += step;
        less.materials[m].reflectance -= step;
        const std::vector<GoalGradient> above = gradients(more), below = gradients(less);
        for (std::size_t g = 0; g < goals.size(); ++g) {
            const Rgb difference = (above[g].value - below[g].value) / (2.0 * step);
            const Rgb gradient = all[g].reflectance.row(static_cast<Eigen::Index>(m)).transpose().array();
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(gradient[c], difference[c], 1e-6 * std::abs(difference[c]) + 1e-9)
                    << goals[g].name << ", " << scene.materials[m].name << ", channel " << c;
            }
        }
    }
}

TEST_F(Gradients, OfEmissionsAreDifferences) {
    Scene scene = many_lights();
    const std::vector<GoalGradient> all = gradients(scene);
    Scene more = scene;
    more.materials[3].emission += 1.0; // textured: its rays carry its light, which is linear in it
    const std::vector<GoalGradient> above = gradients(more);
    for (std::size_t g = 0; g < goals.size(); ++g) {
        const Rgb gradient = all[g].emission.row(3).transpose().array();
        EXPECT_LE((above[g].value - all[g].value - gradient).abs().maxCoeff(), 1e-9 * gradient.maxCoeff());
        EXPECT_GT(all[g].emission.minCoeff(), 0.0) << "all could light the goals";
    }
}

/// <x, (I - T)^-1 y> = <(I - T^T)^-1 x, y>.
TEST_F(Gradients, TransposedSolutionsAreAdjoint) {
    const Solution solution = solve(many_lights());
    const Values& rho = solution.light.reflectance;
    const auto n = static_cast<Eigen::Index>(result.system->discretisation().points.size());
    const Values x = Values::Random(n, 30), y = Values::Random(n, 30);
    const Values h = solve_for(*result.system, rho, y, how.solve, Execution{});
    const Values l = solve_transpose_for(*result.system, rho, x, how.solve, Execution{2, nullptr, nullptr});
    for (Eigen::Index c = 0; c < 30; ++c) {
        EXPECT_NEAR(x.col(c).dot(h.col(c)), l.col(c).dot(y.col(c)), 1e-10 * static_cast<double>(n));
    }
    // A column has the bits that it has alone.
    EXPECT_EQ(Values(h.middleCols(27, 3)), solve_for(*result.system, rho, y.middleCols(27, 3), how.solve, Execution{}));
}

TEST_F(Gradients, AreTabulated) {
    result.solution = solve(many_lights());
    const std::vector<GoalGradient> all = goal_gradients(result.solution, goals, 2000, 1, how.solve, Execution{});
    const std::string table = gradient_table(result, all, true);
    const std::size_t faces = result.scene->mesh.original_face.back() + std::size_t{1};
    const auto lines = static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n'));
    EXPECT_EQ(lines, 1 + 2 * (1 + light_groups(many_lights()).count() + 2 * 4 + faces));
    // The faces of an untextured material together are the material.
    double sum = 0.0, material = 0.0;
    std::istringstream stream(table);
    for (std::string line; std::getline(stream, line);) {
        const bool of_panel = line.starts_with("\"panel\",face,");
        if (of_panel || line.starts_with("\"panel\",emission,\"panel\"")) {
            std::vector<std::string> fields;
            std::istringstream row(line);
            for (std::string field; std::getline(row, field, ',');) {
                fields.push_back(field);
            }
            const std::size_t face = of_panel ? std::stoul(fields[2].substr(1)) : 0;
            if (!of_panel) {
                material = std::stod(fields[6]);
            } else if (result.scene->mesh.material[face] == 1) {
                sum += std::stod(fields[6]);
            }
        }
    }
    EXPECT_NEAR(sum, material, 1e-12 * material);
    // A material that no face has is not in it, as one of a mesh file that a scene file has replaced.
    Scene replaced = many_lights();
    replaced.materials.push_back(replaced.materials[1]);
    result.scene = std::make_shared<Scene>(replaced);
    result.solution = solve(replaced);
    EXPECT_EQ(gradient_table(result, goal_gradients(result.solution, goals, 2000, 1, how.solve, Execution{}), true),
              table);
}

TEST_F(Gradients, AreRefusedWhereTheyWouldNotBeExact) {
    how.direct_in_basis = true;
    EXPECT_THROW(gradients(many_lights()), UsageError);
    how.direct_in_basis = false;
    goals.push_back({"nothing", {}, {}});
    EXPECT_THROW(gradients(many_lights()), UsageError);
}

} // namespace
} // namespace difusa::goal_gradient_test
