// Light gathered at places: where no element reaches, and with its noise stated where few rays meet what is bright.
#include <difusa/bake.h>
#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>

#include <support/plugins.h>
#include <support/rooms.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace difusa::final_gather_test {
namespace {

/// A dim room of 10 by 4 by 3 m with a window of 1 m² in its wall x = 0, under a uniform sky.
Scene room_with_window() {
    Mesh mesh = rectangle({0, 0, 0}, {10, 0, 0}, {0, 4, 0});   // floor
    add(mesh, rectangle({0, 0, 3}, {0, 4, 0}, {10, 0, 0}), 0); // ceiling
    add(mesh, rectangle({10, 0, 0}, {0, 0, 3}, {0, 4, 0}), 0); // opposite
    add(mesh, rectangle({0, 0, 0}, {0, 0, 3}, {10, 0, 0}), 0); // sides
    add(mesh, rectangle({0, 4, 0}, {10, 0, 0}, {0, 0, 3}), 0);
    add(mesh, rectangle({0, 0, 0}, {0, 1.5, 0}, {0, 0, 3}), 0); // around the window
    add(mesh, rectangle({0, 2.5, 0}, {0, 1.5, 0}, {0, 0, 3}), 0);
    add(mesh, rectangle({0, 1.5, 0}, {0, 1, 0}, {0, 0, 1}), 0);
    add(mesh, rectangle({0, 1.5, 2}, {0, 1, 0}, {0, 0, 1}), 0);
    mesh.derive();
    return test::uniform_scene(std::move(mesh), 0.2, 0.0);
}

/// A closed surface as a rough scan has it: a sphere whose vertices are displaced along their radii by up to as much as
/// its edges are long.
Mesh rough_sphere() {
    Mesh mesh = sphere(1.0, 4, Front::inside);
    RandomStream stream(1, "roughness");
    for (Vec3& point : mesh.points) {
        point *= 1.0 + 0.1 * (2.0 * stream.uniform() - 1.0);
    }
    mesh.derive();
    return mesh;
}

/// Into the tips of narrow pits no site sees, and no element reaches there. In a closed scene whose surface emits E
/// everywhere, each point receives at least that: all of its rays end on a front.
TEST(FinalGather, IsWhatPointsShowThatNoElementReaches) {
    constexpr double E = 1.0, rho = 0.5, exact = E / (1.0 - rho);
    BakeOptions options;
    options.sites = 100;
    options.rays = 64;
    const BakeResult result =
        bake(test::registry(), test::uniform_scene(rough_sphere(), rho, E), "pits", options, Execution{2});
    const std::vector<std::size_t>& gathered = result.output.gathered;
    ASSERT_FALSE(gathered.empty());
    ASSERT_LT(gathered.size(), result.mesh.vertices.size() / 10);
    EXPECT_GE(result.output.H.minCoeff(), E * (1.0 - 1e-9));
    const Basis& basis = *result.system->discretisation().basis;
    int beyond = 0;
    for (const std::size_t i : gathered) {
        BasisRow row;
        basis.evaluate(inset(result.scene->mesh, result.mesh.vertices[i]), row);
        EXPECT_TRUE(row.element.empty());
        const double off = std::abs(result.output.H(static_cast<Eigen::Index>(i), 0) - exact),
                     stated = result.errors->irradiance(static_cast<Eigen::Index>(i), 0);
        EXPECT_GT(stated, 0.0);
        beyond += off > 4.0 * stated ? 1 : 0;
    }
    EXPECT_LE(beyond, static_cast<int>(gathered.size()) / 16 + 1); // Chebyshev, as below
    EXPECT_THAT(result.journal.notes(), testing::Contains(testing::HasSubstr("no basis function reaches")));
}

TEST(FinalGather, StatesItsNoiseWhereFewRaysMeetAWindow) {
    Scene scene = room_with_window();
    scene.sky = Rgb::Ones();
    BakeOptions options;
    options.sites = 1500;
    options.output_spacing = 100.0;
    RandomStream stream(1, "places");
    for (int i = 0; i < 200; ++i) {
        options.at.push_back({Vec3(2.0 + 7.5 * stream.uniform(), 0.3 + 3.4 * stream.uniform(), 0.0), Vec3::UnitZ()});
    }
    const auto bake_with = [&](std::size_t rays) {
        options.final_gather = rays;
        return bake(test::registry(), scene, "room", options, Execution{2});
    };
    // From the window's far side 0 to 10 of 256 rays meet it, or 0 to 5 of either half. The same bake with 16,384 rays
    // has the same errors of the field, and next to no noise.
    const BakeResult few = bake_with(256), many = bake_with(16'384);
    ASSERT_EQ(few.listed_values.B.rows(), 200);
    int beyond = 0;
    for (Eigen::Index i = 0; i < few.listed_values.B.rows(); ++i) {
        const double off = (few.listed_values.H.row(i) - many.listed_values.H.row(i)).norm();
        beyond += off > 4.0 * std::sqrt(few.channels) * few.listed_errors->irradiance(i, 0) ? 1 : 0;
    }
    // If the stated error is the root of the expected square, errors beyond four times it have a probability of at most
    // 1/16 (Chebyshev): 12.5 of 200, with a standard deviation of at most 3.4. Halves that both miss the window leave
    // 40 % beyond.
    EXPECT_LE(beyond, 22);
}

} // namespace
} // namespace difusa::final_gather_test
