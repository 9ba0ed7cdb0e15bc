// The parts of the sky: their number, order, size and integrals.
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/scene/sky_division.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa::sky_division_test {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180.0;

Vec3 random_direction(RandomStream& stream) {
    const double z = 2.0 * stream.uniform() - 1.0, angle = 2.0 * pi * stream.uniform(), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

class SkyDivisions : public testing::TestWithParam<int> {
  protected:
    const SkyDivision sky{GetParam(), Vec3::UnitZ(), Vec3::UnitY()};
};

TEST_P(SkyDivisions, CoverTheSphere) {
    const int f = GetParam();
    EXPECT_EQ(sky.count(), static_cast<Index>(144 * f * f + 2)) << "146, 578, 2306";
    double above = 0.0, projected = 0.0;
    for (Index part = 1; part < sky.count(); ++part) {
        above += sky.cell(part).solid_angle();
        projected += sky.moment(sky.cell(part)).z();
    }
    EXPECT_NEAR(above, 2.0 * pi, 1e-12);
    EXPECT_NEAR(projected, pi, 1e-12);
    EXPECT_NEAR(sky.cell(0).solid_angle(), 2.0 * pi, 1e-14);
    EXPECT_NEAR(sky.moment(sky.cell(0)).z(), -pi, 1e-14);
    EXPECT_NEAR(sky.level_irradiance(Values::Ones(sky.count(), 1))[0], pi, 1e-12);
}

TEST_P(SkyDivisions, KnowWhichPartADirectionIsIn) {
    RandomStream stream(1, "places");
    for (Index part = 0; part < sky.count(); ++part) {
        ASSERT_EQ(sky.at(sky.centre(part)), part);
        ASSERT_EQ(sky.at(sky.direction(sky.cell(part), 0.01 + 0.98 * stream.uniform(), 0.01 + 0.98 * stream.uniform())),
                  part);
    }
    EXPECT_EQ(sky.at(Vec3::UnitZ()), sky.count() - 1);
    EXPECT_EQ(sky.at(-Vec3::UnitZ()), 0U);
}

TEST_P(SkyDivisions, AreCutIntoCellsOfEqualSolidAngle) {
    const std::vector<SkyCell> cells = sky.cells(6);
    ASSERT_EQ(cells.size(), 2 * 6 * static_cast<std::size_t>(sky.count() - 1));
    std::vector<double> size(sky.count(), 0.0);
    std::vector<Vec3> moment(sky.count(), Vec3::Zero());
    for (const SkyCell& cell : cells) {
        size[cell.part] += cell.solid_angle();
        moment[cell.part] += sky.moment(cell);
        if (cell.part != 0) {
            ASSERT_NEAR(cell.solid_angle(), sky.cell(cell.part).solid_angle() / 6.0, 1e-14);
        }
    }
    for (Index part = 0; part < sky.count(); ++part) {
        ASSERT_NEAR(size[part], sky.cell(part).solid_angle(), 1e-12);
        ASSERT_LE((moment[part] - sky.moment(sky.cell(part))).norm(), 1e-12);
    }
}

INSTANTIATE_TEST_SUITE_P(Factors, SkyDivisions, testing::Values(1, 2, 4));

/// Radiance: from north eastward, row by row from the horizon up.
TEST(SkyDivision, IsInTheOrderOfRadiance) {
    const SkyDivision sky(1, Vec3::UnitZ(), Vec3::UnitY());
    const double height = 90.0 / 7.5 * degree;
    const auto expect = [&](Index part, double elevation, double azimuth) {
        const Vec3 wanted(std::cos(elevation) * std::sin(azimuth), std::cos(elevation) * std::cos(azimuth),
                          std::sin(elevation));
        EXPECT_LE((sky.centre(part) - wanted).norm(), 1e-12) << part;
    };
    expect(1, 0.5 * height, 0.0);
    expect(2, 0.5 * height, 12.0 * degree);
    expect(30, 0.5 * height, 348.0 * degree);
    const Index first[] = {1, 31, 61, 85, 109, 127, 139};
    for (int row = 0; row < 7; ++row) {
        expect(first[row], (row + 0.5) * height, 0.0);
    }
    expect(140, 6.5 * height, 60.0 * degree);
    EXPECT_EQ(sky.centre(145), Vec3::UnitZ());
    // Parts of a part lie side by side around its middle: with two columns for one, north is in the middle of the
    // first.
    const SkyDivision finer(2, Vec3::UnitZ(), Vec3::UnitY());
    EXPECT_LE((finer.centre(2) - Vec3(std::cos(90.0 / 14.5 / 2 * degree) * std::sin(6.0 * degree),
                                      std::cos(90.0 / 14.5 / 2 * degree) * std::cos(6.0 * degree),
                                      std::sin(90.0 / 14.5 / 2 * degree)))
                  .norm(),
              1e-12);
}

TEST(SkyDivision, MayBeTurned) {
    const SkyDivision sky(1, Vec3::UnitY(), Vec3(0, 0.7, -1));
    EXPECT_LE((sky.north() - Vec3(0, 0, -1)).norm(), 1e-15);
    EXPECT_GT(sky.centre(2).x(), 0.0) << "east is +x where up is +y and north -z";
    EXPECT_EQ(sky.at(Vec3::UnitY()), 145U);
    EXPECT_THROW(SkyDivision(1, Vec3::UnitY(), Vec3::UnitY()), UsageError);
    EXPECT_THROW(SkyDivision(0, Vec3::UnitZ(), Vec3::UnitY()), UsageError);
    EXPECT_THROW(SkyDivision(17, Vec3::UnitZ(), Vec3::UnitY()), UsageError);
}

/// A midpoint rule of n² points has an error of about (size / n)² / 24 of the integrand's second derivative, below 1.
TEST(SkyDivision, MomentsAreIntegrals) {
    const SkyDivision sky(1, Vec3::UnitZ(), Vec3::UnitY());
    constexpr int n = 32;
    for (Index part = 1; part < sky.count(); part += 7) {
        const SkyCell& cell = sky.cell(part);
        Vec3 sum = Vec3::Zero();
        for (int i = 0; i < n * n; ++i) {
            const double u = (i / n + 0.5) / n, v = (i % n + 0.5) / n; // NOLINT: whole rows
            sum += cell.solid_angle() / (n * n) * sky.direction(cell, u, v);
        }
        EXPECT_LE((sum - sky.moment(cell)).norm(), cell.solid_angle() * std::pow(60.0 * degree / n, 2)) << part;
    }
}

/// Against the least height of many directions of the cell: that is above the true least height by at most the distance
/// between directions.
TEST(SkyDivision, TellsWhatIsAboveAPlane) {
    const SkyDivision sky(1, Vec3::UnitZ(), Vec3::UnitY());
    RandomStream stream(2, "planes");
    constexpr int n = 24;
    std::size_t sure = 0;
    for (int trial = 0; trial < 40; ++trial) {
        const Vec3 normal = random_direction(stream);
        for (Index part = 0; part < sky.count(); part += 3) {
            double least = 1.0;
            for (int i = 0; i < (n + 1) * (n + 1); ++i) {
                const double u = i / (n + 1) / double{n}, v = i % (n + 1) / double{n}; // NOLINT: whole rows
                least = std::min(least, normal.dot(sky.direction(sky.cell(part), u, v)));
            }
            if (least < -1e-9) {
                ASSERT_FALSE(sky.is_above(sky.cell(part), normal));
                ++sure;
            } else if (least > (part == 0 || part == 145 ? 0.3 : 0.02)) {
                ASSERT_TRUE(sky.is_above(sky.cell(part), normal));
                ++sure;
            }
        }
    }
    EXPECT_GT(sure, 1500U);
    for (Index part = 1; part < sky.count(); ++part) {
        ASSERT_TRUE(sky.is_above(sky.cell(part), Vec3::UnitZ()));
    }
}

} // namespace
} // namespace difusa::sky_division_test
