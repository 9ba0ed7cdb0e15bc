// Pictures show what the bake knows, pixel by pixel.
#include <difusa/core/colour.h>
#include <difusa/core/photometry.h>
#include <difusa/render/colour_map.h>
#include <difusa/render/draw.h>
#include <difusa/render/picture.h>

#include <difusa/render/camera_rays.h>

#include <support/plugins.h>
#include <support/rooms.h>
#include <support/sited.h>
#include <support/thermal.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace difusa::picture_test {
namespace {

using test::box;
using test::grid;
using test::registry;
using test::uniform_scene;

const Execution one{1, nullptr};

BakeOptions few(const std::string& basis = "normalized-radial") {
    BakeOptions options;
    options.basis = basis;
    options.sites = 80;
    options.rays = 32;
    options.solve.tolerance = 1e-12;
    return options;
}

ViewOptions view_of(const Camera& camera, std::size_t width, std::size_t height, std::size_t samples) {
    ViewOptions view;
    view.camera = camera;
    view.width = width;
    view.height = height;
    view.samples = samples;
    return view;
}

/// Straight down from (0.5, 0.5, 1), x to the right; the picture covers `side` of the plane z = 0 from bottom to top.
Camera from_above(double side) {
    return {Vec3(0.5, 0.5, 1.0), -Vec3::UnitZ(), Vec3::UnitY(), 2.0 * std::atan(0.5 * side)};
}

TEST(Picture, AFurnaceIsOfOneColourInEveryBasis) {
    const Camera inside{Vec3(0.1, 0.2, 0.3), Vec3(0.6, 0.5, 0.1).normalized(), Vec3::UnitZ(), 1.5};
    for (const std::string& basis : test::plugin_names<Basis>()) {
        if (!test::plugin<Basis>(basis)->sums_to_one()) {
            continue; // it has no constants
        }
        const BakeResult result = bake(registry(), uniform_scene(box(1.0, 1, true), 0.5, 1.0), "box", few(basis), one);
        for (const std::size_t final_gather : {0U, 8U}) {
            ViewOptions options = view_of(inside, 12, 9, 4);
            options.final_gather = final_gather;
            const View view = look(result, options, {{}}, one);
            for (const auto& pixel : linear_picture(view, 0, {}).pixels) {
                for (const float c : pixel) { // E / (1 - rho) / pi, in single precision
                    EXPECT_NEAR(c, 2.0 * std::numbers::inv_pi, 1e-6) << basis;
                }
            }
        }
    }
}

TEST(Picture, ThePixelsOfAnEdgeAreCoveredInProportion) {
    const BakeResult result = bake(registry(), uniform_scene(grid(1, 1), 0.5, 1.0), "square", few(), one);
    constexpr std::size_t width = 37, height = 29;
    for (const std::size_t samples : {1U, 4U, 16U, 49U}) {
        const ViewOptions options = view_of(from_above(1.37), width, height, samples);
        const CameraRays camera(options.camera, width, height);
        const auto low = *camera.place_of(Vec3(0.0, 1.0, 0.0)), high = *camera.place_of(Vec3(1.0, 0.0, 0.0));
        const View view = look(result, options, {parse_show("emission")}, one);
        const Image image = linear_picture(view, 0, {});
        const auto covered = [](std::size_t pixel, double from, double to) {
            const auto at = static_cast<double>(pixel);
            return std::clamp(std::min(at + 1.0, to) - std::max(at, from), 0.0, 1.0);
        };
        const double slack = 1.0 / static_cast<double>(samples) + 1e-6;
        for (std::size_t column = 0; column < width; ++column) {
            EXPECT_NEAR(image.at(column, height / 2)[0] * std::numbers::pi, covered(column, low[0], high[0]), slack);
        }
        for (std::size_t row = 0; row < height; ++row) {
            EXPECT_NEAR(image.at(width / 2, row)[1] * std::numbers::pi, covered(row, low[1], high[1]), slack);
        }
    }
}

TEST(Picture, ShowsWhatTheOutputOfTheBakeSays) {
    Scene scene = uniform_scene(test::room_with_block(), 0.6, 0.2);
    scene.materials[0].reflectance = Rgb(0.6, 0.3, 0.1);
    scene.materials[0].name = "walls";
    scene.point_lights.push_back({Vec3(0.2, 0.3, 0.8), Rgb(1.0, 2.0, 3.0)});
    BakeOptions options = few();
    options.output_spacing = 0.3;
    options.light_groups = true;
    const BakeResult result = bake(registry(), scene, "room", options, one);
    const std::string lamp = result.field().sets().names.front();
    const std::vector<std::string> names{"radiosity",           "direct",   "indirect",    "irradiance",
                                         "luminance",           "error",    "reflectance", "irradiance-direct",
                                         "irradiance-indirect", "emission", "basis",       "group:" + lamp};
    std::vector<Show> shows;
    for (const std::string& name : names) {
        shows.push_back(parse_show(name));
    }
    int checked = 0;
    for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
        const SurfacePoint& x = result.mesh.vertices[v];
        if (x.position.z() > 0.0 || ((x.position.head<2>().array() - 0.5).abs() > 0.4).any()) {
            continue; // only the floor without its edges
        }
        ++checked;
        const Camera camera{x.position + 0.01 * x.normal, -x.normal, Vec3::UnitX(), 1e-8};
        const View view = look(result, view_of(camera, 1, 1, 1), shows, one);
        const auto row = static_cast<Eigen::Index>(v);
        const PointValues& out = result.output;
        const auto expect = [&](std::size_t show, const Values& wanted, double tolerance = 1e-5) {
            for (Eigen::Index c = 0; c < 3; ++c) { // fields change by no more than a millionth over so short a way
                EXPECT_NEAR(view.values[show][0][static_cast<std::size_t>(c)], wanted(0, c),
                            tolerance * wanted.cwiseAbs().maxCoeff())
                    << names[show];
            }
        };
        const auto grey = [](double value) { return Values(Values::Constant(1, 3, value)); };
        const Values rho = out.rho.row(row), E = out.E.row(row);
        expect(0, out.B.row(row));
        expect(1, E + rho.cwiseProduct(Values(out.H_direct.row(row))));
        expect(2, rho.cwiseProduct(Values(out.H_indirect.row(row))));
        expect(3, out.H.row(row));
        const double weighted = 0.2126 * out.B(row, 0) + 0.7152 * out.B(row, 1) + 0.0722 * out.B(row, 2);
        expect(4, grey(683.0 / std::numbers::pi * weighted));
        // On an edge between two triangles, each of the two is read 2^-16 of its side inside of one of them. Weights
        // of elements 0.2 wide change by up to 6 / 0.2 of themselves over a unit of length, and the error with them.
        expect(5, grey(result.errors->error(row, 0)), 30.0 * 0x1p-15);
        expect(6, rho);
        expect(7, out.H_direct.row(row));
        expect(8, out.H_indirect.row(row));
        expect(9, E);
        expect(10, grey(1.0));
        expect(11, out.groups.front().B.row(row));
    }
    EXPECT_GT(checked, 3);
}

