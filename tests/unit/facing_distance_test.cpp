// How near what a point faces is: exact beside walls, under plates and in a ball, and against a look at all triangles.
#include <difusa/core/random.h>
#include <difusa/discretisation/facing_distance.h>

#include "meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace difusa::facing_distance_test {
namespace {

constexpr double third = 1.0 / 3.0;

TEST(FacingDistance, IsTwiceThatToAWallAndThatToACeiling) {
    const Mesh room = test::box(Vec3(2.0, 3.0, 1.5), 3, true);
    const FacingDistance facing(room);
    int near_walls = 0;
    for (Index t = 0; t < room.triangles.size(); ++t) {
        const SurfacePoint x = room.at(t, 0.5, 0.2);
        const Vec3 below = x.position - room.low, above = room.high - x.position;
        int axis = 0;
        x.normal.cwiseAbs().maxCoeff(&axis);
        double nearest = (room.high - room.low)[axis];
        for (int k = 0; k < 3; ++k) {
            if (k != axis && 2.0 * std::min(below[k], above[k]) < nearest) {
                nearest = 2.0 * std::min(below[k], above[k]);
                ++near_walls;
            }
        }
        EXPECT_NEAR(facing(x, 10.0), nearest, 1e-12);
        EXPECT_EQ(facing(x, 0.9 * nearest), 0.9 * nearest) << "nothing is nearer than this";
    }
    EXPECT_GT(near_walls, 20);
    const Mesh block = test::box(1.0);
    EXPECT_EQ(FacingDistance(block)(block.at(0, third, third), 10.0), 10.0) << "nothing is before it";
}

/// A thin plate is in the way whichever side it turns.
TEST(FacingDistance, CountsBacksToo) {
    const Mesh floor = test::grid(4, 4, 8.0, 8.0);
    for (const bool inward : {false, true}) {
        const Mesh plate = test::moved(test::grid(1, 1, 8.0, 8.0, inward), 1.0, Vec3(0.0, 0.0, 0.25));
        const Mesh both = test::together(floor, plate);
        EXPECT_NEAR(FacingDistance(both)(both.at(9, third, third), 10.0), 0.25, 1e-12);
    }
}

/// On a sphere the quotient is 2 R / sin(β/2), least at the far end; the next facets do not count.
TEST(FacingDistance, IsTheDiameterInABall) {
    const Mesh ball = test::icosphere(3, 1.0, true);
    const FacingDistance facing(ball);
    for (Index t = 0; t < ball.triangles.size(); t += 7) {
        const SurfacePoint x = ball.at(t, third, third);
        const double height = std::abs(x.position.dot(x.normal)); // of all facets at least 0.99
        EXPECT_GE(facing(x, 10.0), height + 0.99);
        EXPECT_LE(facing(x, 10.0), 2.0);
    }
}

TEST(FacingDistance, IsWhatALookAtAllTrianglesFinds) {
    RandomStream random(1, "soup");
    const auto place = [&](double size) {
        const double x = random.uniform(), y = random.uniform(), z = random.uniform();
        return Vec3(size * Vec3(x, y, z));
    };
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (Index t = 0; t < 40; ++t) {
        const Vec3 centre = place(1.0);
        for (Index k = 0; k < 3; ++k) {
            points.emplace_back(centre + place(0.4));
        }
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const Mesh soup = test::make_mesh(points, triangles);
    const FacingDistance facing(soup);
    constexpr int n = 64;
    const double step = 0.7 / n; // of the samples below: edges are at most 0.4 √3
    for (Index t = 0; t < soup.triangles.size(); ++t) {
        const SurfacePoint x = soup.at(t, 0.3, 0.3);
        const double found = facing(x, 100.0);
        double above = std::numeric_limits<double>::infinity(), reached = 100.0;
        for (Index other = 0; other < soup.triangles.size(); ++other) {
            for (int i = 0; i <= n && other != t; ++i) {
                for (int j = 0; i + j <= n; ++j) {
                    const Vec3 y = soup.at(other, static_cast<double>(i) / n, static_cast<double>(j) / n).position;
                    const double height = x.normal.dot(y - x.position), distance = (y - x.position).norm();
                    const Vec3 normal = soup.normals[other];
                    const double cosine = (normal.dot(x.position - y) < 0.0 ? -1.0 : 1.0) * normal.dot(x.normal);
                    const double quotient = 2.0 / (1.0 - cosine);
                    if (height > 0.0) {
                        above = std::min(above, distance * quotient);
                    }
                    if (height > -step) {
                        reached = std::min(reached, (distance - step) * quotient);
                    }
                }
            }
        }
        EXPECT_LE(found, above * (1.0 + 1e-12));
        EXPECT_GE(found, reached);
    }
}

} // namespace
} // namespace difusa::facing_distance_test
