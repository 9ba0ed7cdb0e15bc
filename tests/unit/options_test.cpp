// What programs cannot ask of a bake, though a command line could not say it.
#include <difusa/bake.h>
#include <difusa/bake/options.h>
#include <difusa/core/error.h>

#include <support/plugins.h>
#include <support/sited.h>

#include <meshes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace difusa::options_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double inf = std::numeric_limits<double>::infinity();

TEST(Options, OfSensorGridsAreLengths) {
    BakeOptions options;
    options.grids = {{"floor", 0.8, 0.5, 0.0}, {"0", 0.0, 1e-3, 2.0}};
    EXPECT_NO_THROW(check_options(options));
    for (const double bad : {-1.0, inf, std::nan("")}) {
        for (double SensorGrid::*const length : {&SensorGrid::height, &SensorGrid::spacing, &SensorGrid::margin}) {
            BakeOptions other = options;
            other.grids[0].*length = bad;
            EXPECT_THAT([&] { check_options(other); }, ThrowsMessage<UsageError>(HasSubstr("--grid floor"))) << bad;
        }
    }
    options.grids[1].spacing = 0.0;
    EXPECT_THAT([&] { check_options(options); }, ThrowsMessage<UsageError>(HasSubstr("--grid 0")));
}

TEST(Options, OfTheOutputAndTheErrorAreChecked) {
    for (const double bad : {0.0, -1.0, inf, std::nan("")}) {
        BakeOptions options;
        options.output_in_spacings = bad;
        EXPECT_THROW(check_options(options), UsageError) << bad;
    }
    BakeOptions options;
    options.error_rounds = 0;
    EXPECT_NO_THROW(check_options(options));
    options.error_rounds = std::numeric_limits<std::size_t>::max();
    EXPECT_THROW(check_options(options), UsageError);
}

TEST(Options, ASceneHasVertexColoursForAllTrianglesOrNone) {
    for (const std::size_t count : {1U, 3U}) {
        Scene scene = test::uniform_scene(test::grid(1, 1), 0.5, 1.0);
        scene.mesh.corner_reflectance.assign(count, {Rgb(0.5), Rgb(0.5), Rgb(0.5)});
        EXPECT_THAT([&] { bake(test::registry(), scene, "scene", BakeOptions(), Execution{}); },
                    ThrowsMessage<InputError>(HasSubstr("vertex colours of " + std::to_string(count) + " triangles")));
    }
}

} // namespace
} // namespace difusa::options_test
