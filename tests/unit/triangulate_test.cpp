#include <difusa/mesh/triangulate.h>

#include <difusa/mesh/triangle_area.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "soups.h"
#include "support/sanitized.h"

namespace difusa::triangulate_test {
namespace {

using test::flat;
using Outcome = Triangulation::Outcome;

/// ½ Σ p_i × p_{i+1}, relative to the first corner.
Vec3 vector_area(const std::vector<Vec3>& polygon) {
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        area += 0.5 * (polygon[i] - polygon[0]).cross(polygon[(i + 1) % polygon.size()] - polygon[0]);
    }
    return area;
}

/// What rounding can change in an area: of the coordinates, eps × magnitude × perimeter a few times over; of a sum of
/// n terms, n eps × the sum of their magnitudes.
double area_tolerance(const std::vector<Vec3>& polygon) {
    double magnitude = 0.0, perimeter = 0.0, terms = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        magnitude = std::max(magnitude, p.cwiseAbs().maxCoeff());
        perimeter += (q - p).norm();
        terms += (p - polygon[0]).cross(q - polygon[0]).norm();
    }
    return std::numeric_limits<double>::epsilon() *
           (8.0 * magnitude * perimeter + static_cast<double>(polygon.size()) * terms);
}

/// The triangles cover the polygon exactly once: vector areas add up, and in a planar polygon their magnitudes too
/// (so none is turned over), none without an area; all corners are the polygon's.
void expect_cover(const std::vector<Vec3>& polygon, const Triangulation& cut) {
    ASSERT_EQ(cut.outcome, Outcome::done);
    Vec3 sum = Vec3::Zero();
    double magnitudes = 0.0;
    for (const auto& [a, b, c] : cut.triangles) {
        ASSERT_LT(std::max({a, b, c}), polygon.size());
        EXPECT_FALSE(without_area(polygon[a], polygon[b], polygon[c])) << a << ' ' << b << ' ' << c;
        const Vec3 area = 0.5 * twice_vector_area(polygon[a], polygon[b], polygon[c]);
        sum += area;
        magnitudes += area.norm();
    }
    const double tolerance = area_tolerance(polygon);
    EXPECT_LE((sum - vector_area(polygon)).norm(), tolerance);
    if (cut.planar) {
        EXPECT_NEAR(magnitudes, vector_area(polygon).norm(), tolerance);
    }
}

/// The same, and the n - 2 triangles of a simple polygon, under all motions.
void expect_simple(const std::vector<Vec3>& polygon, bool concave) {
    for (const test::Motion& motion : test::motions()) {
        SCOPED_TRACE(motion.name);
        const std::vector<Vec3> moved = motion(polygon);
        const Triangulation cut = triangulate(moved);
        expect_cover(moved, cut);
        EXPECT_EQ(cut.triangles.size(), polygon.size() - 2);
        EXPECT_EQ(cut.concave, concave);
        EXPECT_TRUE(cut.planar);
    }
}

void expect_outcome(const std::vector<Vec3>& polygon, Outcome outcome) {
    for (const test::Motion& motion : test::motions()) {
        SCOPED_TRACE(motion.name);
        EXPECT_EQ(triangulate(motion(polygon)).outcome, outcome);
    }
}

TEST(Triangulate, TriangleIsItself) {
    const Triangulation cut = triangulate(flat({{0, 0}, {1, 0}, {0, 1}}));
    EXPECT_EQ(cut.outcome, Outcome::done);
    EXPECT_THAT(cut.triangles, testing::ElementsAre(std::array<Index, 3>{0, 1, 2}));
}

TEST(Triangulate, NeedleOfAspectAMillionHasAnArea) {
    expect_simple(flat({{0, 0}, {1, 0}, {0.5, 1e-6}}), false);
}

TEST(Triangulate, CornersOnALineHaveNoArea) {
    expect_outcome(flat({{0, 0}, {1, 2}, {1.0 / 3, 2.0 / 3}}), Outcome::no_area);
    expect_outcome(flat({{0, 0}, {1, 2}, {1.0 / 3, 2.0 / 3}, {0.7, 1.4}}), Outcome::no_area);
    expect_outcome(flat({{0, 0}, {0.1, 0.3}, {0.2, 0.6}, {0.3, 0.9}, {0.4, 1.2}, {0.15, 0.45}}), Outcome::no_area);
}

