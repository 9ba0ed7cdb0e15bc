#include <difusa/study/references/bowl.h>
#include <difusa/study/references/sphere.h>

#include <difusa/core/error.h>
#include <difusa/core/random.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace difusa::references_sphere_bowl_test {
namespace {

constexpr double pi = std::numbers::pi;

/// The cap of the unit sphere up to the angle beta from (0, 0, -1), by midpoints of n by 2n cells of equal area:
/// the mean of f(p) over the cap.
double mean_over_cap(double beta, int n, const std::function<double(const Vec3&)>& f) {
    double sum = 0.0;
    for (int i = 0; i < n; ++i) {
        const double z = -1.0 + (1.0 - std::cos(beta)) * (i + 0.5) / n, radius = std::sqrt(1.0 - z * z);
        for (int k = 0; k < 2 * n; ++k) {
            const double angle = pi * (k + 0.5) / n;
            sum += f(Vec3(radius * std::cos(angle), radius * std::sin(angle), z));
        }
    }
    return sum / (2.0 * n * n);
}

double form_factor(const Vec3& x, const Vec3& n_x, const Vec3& y, const Vec3& n_y) {
    const Vec3 d = y - x;
    return std::max(0.0, n_x.dot(d)) * std::max(0.0, -n_y.dot(d)) / (pi * d.squaredNorm() * d.squaredNorm());
}

TEST(InsideOfSphere, KnownMeans) {
    // <z²> = 1/3, <1 + x> = 1, <exp z> = sinh 1.
    EXPECT_NEAR(InsideOfSphere(0.5, [](const Vec3& p) { return p.z() * p.z(); }).mean_emission(), 1.0 / 3.0, 1e-15);
    EXPECT_NEAR(InsideOfSphere(0.5, [](const Vec3& p) { return 1.0 + p.x(); }).mean_emission(), 1.0, 1e-14);
    EXPECT_NEAR(InsideOfSphere(0.5, [](const Vec3& p) { return std::exp(p.y()); }).mean_emission(), std::sinh(1.0),
                1e-11);
}

/// B = E + rho ∫ B F dA with the form factor of two points written out.
TEST(InsideOfSphere, SolvesTheRadiosityEquation) {
    const double radius = 3.0, rho = 0.7;
    const InsideOfSphere sphere(rho, [](const Vec3& p) { return std::exp(p.x() + 0.5 * p.z()); });
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0.6, 0, -0.8), Vec3(-2, 3, 1)}) {
        const Vec3 n = -direction.normalized(), x = -radius * n;
        const ReferenceLight light = sphere.at(x, n);
        const auto received = [&](bool direct, int nodes) {
            return 4.0 * pi * radius * radius * mean_over_cap(pi, nodes, [&](const Vec3& p) {
                       const ReferenceLight from = sphere.at(radius * p, -p);
                       return (direct ? from.E : from.B()) * form_factor(x, n, radius * p, -p);
                   });
        };
        // Midpoints in the height: second order. The next error is a quarter; what is left is a third of the last step.
        const double coarse = received(false, 60), fine = received(false, 120);
        EXPECT_NEAR(fine, light.H, std::abs(fine - coarse));
        EXPECT_GT(std::abs(coarse - light.H), 2.0 * std::abs(fine - light.H));
        EXPECT_NEAR(received(true, 120), light.H_direct.value(), std::abs(fine - coarse));
        EXPECT_EQ(light.B(), light.E + rho * light.H);
    }
}

TEST(InsideOfSphere, AConstantIsAFurnace) {
    const InsideOfSphere sphere(0.75, [](const Vec3&) { return 2.0; });
    EXPECT_NEAR(sphere.at(Vec3(0, 3, 4), Vec3(0, -0.6, -0.8)).B(), 8.0, 1e-13);
}

TEST(InsideOfSphere, AnEmissionWithJumpsNeedsItsMean) {
    const auto polar_light = [](const Vec3& p) { return p.z() > 0.9 ? 1.0 : 0.0; };
    EXPECT_THROW(InsideOfSphere(0.5, polar_light), NotConverged);
    const InsideOfSphere sphere(0.5, polar_light, 0.05);
    EXPECT_EQ(sphere.at(Vec3(1, 0, 0), Vec3(-1, 0, 0)).H, 0.1);
    EXPECT_EQ(sphere.at(Vec3(0, 0, 2), Vec3(0, 0, -1)).B(), 1.05);
}

TEST(InsideOfSphere, BadParametersAreRefused) {
    const auto one = [](const Vec3&) { return 1.0; };
    EXPECT_THROW(InsideOfSphere(1.0, one), UsageError);
    EXPECT_THROW(InsideOfSphere(-0.1, one), UsageError);
    EXPECT_THROW(InsideOfSphere(0.5, one, -1.0), UsageError);
    EXPECT_THROW(InsideOfSphere(0.5, [](const Vec3& p) { return p.x(); }), UsageError);
    EXPECT_THROW(InsideOfSphere(0.5, [](const Vec3&) { return std::numeric_limits<double>::infinity(); }), UsageError);
    EXPECT_THROW(InsideOfSphere(0.5, one).at(Vec3::Zero(), Vec3::UnitX()), UsageError);
}

const std::array<double, 4> half_angles{0.4, 1.2, 0.5 * pi, 2.4}, elevations{0.1, 0.7, 1.3, 0.5 * pi};

Bowl bowl(double beta, double elevation, double azimuth = 0.3) {
    return Bowl(
        {beta, 0.8,
         Vec3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
             .normalized(),
         3.0, 0.0});
}