TEST(Picture, ElementsAddUpToTheSum) {
    const BakeResult result = bake(registry(), uniform_scene(grid(1, 1), 0.5, 1.0), "square", few("radial"), one);
    std::vector<Show> shows{parse_show("basis")};
    for (Index i = 0; i < result.sites->size(); ++i) {
        shows.push_back(parse_show("basis"));
        shows.back().element = i;
    }
    const View view = look(result, view_of(from_above(0.9), 6, 6, 1), shows, one);
    for (std::size_t s = 0; s < 36; ++s) {
        double sum = 0.0;
        for (std::size_t k = 1; k < shows.size(); ++k) {
            sum += static_cast<double>(view.values[k][s][0]);
        }
        EXPECT_NEAR(sum, view.values[0][s][0], 1e-5);
    }
    shows.back().element = static_cast<Index>(result.sites->size());
    EXPECT_THROW(look(result, view_of(from_above(0.9), 6, 6, 1), shows, one), UsageError);
}

TEST(Picture, IsTheSameForAnyNumberOfThreads) {
    Scene scene = uniform_scene(test::room_with_block(), 0.6, 0.0);
    scene.point_lights.push_back({Vec3(0.2, 0.3, 0.8), Rgb(1.0, 2.0, 3.0)});
    const BakeResult result = bake(registry(), scene, "room", few("shepard"), one);
    ViewOptions options = view_of({Vec3(0.05, 0.05, 0.6), Vec3(1.0, 1.0, -0.2), Vec3::UnitZ(), 1.2}, 70, 50, 4);
    for (const std::size_t final_gather : {0U, 4U}) {
        options.final_gather = final_gather;
        const std::vector<Show> shows{parse_show("radiosity"), parse_show("sites"), parse_show("error")};
        const View first = look(result, options, shows, one), second = look(result, options, shows, {3, nullptr});
        EXPECT_EQ(first.values, second.values);
        Development how;
        how.exposure = exposure_of(first, 0);
        EXPECT_EQ(how.exposure, exposure_of(second, 0));
        how.scale = scale_of(first, 2, false);
        for (std::size_t k = 0; k < shows.size(); ++k) {
            EXPECT_EQ(develop(result, first, k, how, one).pixels, develop(result, second, k, how, {3, nullptr}).pixels);
        }
    }
}

