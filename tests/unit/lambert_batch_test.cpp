#include <difusa/core/angle.h>
#include <difusa/core/random.h>
#include <difusa/rays/lambert.h>
#include <difusa/rays/lambert_batch.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

namespace difusa::lambert_batch_test {
namespace {

Vec3 random_point(RandomStream& stream) {
    const double x = stream.uniform(), y = stream.uniform(), z = stream.uniform();
    return 2.0 * Vec3(x, y, z) - Vec3::Ones();
}

TEST(AngleBetween, IsTheArcTangent) {
    RandomStream stream(3, "angles");
    for (int i = 0; i < 200000; ++i) {
        const double sine = stream.uniform() * std::exp2(60.0 * stream.uniform() - 30.0);
        const double cosine = (2.0 * stream.uniform() - 1.0) * std::exp2(60.0 * stream.uniform() - 30.0);
        const long double exact = std::atan2(static_cast<long double>(sine), static_cast<long double>(cosine));
        const double unit = std::nextafter(static_cast<double>(exact), 4.0) - static_cast<double>(exact);
        EXPECT_LE(std::abs(static_cast<long double>(angle_between(sine, cosine)) - exact), 4.0 * unit)
            << sine << " " << cosine;
    }
}

TEST(AngleBetween, EndsAndMiddle) {
    constexpr double pi = std::numbers::pi, tiny = std::numeric_limits<double>::min();
    EXPECT_EQ(angle_between(0.0, 1.0), 0.0);
    EXPECT_EQ(angle_between(0.0, -1.0), pi);
    EXPECT_EQ(angle_between(1.0, 0.0), pi / 2.0);
    EXPECT_EQ(angle_between(1.0, 1.0), pi / 4.0);
    EXPECT_EQ(angle_between(1.0, -1.0), pi - pi / 4.0);
    EXPECT_EQ(angle_between(tiny, 1.0), tiny);
    EXPECT_EQ(angle_between(1.0, tiny), pi / 2.0);
    EXPECT_EQ(angle_between(tiny, tiny), pi / 4.0);
}

/// Triangles anywhere around the element: in front and behind, above, below and across the horizon; for numbers that
/// fill blocks and numbers that do not.
TEST(LambertBatch, IsTheFormFactorOfEachTriangle) {
    RandomStream stream(5, "triangles");
    std::size_t whole = 0, clipped = 0;
    for (std::size_t count = 0; count <= 2 * LambertBatch::lanes + 1; ++count) {
        for (int round = 0; round < 500; ++round) {
            Mesh mesh;
            std::vector<Index> triangles(count);
            std::iota(triangles.begin(), triangles.end(), Index{0});
            for (std::size_t t = 0; t < count; ++t) {
                const auto first = static_cast<Index>(mesh.points.size());
                const Vec3 at = random_point(stream);
                const double size = std::exp2(-20.0 * stream.uniform());
                for (int k = 0; k < 3; ++k) {
                    mesh.points.emplace_back(at + size * random_point(stream));
                }
                mesh.triangles.push_back({first, first + 1, first + 2});
            }
            const Vec3 x = 0.3 * random_point(stream), n = random_point(stream).normalized();
            std::vector<double> F(count, -1.0);
            LambertBatch(mesh, triangles).form_factors(x, n, F);
            for (std::size_t t = 0; t < count; ++t) {
                const auto corners = mesh.corners(triangles[t]);
                const double one = lambert_form_factor(x, n, corners);
                const auto below = std::count_if(corners.begin(), corners.end(),
                                                 [&](const Vec3& corner) { return n.dot(corner - x) < 0.0; });
                if (one == 0.0 || below > 0) {
                    EXPECT_EQ(F[t], one);
                    clipped += one > 0.0 ? 1 : 0;
                } else {
                    // Three terms, each up to 1/2 and off by up to 4 (angle) + 4 units in the last place.
                    EXPECT_NEAR(F[t], one, 3.0 * 0.5 * 8.0 * 0x1p-53);
                    ++whole;
                }
            }
        }
    }
    EXPECT_GT(whole, 1000U);
    EXPECT_GT(clipped, 1000U);
}

/// Where an edge has no angle or direction, lanes beside it are not disturbed.
TEST(LambertBatch, ElementsOnABorder) {
    Mesh mesh;
    mesh.points = {Vec3(0, 0, 0), Vec3(0, 2, 0), Vec3(0, 1, 2), Vec3(3, 0, 1), Vec3(3, 1, 1), Vec3(3, 0, 2)};
    mesh.triangles = {{0, 1, 2}, {3, 5, 4}};
    const std::vector<Index> triangles{0, 1};
    const LambertBatch batch(mesh, triangles);
    std::vector<double> F(2);
    for (const Vec3& x : {Vec3(0, 0, 0), Vec3(0, 2, 0), Vec3(0, 1, 0), Vec3(1e-300, 1, 0)}) {
        for (const Vec3& n : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitZ())}) {
            batch.form_factors(x, n, F);
            for (std::size_t t = 0; t < 2; ++t) {
                const double one = lambert_form_factor(x, n, mesh.corners(triangles[t]));
                EXPECT_NEAR(F[t], one, 3.0 * 0.5 * 8.0 * 0x1p-53) << x.transpose() << ", " << n.transpose();
            }
        }
    }
}

} // namespace
} // namespace difusa::lambert_batch_test
