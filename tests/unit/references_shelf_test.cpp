#include <difusa/study/references/form_factors.h>
#include <difusa/study/references/shelf.h>
#include <difusa/study/shelf_study.h>

#include <difusa/core/error.h>
#include <difusa/core/types.h>

#include <support/plugins.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace difusa::references_shelf_test {
namespace {

/// The lightings of L 34: what A, the back B and C emit and reflect.
struct Lighting {
    const char* name;
    std::array<double, 3> E, rho;
};

std::vector<Lighting> lightings() {
    return {{"only A emits, and does not reflect", {1, 0, 0}, {0, 0.7, 0.5}},
            {"A emits and reflects", {1, 0, 0}, {0.6, 0.7, 0.5}},
            {"only B emits, and does not reflect", {0, 1, 0}, {0.6, 0, 0.5}},
            {"A and B emit and reflect", {1, 0.5, 0}, {0.6, 0.7, 0.5}}};
}

ShelfParameters shelf_of(const Lighting& light, double b) {
    ShelfParameters p;
    p.b = b;
    p.E = light.E;
    p.rho = light.rho;
    return p;
}

TEST(Shelf, PatchesSatisfyTheEquationsOfTheSlide) {
    for (const double b : {0.3, 1.0, 4.0}) {
        const ShelfFormFactors F = shelf(1.0, b);
        for (const Lighting& light : lightings()) {
            const std::array<double, 3> B = shelf_patches(shelf_of(light, b));
            EXPECT_NEAR(B[0], light.E[0] + light.rho[0] * (F.AB * B[1] + F.AC * B[2]), 1e-15) << light.name;
            EXPECT_NEAR(B[1], light.E[1] + light.rho[1] * F.BA * (B[0] + B[2]), 1e-15) << light.name;
            EXPECT_NEAR(B[2], light.E[2] + light.rho[2] * (F.AC * B[0] + F.AB * B[1]), 1e-15) << light.name;
        }
    }
}

/// An element on the floor at x sees the back of height b as a strip from its foot on: (1 - x/√(x²+b²))/2, and the
/// ceiling as the rest up to the front's upper edge: (x/√(x²+b²) + (a-x)/√((a-x)²+b²))/2. A point on the back at z sees
/// the floor as (1 - z/√(z²+a²))/2.
TEST(Shelf, DirectLightIsThatOfStrips) {
    for (const double b : {0.3, 1.0, 4.0}) {
        ShelfParameters p;
        p.b = b;
        p.E = {0.25, 1.0, 2.0};
        const Shelf exact(p);
        for (const double t : {0.001, 0.1, 0.5, 0.99}) {
            const double near = t / std::hypot(t, b), far = (1.0 - t) / std::hypot(1.0 - t, b);
            const ReferenceLight on_floor = exact.at(Vec3(t, 3.0, 0.0), Vec3::UnitZ());
            EXPECT_NEAR(*on_floor.H_direct, 0.5 * (1.0 - near) + 0.5 * 2.0 * (near + far), 1e-7) << t;
            const double z = t * b;
            const ReferenceLight on_back = exact.at(Vec3(0.0, -1.0, z), Vec3::UnitX());
            EXPECT_NEAR(*on_back.H_direct,
                        0.5 * 0.25 * (1.0 - z / std::hypot(z, 1.0)) +
                            0.5 * 2.0 * (1.0 - (b - z) / std::hypot(b - z, 1.0)),
                        1e-7)
                << t;
        }
    }
}

/// With A alone reflecting the light of B, the means are the closed form factors, and the patches are exact.
TEST(Shelf, MeansOfASingleBounceAreTheClosedFormFactors) {
    for (const double b : {0.3, 1.0, 4.0}) {
        ShelfParameters p;
        p.b = b;
        p.E = {0.0, 1.0, 0.0};
        p.rho = {0.7, 0.0, 0.0};
        EXPECT_NEAR(Shelf(p).mean_radiosity()[0], 0.7 * shelf(1.0, b).AB, 1e-8) << b;
        EXPECT_NEAR(Shelf(p).mean_radiosity()[0], shelf_patches(p)[0], 1e-8) << b;
    }
}

/// Where light is reflected twice, one patch for each surface is an approximation: the light that B receives from A is
/// brighter below than above, and near the corner more of it returns.
TEST(Shelf, PatchesAreOffByWhatVariesOverASurface) {
    const Lighting both = lightings()[3];
    const ShelfParameters p = shelf_of(both, 1.0);
    const std::array<double, 3> exact = Shelf(p).mean_radiosity(), patches = shelf_patches(p);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(patches[i], exact[i], 0.02 * exact[i]);
        EXPECT_GT(std::abs(patches[i] - exact[i]), 1e-5 * exact[i]);
    }
}