TEST(Picture, BacksAreDarkOrLookedThrough) {
    const BakeResult result = bake(registry(), uniform_scene(box(1.0, 1, true), 0.5, 1.0), "box", few(), one);
    ViewOptions options = view_of({Vec3(0.5, 0.5, 3.0), -Vec3::UnitZ(), Vec3::UnitY(), 0.2}, 8, 8, 1);
    const View outside = look(result, options, {{}}, one);
    EXPECT_TRUE(
        std::all_of(outside.seen.begin(), outside.seen.end(), [](CameraHit seen) { return seen == CameraHit::back; }));
    Development how;
    for (const auto& pixel : develop(result, outside, 0, how, one).pixels) {
        EXPECT_LT(pixel[0], 0.1F);
        EXPECT_EQ(pixel[0], pixel[2]);
    }
    options.cull_backs = true;
    const View through = look(result, options, {{}}, one);
    for (const auto& value : through.values[0]) {
        EXPECT_NEAR(value[0], 2.0F, 1e-6F);
    }
}

TEST(Picture, WhereNothingIsMetThereIsTheSkyOrTheBackground) {
    Scene scene = uniform_scene(grid(1, 1), 0.5, 0.0);
    scene.sky = Rgb(1.0, 2.0, 4.0);
    const BakeResult result = bake(registry(), scene, "square", few(), one);
    const View view = look(result, view_of(from_above(2.0), 16, 16, 1), {{}, parse_show("indirect")}, one);
    const Image image = linear_picture(view, 0, {});
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_FLOAT_EQ(image.at(0, 0)[c], static_cast<float>(std::pow(2.0, double(c)) * std::numbers::inv_pi));
        EXPECT_EQ(linear_picture(view, 1, {}).at(0, 0)[c], 0.0F); // no light that anything reflected
        EXPECT_EQ(linear_picture(view, 0, Rgb(0.25, 0.5, 1.0)).at(0, 0)[c], std::ldexp(1.0F, static_cast<int>(c) - 2));
    }
    Development how;
    how.background = Rgb(0.25, 0.5, 1.0);
    how.exposure = 123.0;
    EXPECT_EQ(develop(result, view, 0, how, one).at(0, 0), (std::array{0.25F, 0.5F, 1.0F}));
    // Neutral by default, also where there is no light to see; the sky if it is asked for.
    how.background.reset();
    how.exposure = 0.1;
    EXPECT_EQ(develop(result, view, 0, how, one).at(0, 0), (std::array{0.18F, 0.18F, 0.18F}));
    how.sky = true;
    EXPECT_EQ(develop(result, view, 0, how, one).at(0, 0), (std::array{0.1F, 0.2F, 0.4F}));
    EXPECT_EQ(develop(result, view, 1, how, one).at(0, 0), (std::array{0.18F, 0.18F, 0.18F}));
}