/// All of the light that passes the opening lands in the bowl, whatever its depth and the sun's height.
TEST(Bowl, WhatEntersLands) {
    for (const double beta : half_angles) {
        for (const double elevation : elevations) {
            const Bowl b = bowl(beta, elevation);
            const auto landed = [&](int n) {
                return mean_over_cap(beta, n, [&](const Vec3& p) { return b.at(p, -p).H_direct.value(); });
            };
            const double entered = 3.0 * std::sin(elevation) * (1.0 - b.share());
            // The shadow's edge cuts at most about 4 of 2n cells in each of n rows, by F0 at most.
            EXPECT_NEAR(landed(300), entered, 3.0 * 4.0 / 600.0) << beta << " " << elevation;
        }
    }
}

/// A ray towards the sun, tried against the sphere below the rim by solving the quadratic equation, and against all of
/// the cap by stepping along it.
TEST(Bowl, LitPointsSeeTheSun) {
    RandomStream stream(1, "points");
    int lit = 0, shaded = 0;
    for (const double beta : half_angles) {
        for (const double elevation : elevations) {
            const Bowl b = bowl(beta, elevation, 0.0);
            const Vec3 s(std::cos(elevation), 0.0, std::sin(elevation));
            for (int i = 0; i < 200; ++i) {
                const double z = -1.0 + (1.0 - std::cos(beta)) * stream.uniform(), angle = 2.0 * pi * stream.uniform();
                const Vec3 p(std::sqrt(1.0 - z * z) * std::cos(angle), std::sqrt(1.0 - z * z) * std::sin(angle), z);
                // Inside of the sphere until it is above the rim?
                bool sees = -p.dot(s) > 0.0;
                const double to_rim = (-std::cos(beta) - p.z()) / s.z();
                sees = sees && (p + to_rim * s).squaredNorm() < 1.0;
                EXPECT_EQ(b.lit(2.5 * p), sees) << p.transpose();
                (sees ? lit : shaded) += 1;
            }
        }
    }
    EXPECT_GT(lit, 100);
    EXPECT_GT(shaded, 100);
}

/// Seen from the point of the rim below the sun, the sun sets at the elevation beta.
TEST(Bowl, TheShadowBeginsAtTheRim) {
    for (const double beta : {0.3, 0.9, 1.4}) {
        const Vec3 rim(std::sin(beta), 0.0, -std::cos(beta));
        EXPECT_FALSE(bowl(beta, beta - 1e-6, 0.0).lit(rim));
        EXPECT_TRUE(bowl(beta, beta + 1e-6, 0.0).lit(0.999999 * rim + Vec3(-1e-9, 0, 0)));
    }
}

/// H_indirect = ∫ B F dA with the form factor of two points written out.
TEST(Bowl, SolvesTheRadiosityEquation) {
    for (const double beta : {0.9, 2.2}) {
        const Bowl b = bowl(beta, 0.6);
        const double area = 2.0 * pi * (1.0 - std::cos(beta)) * 4.0;
        for (const Vec3& direction : {Vec3(0, 0, -1), Vec3(0.3, 0.4, -1)}) {
            const Vec3 n = -direction.normalized();
            const double received = area * mean_over_cap(beta, 300, [&](const Vec3& p) {
                                        return b.at(2.0 * p, -p).B() * form_factor(-2.0 * n, n, 2.0 * p, -p);
                                    });
            const ReferenceLight light = b.at(-2.0 * n, n);
            EXPECT_NEAR(received, b.indirect(), b.share() * 0.8 * 3.0 * 4.0 / 600.0); // as above, times rho f
            EXPECT_NEAR(light.H - light.H_direct.value(), b.indirect(), 1e-15);
        }
    }
}

/// Under a sky alone H = (1 - f)/(1 - rho f) of it: what enters is absorbed or leaves.
TEST(Bowl, UnderASky) {
    const Bowl b({2.0 * pi / 3.0, 0.8, Vec3::UnitZ(), 0.0, 1.0});
    EXPECT_NEAR(b.share(), 0.75, 1e-15);
    const ReferenceLight light = b.at(-Vec3::UnitZ(), Vec3::UnitZ());
    EXPECT_NEAR(light.H, 0.625, 1e-15);
    EXPECT_NEAR(light.H_direct.value(), 0.25, 1e-15);
    EXPECT_NEAR((1.0 - 0.8) * light.H + 0.8 * light.H * (1.0 - b.share()), 0.25, 1e-15);
}

TEST(Bowl, BadParametersAreRefused) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Vec3 up = Vec3::UnitZ();
    for (const BowlParameters& p : {BowlParameters{0.0, 0.8, up, 1.0, 0.0},
                                    {pi, 0.8, up, 1.0, 0.0},
                                    {1.0, 1.1, up, 1.0, 0.0},
                                    {1.0, 0.8, Vec3::UnitX(), 1.0, 0.0},
                                    {1.0, 0.8, Vec3(0.6, 0.0, -0.8), 1.0, 0.0},
                                    {1.0, 0.8, 2.0 * up, 1.0, 0.0},
                                    {1.0, 0.8, up, -1.0, 0.0},
                                    {1.0, 0.8, up, 1.0, -1.0},
                                    {nan, 0.8, up, 1.0, 0.0},
                                    {1.0, nan, up, 1.0, 0.0},
                                    {1.0, 0.8, Vec3(nan, 0, 1), 1.0, 0.0},
                                    {1.0, 0.8, up, nan, 0.0}}) {
        EXPECT_THROW(Bowl{p}, UsageError);
    }
    EXPECT_THROW(Bowl({}).lit(Vec3::Zero()), UsageError);
}

} // namespace
} // namespace difusa::references_sphere_bowl_test
