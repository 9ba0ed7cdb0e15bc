// Triangulations of what segments divide the plane into: areas, and no segment that crosses a triangle.
#include <difusa/core/random.h>
#include <difusa/mesh/arrangement.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace difusa::arrangement_test {
namespace {

using Vec2 = Eigen::Vector2d;
using Segments = std::vector<std::pair<Index, Index>>;

double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

double area_of(const Arrangement& all) {
    double sum = 0.0;
    for (const auto& [a, b, c] : all.triangles) {
        const double twice = twice_area(all.points[a], all.points[b], all.points[c]);
        EXPECT_GE(twice, 0.0);
        sum += 0.5 * twice;
    }
    return sum;
}

/// Whether the segment from p to q leads through the interior of a triangle shrunk by a thousandth.
bool crosses(const Vec2& p, const Vec2& q, const Arrangement& all, const std::array<Index, 3>& triangle) {
    const Vec2 middle = (all.points[triangle[0]] + all.points[triangle[1]] + all.points[triangle[2]]) / 3.0;
    double from = 0.0, to = 1.0; // the part within
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2 a = middle + 0.999 * (all.points[triangle[k]] - middle),
                   b = middle + 0.999 * (all.points[triangle[(k + 1) % 3]] - middle);
        const double at_p = twice_area(a, b, p), at_q = twice_area(a, b, q);
        if (at_p <= 0.0 && at_q <= 0.0) {
            return false;
        }
        if (at_p * at_q < 0.0) {
            (at_p < 0.0 ? from : to) =
                at_p < 0.0 ? std::max(from, at_p / (at_p - at_q)) : std::min(to, at_p / (at_p - at_q));
        }
    }
    return to - from > 1e-9;
}

TEST(Arrangement, NoSegmentCrossesATriangle) {
    RandomStream random(5, "segments");
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<Vec2> points{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        Segments segments;
        for (Index i = 0; i < 12; ++i) {
            for (int end = 0; end < 2; ++end) {
                points.emplace_back(random.uniform(), random.uniform());
            }
            segments.emplace_back(4 + 2 * i, 5 + 2 * i);
        }
        const Arrangement all = arrange(points, segments, 1e-12);
        EXPECT_NEAR(area_of(all), 1.0, 1e-12);
        for (const auto& [from, to] : segments) {
            for (const std::array<Index, 3>& triangle : all.triangles) {
                EXPECT_FALSE(crosses(points[from], points[to], all, triangle)) << "trial " << trial;
            }
        }
    }
}

/// Two segments that cross, where the crossing is known; a third that repeats one, and one along it.
TEST(Arrangement, CrossingsBecomePoints) {
    const std::vector<Vec2> points{{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 1}, {1.5, 1.5}};
    const Arrangement all = arrange(points, Segments{{0, 2}, {1, 3}, {2, 0}, {4, 5}}, 0.0);
    EXPECT_EQ(all.points.size(), points.size()); // they cross in a point that there is
    EXPECT_NEAR(area_of(all), 4.0, 1e-15);
    const Arrangement other =
        arrange(std::vector<Vec2>(points.begin(), points.begin() + 4), Segments{{0, 2}, {1, 3}}, 0.0);
    ASSERT_EQ(other.points.size(), 5U);
    EXPECT_EQ(other.points.back(), Vec2(1, 1));
    EXPECT_EQ(other.triangles.size(), 4U);
}

/// A diagonal from (1, 0) to (0, 1) passes the corners of a square from 0.3 to 0.7 at the distance of their rounding:
/// it goes through them.
TEST(Arrangement, SegmentsGoThroughPointsThatTheyPassClosely) {
    const std::vector<Vec2> points{{1, 0}, {1, 1}, {0, 1}, {0, 0}, {0.3, 0.3}, {0.3, 0.7}, {0.7, 0.7}, {0.7, 0.3}};
    const Arrangement all = arrange(points, Segments{{0, 2}, {4, 5}, {5, 6}, {6, 7}, {4, 7}, {5, 7}}, 1e-12);
    EXPECT_EQ(all.points.size(), points.size());
    double within = 0.0; // of the square
    for (const auto& [a, b, c] : all.triangles) {
        const Vec2 middle = (all.points[a] + all.points[b] + all.points[c]) / 3.0;
        within += (middle.array() > 0.3).all() && (middle.array() < 0.7).all()
                      ? 0.5 * twice_area(all.points[a], all.points[b], all.points[c])
                      : 0.0;
    }
    EXPECT_NEAR(within, 0.16, 1e-15);
    EXPECT_NEAR(area_of(all), 1.0, 1e-15);
}

/// Points that differ by less than the rounding are one.
TEST(Arrangement, PointsAtOnePlaceAreOne) {
    const std::vector<Vec2> points{{0, 0}, {1, 0}, {0, 1}, {1 + 1e-9, 1e-9}, {1, 1}};
    const Arrangement all = arrange(points, Segments{{0, 1}, {3, 4}}, 1e-6);
    for (const std::array<Index, 3>& triangle : all.triangles) {
        EXPECT_EQ(std::count(triangle.begin(), triangle.end(), 3U), 0);
    }
    EXPECT_EQ(all.triangles.size(), 2U);
}

} // namespace
} // namespace difusa::arrangement_test