/// The left half of a square is a mirror or glossy, the right half matt.
Scene half_shiny(const Material& shiny, const Material& matt) {
    Scene scene;
    scene.mesh = grid(2, 1);
    scene.materials = {shiny, matt};
    for (Index face = 0; face < scene.mesh.triangles.size(); ++face) {
        scene.mesh.material[face] = scene.mesh.at(face, 1.0 / 3.0, 1.0 / 3.0).position.x() < 0.5 ? 0 : 1;
    }
    return scene;
}

TEST(Picture, TheLuminanceIsThatOfTheRadianceAlsoOfTheSkyInMirrors) {
    Material mirror, glossy, matt;
    mirror.reflectance = glossy.reflectance = Rgb::Constant(0.1);
    mirror.mirror = Rgb(0.8, 0.6, 0.4);
    glossy.gloss.emplace();
    glossy.gloss->reflectance = Rgb(0.2, 0.4, 0.6);
    glossy.gloss->shape = {LobeShape::Model::ggx, 0.5};
    for (const Material& shiny : {mirror, glossy}) {
        Scene scene = half_shiny(shiny, matt);
        scene.sky = Rgb(1.0, 2.0, 4.0);
        scene.suns.push_back({Vec3(0.3, 0.2, 1.0).normalized(), Rgb(3.0, 2.0, 1.0)});
        const BakeResult result = bake(registry(), scene, "square", few(), one);
        const View view = look(result, view_of(from_above(1.5), 24, 24, 1),
                               {{}, parse_show("luminance"), parse_show("radiosity-weighted")}, one);
        for (std::size_t s = 0; s < view.values[0].size(); ++s) {
            // Sums of the same terms in single precision, of which there are at most a few dozen.
            const double weighted = luminance(rgb_of(view.values[0][s])), slack = 1e-5 * weighted;
            EXPECT_GT(weighted, 0.1) << s;
            EXPECT_NEAR(view.values[1][s][0], lumens_per_watt / std::numbers::pi * weighted,
                        lumens_per_watt / std::numbers::pi * slack);
            EXPECT_NEAR(view.values[2][s][0], weighted, slack);
        }
    }
}

TEST(Picture, MirrorsShowTheSurroundingsOfAThermalScene) {
    const auto warm = [](double kelvins) { return stefan_boltzmann * std::pow(kelvins, 4); };
    Material mirror = test::at_temperature(300.0, 0.1, "mirror");
    mirror.reflectance = Rgb::Zero();
    mirror.mirror = Rgb::Constant(0.9);
    Scene scene = half_shiny(mirror, test::at_temperature(300.0, 0.1, "matt"));
    scene.thermal = ThermalSetting{400.0};
    const BakeResult result = bake(registry(), scene, "square", few(), one);
    const View view = look(result, view_of(from_above(1.5), 24, 24, 1), {parse_show("radiosity-weighted")}, one);
    const double reflected = 0.1 * warm(300.0) + 0.9 * warm(400.0); // by either half: all that arrives is from outside
    for (std::size_t s = 0; s < view.seen.size(); ++s) {
        EXPECT_NEAR(view.values[0][s][0], view.seen[s] == CameraHit::nothing ? warm(400.0) : reflected, 1e-3) << s;
    }
}

