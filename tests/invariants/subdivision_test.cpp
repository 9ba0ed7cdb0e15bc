// Bakes whose patches are divided where the light varies (--adaptive with patch-constant).
#include "support/saved_bakes.h"

#include <difusa/bake.h>
#include <difusa/bake/relight.h>
#include <difusa/core/error.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/discretisation/patch_elements.h>
#include <difusa/import/shapes.h>

#include <support/furnace.h>
#include <support/surface_sampling.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace difusa::subdivision_test {
namespace {

constexpr double edge_at = 1.0 / 3.0; ///< of the shadow: as far from the lines of halved meshes as can be
constexpr double sun = 2.0;

/// The floor [0,1]² under a sun straight above it, with a lid over its part x < edge_at. The lid's top is lit evenly,
/// its back is black: the irradiance of the floor is 2 or 0, without reflections.
Scene floor_under_lid() {
    Scene scene;
    scene.mesh = rectangle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
    add(scene.mesh, rectangle(Vec3(-1.0, -1.0, 0.5), Vec3(1.0 + edge_at, 0, 0), Vec3(0, 3.0, 0)), 1);
    Material grey;
    grey.name = "floor";
    grey.reflectance = Rgb::Constant(0.5);
    scene.materials = {grey, grey};
    scene.materials[1].name = "lid";
    scene.suns = {{Vec3::UnitZ(), Rgb::Constant(sun)}};
    return scene;
}

BakeOptions divided(std::size_t elements) {
    BakeOptions options;
    options.basis = "patch-constant";
    options.adaptive = true;
    options.sites = elements;
    options.direct = "interpolated";
    options.rays = 16;
    options.visibility = "cgal";
    options.error_points = 0;
    return options;
}

BakeOptions even(std::size_t elements) {
    BakeOptions options = divided(elements);
    options.adaptive = false;
    return options;
}

const Substructure& parts_of(const BakeResult& result) {
    return *result.system->discretisation().basis->substructure();
}

/// Quarterings that made an element from its patch.
int level_of(const BakeResult& result, std::size_t site) {
    const Substructure& parts = parts_of(result);
    double patch = 0.0;
    for (std::size_t i = 0; i < parts.patch.size(); ++i) {
        patch += parts.patch[i] == parts.patch[site] ? parts.area[i] : 0.0;
    }
    return static_cast<int>(std::lround(0.5 * std::log2(patch / parts.area[site])));
}

TEST(SubdividedPatches, ConstantLightDividesNothing) {
    BakeOptions options = divided(400);
    options.rays = 64;
    options.solve.tolerance = 1e-12;
    const BakeResult result = test::baked(test::furnace(0.6, 2.0), options);
    EXPECT_EQ(parts_of(result).levels, 0);
    EXPECT_EQ(parts_of(result).patches(), result.sites->size());
    EXPECT_LT(result.sites->size(), 200U);
    EXPECT_LT((result.solution.irradiance.array() - 5.0).abs().maxCoeff(), 1e-9);
}

/// The elements along the edge of the shadow are the smallest, and where the light is constant none is divided.
TEST(SubdividedPatches, FollowTheEdgeOfAShadow) {
    const BakeResult result = test::baked(floor_under_lid(), divided(800));
    EXPECT_LE(result.sites->size(), 800U);
    const int deepest = parts_of(result).levels;
    EXPECT_GE(deepest, 2);
    const double patch = PatchMesh::edge_for_patches(PatchElements::coarseness * result.options.spacing);
    std::size_t small = 0;
    for (std::size_t i = 0; i < result.sites->size(); ++i) {
        const Vec3& x = result.sites->points[i].position;
        const int level = level_of(result, i);
        const double off = std::abs(x.x() - edge_at);
        if (x.z() > 0.0 || off > 3.0 * patch) {
            EXPECT_EQ(level, 0) << x.transpose();
        }
        small += level == deepest ? 1 : 0;
    }
    EXPECT_GT(small, 0U);
}

double rms_error(const BakeResult& result) {
    const std::vector<SurfacePoint> places = test::random_points(result.scene->mesh, 20000, RandomStream(11, "judged"));
    const Discretisation& discretisation = result.system->discretisation();
    const Values H = evaluate(*discretisation.basis, result.solution.irradiance, places, Execution{});
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (const Vec3& x = places[i].position; x.z() == 0.0) {
            sum += std::pow(H(static_cast<Eigen::Index>(i), 0) - (x.x() < edge_at ? 0.0 : sun), 2);
            ++count;
        }
    }
    return std::sqrt(sum / static_cast<double>(count));
}