TEST(Triangulate, AreaIsJudgedAxisByAxis) {
    // All of x is far away, but y and z tell the corners apart exactly.
    const std::vector<Vec3> triangle{{1e12, 0, 0}, {1e12, 1e-6, 0}, {1e12, 0, 1e-6}};
    EXPECT_EQ(triangulate(triangle).outcome, Outcome::done);
    // The same size tilted against x there is below the rounding of x.
    const std::vector<Vec3> lost{{1e12, 0, 0}, {1e12 + 1e-6, 1e-6, 0}, {1e12, 2e-6, 0}};
    EXPECT_EQ(triangulate(lost).outcome, Outcome::no_area);
}

TEST(Triangulate, ConvexQuadIsCutAlongTheShorterDiagonal) {
    expect_simple(flat({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), false);
    expect_simple(flat({{0, 0}, {2, -0.1}, {2, 0.9}, {0, 1}}), false);
    for (const test::Motion& motion : test::motions()) {
        SCOPED_TRACE(motion.name);
        // Equal diagonals stay equal under rounding: corner 0 decides.
        EXPECT_THAT(triangulate(motion(flat({{0, 0}, {3, 0}, {3, 1}, {0, 1}}))).triangles,
                    testing::ElementsAre(std::array<Index, 3>{0, 1, 2}, std::array<Index, 3>{0, 2, 3}));
        EXPECT_THAT(triangulate(motion(flat({{0, 0}, {1, -0.1}, {3, 1}, {0, 1}}))).triangles,
                    testing::ElementsAre(std::array<Index, 3>{0, 1, 3}, std::array<Index, 3>{1, 2, 3}));
    }
}

TEST(Triangulate, ConcaveQuadIsCutAtTheReflexCorner) {
    // Both diagonals as seen from each starting corner: only the one through the reflex corner (1, 1) is inside.
    const std::vector<Vec3> arrow = flat({{0, 0}, {1, 1}, {0, 3}, {3, 0.5}});
    expect_simple(flat({{0, 0}, {3, 0.5}, {0, 3}, {1, 1}}), true);
    expect_simple(arrow, true); // clockwise
}

TEST(Triangulate, RegularAndStarPolygonsWithHundredsOfCorners) {
    for (const std::size_t n : {5U, 6U, 64U, 401U}) {
        std::vector<Vec3> regular, star;
        for (std::size_t i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
            const Vec3 direction(std::cos(angle), std::sin(angle), 0.0);
            regular.push_back(direction);
            star.push_back((2 * i < n ? 1.0 : 0.5) * (i % 2 == 0 ? 1.0 : 0.3) * direction);
        }
        SCOPED_TRACE(n);
        expect_simple(regular, false);
        expect_simple(star, true);
    }
}

// Left out under the sanitizers: those that differ in their numbers only.
const std::uint64_t random_polygons = test::sanitized() ? 10 : 50;

TEST(Triangulate, RandomStarShapedPolygons) {
    for (std::uint64_t i = 0; i < random_polygons; ++i) {
        SCOPED_TRACE(i);
        RandomStream random(7, "polygon", i);
        const std::vector<Vec3> polygon = test::random_star(8 + random.below(200), random);
        expect_simple(polygon, true);
        expect_simple(std::vector<Vec3>(polygon.rbegin(), polygon.rend()), true);
    }
}

TEST(Triangulate, Spiral) {
    // A band of width 0.3 that winds eight times around the origin: every bounding circle lies.
    std::vector<Vec3> outer, inner;
    for (int i = 0; i <= 400; ++i) {
        const double angle = 16 * std::numbers::pi * i / 400, radius = 1 + angle / (2 * std::numbers::pi);
        outer.emplace_back((radius + 0.3) * std::cos(angle), (radius + 0.3) * std::sin(angle), 0.0);
        inner.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    }
    outer.insert(outer.end(), inner.rbegin(), inner.rend());
    expect_simple(outer, true);
}

TEST(Triangulate, CornersAlongStraightSides) {
    // Each side of the square in five parts: none of the corners may be lost, no triangle may lie along a side.
    std::vector<Vec3> square;
    for (int side = 0; side < 4; ++side) {
        for (int i = 0; i < 5; ++i) {
            const double t = i / 5.0;
            square.push_back(side == 0   ? Vec3(t, 0, 0)
                             : side == 1 ? Vec3(1, t, 0)
                             : side == 2 ? Vec3(1 - t, 1, 0)
                                         : Vec3(0, 1 - t, 0));
        }
    }
    expect_simple(square, false);
    // All but one corner on one line.
    expect_simple(flat({{0, 0}, {0.1, 0}, {0.3, 0}, {0.7, 0}, {1, 0}, {0.4, 1}}), false);
    expect_simple(flat({{0, 0}, {0.5, 0}, {1, 0}, {0, 1}}), false);
}

TEST(Triangulate, NonPlanarPolygonsKeepTheirVectorArea) {
    for (std::uint64_t i = 0; i < 30; ++i) {
        RandomStream random(11, "polygon", i);
        std::vector<Vec3> polygon = test::random_star(4 + random.below(60), random);
        for (Vec3& corner : polygon) {
            corner.z() = 0.2 * random.uniform();
        }
        for (const test::Motion& motion : test::motions()) {
            SCOPED_TRACE(std::to_string(i) + " " + motion.name);
            const std::vector<Vec3> moved = motion(polygon);
            const Triangulation cut = triangulate(moved);
            EXPECT_FALSE(cut.planar);
            EXPECT_EQ(cut.triangles.size(), polygon.size() - 2);
            expect_cover(moved, cut);
        }
    }
}

TEST(Triangulate, NonPlanarPolygonsAreSeenAlongTheirNormal) {
    // Stars that two half turns make equal, so that the heights do not tilt the Newell normal, (1, 1, 1): along it
    // they are simple, along a coordinate axis the heights shift corners across sides.
    const Eigen::Matrix3d tilt =
        Eigen::AngleAxisd(std::acos(std::sqrt(1.0 / 3.0)), Vec3(-1.0, 1.0, 0.0).normalized()).toRotationMatrix();
    for (std::uint64_t i = 0; i < 20; ++i) {
        SCOPED_TRACE(i);
        RandomStream random(13, "polygon", i);
        std::vector<Vec3> polygon = test::random_star(24, random);
        for (std::size_t k = 0; k < 12; ++k) {
            polygon[k].z() = random.uniform();
            polygon[k + 12] = Vec3(-polygon[k].x(), -polygon[k].y(), polygon[k].z());
        }
        for (Vec3& corner : polygon) {
            corner = tilt * corner;
        }
        const Triangulation cut = triangulate(polygon);
        EXPECT_FALSE(cut.planar);
        expect_cover(polygon, cut);
    }
}

TEST(Triangulate, PlanarMeansToAMillionthOfTheDiameter) {
    const auto warped = [](double height) {
        return std::vector<Vec3>{{0, 0, 0}, {1, 0, height}, {1, 1, 0}, {0, 1, height}};
    };
    for (const double scale : {1e-6, 1.0, 1e6}) {
        test::Motion zoom;
        zoom.scale = scale;
        const auto planar = [&](double height) { return triangulate(zoom(warped(height))).planar; };
        EXPECT_TRUE(planar(2e-6));  // deviation 1e-6, diameter √2
        EXPECT_FALSE(planar(4e-6)); // deviation 2e-6
    }
}

TEST(Triangulate, CrossingSidesAreRefused) {
    expect_outcome(flat({{0, 0}, {1, 1}, {1, 0}, {0, 1}}), Outcome::crosses_itself); // bow-tie, signed area 0
    expect_outcome(flat({{0, 0}, {2, 2}, {2, 0}, {0, 1}}), Outcome::crosses_itself); // bow-tie, signed area left
    expect_outcome(flat({{0, 0}, {4, 0}, {4, 2}, {2, -1}, {0, 2}}), Outcome::crosses_itself);
    std::vector<Vec3> pentagram; // all corners turn the same way, but twice around
    for (int i = 0; i < 5; ++i) {
        const double angle = 4 * std::numbers::pi * i / 5;
        pentagram.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    }
    expect_outcome(pentagram, Outcome::crosses_itself);
}

TEST(Triangulate, TheCrossingIsLocated) {
    const std::vector<Vec3> polygon = flat({{10, 0}, {20, 0}, {20, 10}, {12, 9}, {13, 11}, {13, 9.2}, {10, 10}});
    const Triangulation cut = triangulate(polygon);
    ASSERT_EQ(cut.outcome, Outcome::crosses_itself);
    EXPECT_NEAR((cut.place - Vec3(12.5, 10, 0)).norm(), 0.0, 3.0);
}

TEST(Triangulate, RunningTwiceAroundIsRefused) {
    expect_outcome(flat({{0, 0}, {1, 0}, {0, 1}, {0, 0}, {1, 0}, {0, 1}}), Outcome::crosses_itself);
    // A hole that runs in the direction of the outline.
    expect_outcome(flat({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 1}}),
                   Outcome::crosses_itself);
}