TEST(Picture, TheColourBarStandsBesideIt) {
    const BakeResult result = bake(registry(), uniform_scene(grid(1, 1), 0.5, 1.0), "square", few(), one);
    const View view = look(result, view_of(from_above(0.9), 40, 300, 1), {parse_show("luminance")}, one);
    Development how;
    how.scale = {0.0, 1000.0, false};
    const Image image = develop(result, view, 0, how, one);
    EXPECT_EQ(image.height, 300U);
    EXPECT_GT(image.width, 80U);
    // Along a column of the bar, all of the colour map, from its end down.
    std::size_t bar = 0, last = 0;
    for (std::size_t row = 0; row < image.height; ++row) {
        const Rgb pixel = rgb_of(image.at(40 + 6 + 3, row)); // a letter's width, and into the bar
        const bool coloured = pixel.maxCoeff() - pixel.minCoeff() > 0.02;
        bar += coloured ? 1 : 0;
        last = coloured ? row : last;
    }
    EXPECT_GT(bar, 250U);
    EXPECT_LT((rgb_of(image.at(49, last)) - colour_map(0.0)).abs().maxCoeff(), 0.02);
    EXPECT_EQ(image.at(10, 150), develop(result, view, 0, how, one).at(10, 150)); // the picture itself
}

TEST(Picture, LabelsOfTheColourBarAreReadAtAGlance) {
    EXPECT_EQ(bar_label(0.0123456), "0.0123");
    EXPECT_EQ(bar_label(327.499), "327");
    EXPECT_EQ(bar_label(999.9), "1000");
    EXPECT_EQ(bar_label(43569.8), "43600");
    EXPECT_EQ(bar_label(-40000.0), "-40000");
    EXPECT_EQ(bar_label(999999.0), "1e+06");
    EXPECT_EQ(bar_label(1e-9), "1e-09");
}

TEST(Picture, SitesAreDotsOnTheSideThatFacesTheEye) {
    const BakeResult result = bake(registry(), uniform_scene(grid(1, 1), 0.5, 1.0), "square", few(), one);
    const auto dots = [&](const ViewOptions& options) {
        const View view = look(result, options, {parse_show("sites")}, one);
        const Image image = develop(result, view, 0, {}, one);
        const CameraRays camera(options.camera, options.width, options.height);
        std::size_t found = 0;
        for (const SurfacePoint& site : result.sites->points) {
            const auto place = camera.place_of(site.position);
            const auto& pixel = image.at(static_cast<std::size_t>((*place)[0]), static_cast<std::size_t>((*place)[1]));
            found += pixel[2] > 2.0F * pixel[0] ? 1 : 0; // blue
        }
        return found;
    };
    ViewOptions options = view_of(from_above(1.1), 300, 300, 1);
    EXPECT_EQ(dots(options), result.sites->size());
    options.camera.eye.z() = -1.0;
    options.camera.towards = Vec3::UnitZ();
    EXPECT_EQ(dots(options), 0U);
}

TEST(Picture, WhatCannotBeIsRefused) {
    EXPECT_THROW(parse_show("radiosty"), UsageError);
    EXPECT_EQ(parse_show("irradiance_direct").quantity, Quantity::irradiance_direct);
    EXPECT_EQ(parse_show("group:a b").group, "a b");
    BakeOptions options = few();
    options.error_points = 0;
    const BakeResult result = bake(registry(), uniform_scene(grid(1, 1), 0.5, 1.0), "square", options, one);
    const ViewOptions view = view_of(from_above(1.0), 4, 4, 1);
    EXPECT_THROW(look(result, view, {parse_show("error")}, one), UsageError);
    EXPECT_THROW(look(result, view, {parse_show("group:nobody")}, one), UsageError);
    EXPECT_THROW(look(result, view_of(from_above(1.0), 4, 4, 5), {{}}, one), UsageError);
    EXPECT_THROW(look(result, view_of(from_above(1.0), 0, 4, 1), {{}}, one), UsageError);
}

} // namespace
} // namespace difusa::picture_test
