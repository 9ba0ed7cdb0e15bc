#include <difusa/core/random.h>
#include <difusa/scene/sky_dome.h>
#include <difusa/scene/sky_parts.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

namespace difusa::sky_parts_test {
namespace {

constexpr double pi = std::numbers::pi;

TEST(SkyParts, EveryDirectionOfAPartLiesInIt) {
    RandomStream random(1, "directions");
    for (Index part = 0; part < SkyParts::count; ++part) {
        for (int k = 0; k < 4; ++k) {
            // A rounding away from the border of the part.
            const double u = 1e-9 + (1.0 - 2e-9) * random.uniform(), v = 1e-9 + (1.0 - 2e-9) * random.uniform();
            const Vec3 d = SkyParts::direction(part, u, v);
            EXPECT_NEAR(d.norm(), 1.0, 4 * 0x1p-53);
            ASSERT_EQ(SkyParts::at(d), part);
        }
    }
    for (const Vec3& d : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(-1, -1e-300, 0),
                          Vec3(1, -1e-300, 0), Vec3(0, -0.0, 1)}) {
        EXPECT_LT(SkyParts::at(d), SkyParts::count);
    }
}

/// Parts between latitudes sin(z) of equal steps and equal azimuths have equal solid angle (Archimedes): uniform
/// directions fall into each equally often. Chi-squared with n - 1 degrees of freedom is normal, mean n - 1 and
/// variance 2 (n - 1), for so many parts: 4.5 standard deviations are exceeded with a probability of 7e-6.
TEST(SkyParts, HaveEqualSolidAngles) {
    RandomStream random(2, "directions");
    constexpr int mean = 40;
    std::vector<int> count(SkyParts::count, 0);
    for (int k = 0; k < mean * static_cast<int>(SkyParts::count); ++k) {
        Vec3 d;
        do {
            d = Vec3(2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0);
        } while (d.squaredNorm() > 1.0 || d.squaredNorm() < 0x1p-40);
        ++count[SkyParts::at(d.normalized())];
    }
    double chi2 = 0.0;
    for (const int c : count) {
        chi2 += std::pow(c - mean, 2) / mean;
    }
    const double freedom = SkyParts::count - 1.0;
    EXPECT_NEAR(chi2, freedom, 4.5 * std::sqrt(2.0 * freedom));
}

class Gradient final : public SkyDome {
  public:
    Gradient(double horizon, double zenith) : horizon_(horizon), zenith_(zenith) {}
    Rgb radiance(const Vec3& towards) const override {
        const double up = std::max(0.0, towards.z());
        return Rgb(1, 2, 3) * (horizon_ + (zenith_ - horizon_) * up);
    }
    bool is_grey() const override { return false; }

  private:
    double horizon_, zenith_;
};

TEST(SkyParts, AUniformSkyIsItsIrradianceEverywhere) {
    Scene scene;
    scene.sky = Rgb(1, 2, 3);
    const Values sky = sky_radiosity(scene, 3);
    ASSERT_EQ(sky.rows(), static_cast<Eigen::Index>(SkyParts::count));
    for (Eigen::Index c = 0; c < 3; ++c) {
        EXPECT_TRUE((sky.col(c).array() == static_cast<double>(c + 1)).all());
    }
    EXPECT_EQ(sky_radiosity(scene, 1), sky.leftCols(1));
    EXPECT_EQ(sky_radiosity(Scene{}, 3), Values::Zero(SkyParts::count, 3));
}

/// The irradiance of a floor under the radiance h + (z - h) cos: the integral of cos over the hemisphere is pi, that of
/// cos² is 2 pi / 3, so it is pi (h + 2 z) / 3. A part's share of the hemisphere, cosine-weighted, is the same for all
/// of a band: (z1² - z0²) / (number of parts in a band). Within a part radiance and cosine are linear in z, so that the
/// product of their means falls short of the mean of their product by (z1 - z0)² / 12 of the slope, relative 1/64² / 4
/// of that of cos² = 1/3; and midpoints are exact for what is linear.
TEST(SkyParts, AGradientGivesAFloorItsClosedForm) {
    Scene scene;
    scene.sky = Rgb::Constant(0.25);
    const double horizon = 1.5, zenith = 0.5;
    scene.dome = std::make_shared<Gradient>(horizon, zenith);
    const Values sky = sky_radiosity(scene, 3);
    Eigen::RowVector3d irradiance = Eigen::RowVector3d::Zero();
    constexpr Index across = 2 * SkyParts::bands;
    for (Index part = SkyParts::count / 2; part < SkyParts::count; ++part) { // above the horizon
        const double z0 = 2.0 * (part / across) / SkyParts::bands - 1.0, z1 = z0 + 2.0 / SkyParts::bands;
        irradiance += (z1 * z1 - z0 * z0) / across * sky.row(part);
    }
    // ∫ (z - mean)² dz over bands of height d is d²/12 in all: the factor 2 of the cosine weight and the slope remain.
    const double d = 2.0 / SkyParts::bands, short_of_it = 2.0 * pi * (zenith - horizon) * d * d / 12.0;
    for (int c = 0; c < 3; ++c) {
        const double exact = (c + 1) * pi * (horizon + 2.0 * zenith) / 3.0 + 0.25;
        EXPECT_NEAR(irradiance[c], exact - (c + 1) * short_of_it, 1e-12 * exact);
        EXPECT_NEAR(irradiance[c], exact, 6e-4 * exact); // for a reader: what the cutting costs
    }
}

} // namespace
} // namespace difusa::sky_parts_test