TEST(Triangulate, PartsThatMeetInACorner) {
    // Two triangles around (1, 1): in one direction they are two parts, in opposite directions a bow-tie.
    const std::vector<Vec3> parts = flat({{1, 1}, {0, 1}, {0, 0}, {1, 1}, {2, 1}, {2, 2}});
    for (const test::Motion& motion : test::motions()) {
        SCOPED_TRACE(motion.name);
        const std::vector<Vec3> moved = motion(parts);
        const Triangulation cut = triangulate(moved);
        EXPECT_EQ(cut.triangles.size(), 2U);
        expect_cover(moved, cut);
    }
    expect_outcome(flat({{1, 1}, {0, 1}, {0, 0}, {1, 1}, {2, 2}, {2, 1}}), Outcome::crosses_itself);
}

TEST(Triangulate, HoleJoinedByASeam) {
    const std::vector<Vec3> frame =
        flat({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}});
    for (const test::Motion& motion : test::motions()) {
        SCOPED_TRACE(motion.name);
        const std::vector<Vec3> moved = motion(frame);
        const Triangulation cut = triangulate(moved);
        EXPECT_EQ(cut.triangles.size(), 8U); // Euler: 8 corners, one hole
        expect_cover(moved, cut);
        EXPECT_NEAR(vector_area(moved).norm(), 8.0 * motion.scale * motion.scale, area_tolerance(moved));
    }
}