/// A step is missed on the elements that it crosses, in proportion to their area: of n even ones √n with an area of 1/n
/// each, so that the rms error falls as n^-1/4. Elements that are halved along the edge alone halve that area with
/// twice as many, n^-1/2.
TEST(SubdividedPatches, ErrorsOfAShadowFallFasterThanOnAnEvenMesh) {
    const auto error = [](const BakeOptions& options) { return rms_error(test::baked(floor_under_lid(), options)); };
    const double even_small = error(even(500)), even_large = error(even(2000));
    const double small = error(divided(500)), large = error(divided(2000));
    EXPECT_LT(small, 0.7 * even_small);
    EXPECT_LT(large, 0.5 * even_large);
    EXPECT_NEAR(large / small, 0.5, 0.1);
    EXPECT_GT(even_large / even_small, 0.65);
}

/// The equation on patches: each element gathers from patches, of which each sends the mean of its elements weighted by
/// their areas.
TEST(SubdividedPatches, ElementsGatherFromPatches) {
    Scene scene = test::furnace(0.6, 0.0);
    scene.materials[0].emission = Rgb::Constant(3.0);
    BakeOptions options = divided(600);
    options.rays = 64;
    options.solve.tolerance = 1e-12;
    const BakeResult result = test::baked(scene, options);
    ASSERT_GE(parts_of(result).levels, 1);
    const Discretisation& discretisation = result.system->discretisation();
    const Values means = discretisation.projection->coefficients(result.solution.h);
    Values b;
    discretisation.averages->apply(means, b, Execution{});
    for (Index s = 0; s < discretisation.surfels->size(); ++s) {
        const auto row = static_cast<Eigen::Index>(s);
        b.row(row) = result.solution.light.all_emission.row(row) +
                     result.solution.light.reflectance.row(row).cwiseProduct(b.row(row));
    }
    Values gathered;
    result.system->transport().gather(b, {}, gathered, Execution{});
    EXPECT_LT((gathered - result.solution.h).cwiseAbs().maxCoeff(), 1e-9);
    // The field has the light of the elements.
    EXPECT_EQ(result.solution.field->parts().smooth, result.solution.h);
    EXPECT_GT((means - result.solution.h).cwiseAbs().maxCoeff(), 0.01);
    EXPECT_EQ(discretisation.integrals, parts_of(result).area);
}

TEST(SubdividedPatches, HaveTheSameBitsForAnyNumberOfThreads) {
    const auto with = [](unsigned threads) {
        return bake(test::registry(), floor_under_lid(), "scene", divided(300), Execution{threads, nullptr, nullptr});
    };
    const BakeResult one = with(1), two = with(2);
    ASSERT_EQ(one.sites->size(), two.sites->size());
    for (std::size_t i = 0; i < one.sites->size(); ++i) {
        ASSERT_EQ(one.sites->points[i].position, two.sites->points[i].position);
    }
    EXPECT_EQ(one.solution.irradiance, two.solution.irradiance);
}

TEST(SubdividedPatches, KeepTheirLimits) {
    BakeOptions options = divided(3000);
    options.levels = 1;
    const BakeResult shallow = test::baked(floor_under_lid(), options);
    EXPECT_EQ(parts_of(shallow).levels, 1);
    EXPECT_LT(shallow.sites->size(), 3000U); // all that is divided is divided once
    options.levels = 9;
    EXPECT_THROW(test::baked(floor_under_lid(), options), UsageError);
}

/// Which element is which follows from the sites alone.
TEST(SubdividedPatches, AreRelitFromAFile) {
    BakeOptions options = divided(400);
    options.every_surface = true;
    const BakeResult result = bake(test::registry(), DIFUSA_TEST_DATA "/cornell_box.obj", options, Execution{});
    ASSERT_GE(parts_of(result).levels, 1);
    const SavedTransport saved = test::through_file(result);
    RelightOptions how;
    how.bake = relight_defaults(saved);
    how.bake.error_points = 0;
    const BakeResult again = relight(test::registry(), saved, how, Execution{});
    EXPECT_EQ(again.solution.irradiance, result.solution.irradiance);
    EXPECT_EQ(parts_of(again).levels, parts_of(result).levels);
}

TEST(SubdividedPatches, RefuseWhatTheyCannotDo) {
    const auto refused = [](const std::string& why, BakeOptions options) {
        EXPECT_THAT([&] { test::baked(floor_under_lid(), options); },
                    testing::ThrowsMessage<UsageError>(testing::HasSubstr(why)));
    };
    BakeOptions options = divided(300);
    options.transport = "pairwise";
    refused("use --transport gather", options);
    options = divided(300);
    options.basis = "patch-constant:display=gouraud";
    refused("patch-constant, shown flat", options);
    options = even(300);
    options.levels = 2;
    refused("--levels: limits how finely patches are divided", options);
    options = even(300);
    options.projection = "substructured";
    refused("--projection substructured", options);
}

} // namespace
} // namespace difusa::subdivision_test