TEST(Shelf, IsUnchangedByExchangeOfFloorAndCeiling) {
    ShelfParameters p, q;
    p.E = {1.0, 0.5, 0.0};
    p.rho = {0.6, 0.7, 0.2};
    q.E = {0.0, 0.5, 1.0};
    q.rho = {0.2, 0.7, 0.6};
    const Shelf one(p), other(q);
    for (const double t : {0.01, 0.3, 0.8}) {
        EXPECT_NEAR(one.at(Vec3(t, 0, 0), Vec3::UnitZ()).H, other.at(Vec3(t, 0, 1), -Vec3::UnitZ()).H, 1e-12);
        EXPECT_NEAR(one.at(Vec3(0, 0, t), Vec3::UnitX()).H, other.at(Vec3(0, 0, 1 - t), Vec3::UnitX()).H, 1e-12);
    }
}

/// The share of the view beyond the ends falls as the third power of their distance.
TEST(Shelf, FiniteOnesLackLightOfTheThirdOrder) {
    const Shelf exact(ShelfParameters{});
    const double at_100 = exact.missing(100.0), at_200 = exact.missing(200.0);
    EXPECT_NEAR(at_100 / at_200, 8.0, 0.5);
    EXPECT_LT(at_100, 1e-4);
}

/// Of a floor of length L, only what is within about the depth of an end lacks a part of the back or ceiling: form
/// factors, and with them patches, approach those of the infinite shelf as 1/L. The middle lacks a third power of it.
TEST(ShelfStudy, ShelvesApproachTheInfiniteOne) {
    BakeOptions options;
    options.spacing = 0.5;
    options.rays = 16;
    options.error_points = 0;
    MeasureOptions how;
    how.places = 20;
    const std::vector<ShelfTrial> trials =
        shelf_study(test::registry(), {16.0, 32.0}, options, how, Execution{}, [](const ShelfTrial&) {});
    for (const ShelfTrial& trial : trials) {
        EXPECT_NEAR(trial.AB, rectangles_with_common_edge(trial.length, 1.0, 1.0), 1e-8);
        EXPECT_NEAR(trial.BA, trial.AB, 1e-8);
        EXPECT_NEAR(trial.AC, opposite_rectangles(1.0, trial.length, 1.0), 1e-8);
        EXPECT_LT(trial.middle.total.l2.relative().value_or(1.0), 0.1);
    }
    EXPECT_NEAR(trials[0].factors_off / trials[1].factors_off, 2.0, 0.02);
    EXPECT_NEAR(trials[0].patches_off / trials[1].patches_off, 2.0, 0.02);
    EXPECT_GT(trials[0].bound, trials[1].bound);
}

TEST(Shelf, RefusesWhatIsNone) {
    ShelfParameters p;
    p.a = 0.0;
    EXPECT_THROW(Shelf{p}, UsageError);
    p.a = 20.0;
    EXPECT_THROW(Shelf{p}, UsageError);
    p.a = 1.0;
    p.rho[1] = 1.0;
    EXPECT_THROW(Shelf{p}, UsageError);
    EXPECT_THROW(shelf_patches(p), UsageError);
}

} // namespace
} // namespace difusa::references_shelf_test