TEST(Triangulate, CornerThatTouchesASide) {
    // A notch whose tip touches the opposite side at a point that rounding moves off it.
    const std::vector<Vec3> notched = flat({{0, 0}, {3, 0.3}, {3, 2}, {2, 2}, {1, 0.1}, {0.5, 2}, {0, 2}});
    for (const test::Motion& motion : test::motions()) {
        SCOPED_TRACE(motion.name);
        const std::vector<Vec3> moved = motion(notched);
        const Triangulation cut = triangulate(moved);
        expect_cover(moved, cut);
        EXPECT_TRUE(cut.concave);
    }
}

TEST(Triangulate, ResultFollowsThePolygonNotItsStartingPoint) {
    // The same region and no ties: the same triangles from every starting corner.
    const std::vector<Vec3> polygon = test::random_star(23, RandomStream(3, "polygon"));
    const auto as_set = [&](std::size_t shift) {
        std::vector<Vec3> turned = polygon;
        std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(shift), turned.end());
        std::set<std::set<std::size_t>> triangles;
        for (const auto& [a, b, c] : triangulate(turned).triangles) {
            triangles.insert({(a + shift) % 23, (b + shift) % 23, (c + shift) % 23});
        }
        return triangles;
    };
    const auto expected = as_set(0);
    EXPECT_EQ(expected.size(), 21U);
    for (std::size_t shift = 1; shift < 23; ++shift) {
        EXPECT_EQ(as_set(shift), expected);
    }
}

} // namespace
} // namespace difusa::triangulate_test
