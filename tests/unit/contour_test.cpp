#include <difusa/core/random.h>
#include <difusa/form_factors/blocked.h>
#include <difusa/form_factors/contour.h>
#include <difusa/form_factors/shadow_region.h>
#include <difusa/form_factors/unblocked.h>
#include <difusa/study/references/form_factors.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <utility>
#include <vector>

namespace difusa::contour_test {
namespace {

FlatPolygon polygon(std::initializer_list<Vec3> corners) {
    return FlatPolygon(std::vector<Vec3>(corners));
}

/// In the plane z = height, facing up or down.
FlatPolygon level(const Rectangle& r, double height, bool up) {
    const Vec3 a(r.x0, r.y0, height), b(r.x1, r.y0, height), c(r.x1, r.y1, height), d(r.x0, r.y1, height);
    return up ? polygon({a, b, c, d}) : polygon({a, d, c, b});
}

/// In the plane x = 0 facing +x, with z instead of x.
FlatPolygon upright(const Rectangle& r) {
    return polygon({Vec3(0, r.y0, r.x0), Vec3(0, r.y1, r.x0), Vec3(0, r.y1, r.x1), Vec3(0, r.y0, r.x1)});
}

Rectangle random_rectangle(RandomStream& stream, double least_x) {
    const double x = least_x + 2.0 * stream.uniform(), y = 2.0 * stream.uniform() - 1.0;
    const double width = 0.05 + stream.uniform(), depth = 0.05 + stream.uniform();
    return {x, x + width, y, y + depth};
}

TEST(Contour, UnitSquares) {
    const FlatPolygon floor = level({0, 1, 0, 1}, 0.0, true);
    EXPECT_NEAR(contour_exchange(floor, level({0, 1, 0, 1}, 1.0, false)).value, 0.199824895698387, 1e-14);
    EXPECT_NEAR(contour_exchange(floor, upright({0, 1, 0, 1})).value, 0.200043776075403, 1e-14);
}

TEST(Contour, ParallelRectangles) {
    RandomStream stream(1, "contour");
    for (int k = 0; k < 200; ++k) {
        const Rectangle a = random_rectangle(stream, -1.0), b = random_rectangle(stream, -1.0);
        const double h = 0.02 + 2.0 * stream.uniform();
        const Estimate AF = contour_exchange(level(a, 0.0, true), level(b, h, false));
        EXPECT_NEAR(AF.value / a.area(), parallel_rectangles(a, b, h), 1e-10) << k;
        EXPECT_LE(AF.error, 1e-11);
    }
}

TEST(Contour, PerpendicularRectanglesApartAndTouching) {
    RandomStream stream(2, "contour");
    for (int k = 0; k < 200; ++k) {
        Rectangle a = random_rectangle(stream, 0.01), b = random_rectangle(stream, 0.01);
        if (k % 2 == 1) { // both on the common line, with edges that overlap in part
            a.x0 = b.x0 = 0.0;
        }
        const double AF = contour_exchange(level(a, 0.0, true), upright(b)).value;
        EXPECT_NEAR(AF / a.area(), perpendicular_rectangles(a, b), 1e-10) << k;
    }
}

/// A closed tetrahedron's form factors sum to 1: each pair of its faces shares an edge. The lower its top, the more
/// nearly coplanar are three of them.
TEST(Contour, TetrahedraCloseHoweverFlat) {
    for (const double height : {1.0, 0.1, 1e-3, 1e-6}) {
        const Vec3 a(0, 0, 0), b(1, 0.1, 0), c(0.3, 0.9, 0), d(0.4, 0.3, height);
        const std::vector<FlatPolygon> faces{polygon({a, b, c}), polygon({a, d, b}), polygon({b, d, c}),
                                             polygon({c, d, a})};
        for (std::size_t i = 0; i < 4; ++i) {
            double sum = 0.0;
            for (std::size_t j = 0; j < 4; ++j) {
                sum += i == j ? 0.0 : contour_exchange(faces[i], faces[j]).value;
            }
            EXPECT_NEAR(sum / faces[i].area_vector().norm(), 1.0, 1e-8) << height << " face " << i;
        }
    }
}

/// Six triangles around a long thin wedge, of which two touch in one vertex only.
TEST(Contour, CommonVertex) {
    const Vec3 o(0, 0, 0);
    const FlatPolygon whole = polygon({o, Vec3(1, 0, 0), Vec3(0.5, 1, 0)});
    // A fan of triangles over one angle: additivity (L 26).
    const Vec3 p(-0.2, 0.1, 1.0), q(0.1, 1.2, 0.4), middle = 0.3 * p + 0.7 * q;
    const double both = contour_exchange(whole, polygon({o, q, p})).value;
    const double parts =
        contour_exchange(whole, polygon({o, q, middle})).value + contour_exchange(whole, polygon({o, middle, p})).value;
    EXPECT_GT(both, 0.01);
    EXPECT_NEAR(both, parts, 1e-13);
}

/// Perpendicular rectangles of which one edge each lies on a common line, apart along it: the exchange is that of
/// larger ones with common edges, added and subtracted. Turned, the edges are on one line but for rounding, and the
/// distance between points of one and the line of the other is rounding everywhere.
TEST(Contour, EdgesOnACommonLineApart) {
    RandomStream stream(5, "contour");
    const auto joined = [](double length) {
        return contour_exchange(level({0, 1, 0, length}, 0.0, true), upright({0, 1, 0, length})).value;
    };
    const double exact = 0.5 * (joined(3.0) - 2.0 * joined(2.0) + joined(1.0));
    for (int k = 0; k < 50; ++k) {
        const Eigen::Matrix3d turn = Eigen::Quaterniond(stream.uniform() - 0.5, stream.uniform() - 0.5,
                                                        stream.uniform() - 0.5, stream.uniform() - 0.5)
                                         .normalized()
                                         .toRotationMatrix();
        const auto turned = [&](const FlatPolygon& of) {
            std::vector<Vec3> corners;
            for (std::size_t i = 0; i < of.size(); ++i) {
                corners.push_back(turn * of[i]);
            }
            return FlatPolygon(corners);
        };
        const Estimate apart = contour_exchange(turned(level({0, 1, 0, 1}, 0.0, true)), turned(upright({0, 1, 2, 3})));
        EXPECT_NEAR(apart.value, exact, 1e-10) << k;
    }
    // Cut from larger ones, along the line that both planes have in common.
    const FlatPolygon triangle = polygon({Vec3(69.71722898832445, 44, 28.633786068486387),
                                          Vec3(70.807141900000005, 44.541786600000002, 29.724160999999999),
                                          Vec3(69.192858099999995, 44.541786600000002, 29.724160999999999),
                                          Vec3(69.167809751210058, 44, 28.633786068486387)});
    const FlatPolygon wall = polygon({Vec3(-0.10007148449785014, 44, 28.633786068486383), Vec3(-6, 44, 66),
                                      Vec3(0, 44, 66), Vec3(0, 44, 28.633786068486387)});
    const Estimate cut = contour_exchange(triangle, wall, 4e-12), swapped = contour_exchange(wall, triangle, 4e-12);
    EXPECT_NEAR(cut.value, swapped.value, cut.error + swapped.error);
    EXPECT_GT(cut.value, 1e3 * cut.error);
}

TEST(Contour, DoesNotDependOnPlaceAndScale) {
    const FlatPolygon P = level({0, 1, 0, 2}, 0.0, true), Q = upright({0, 1, 0.5, 3});
    const double AF = contour_exchange(P, Q).value;
    for (const double scale : {1e-8, 1e8}) {
        const auto moved = [&](const FlatPolygon& polygon) {
            FlatPolygon result;
            for (const Vec3& p : polygon.corners()) {
                result.add(scale * (p + Vec3(3, -2, 1)));
            }
            return result;
        };
        EXPECT_NEAR(contour_exchange(moved(P), moved(Q)).value / (scale * scale), AF, 1e-12);
    }
}

/// Rules on points against the contour, which does not share a formula with them.
TEST(Unblocked, KeepsItsTolerance) {
    RandomStream stream(3, "unblocked");
    const auto random = [&] {
        const double x = stream.uniform(), y = stream.uniform(), z = stream.uniform();
        return Vec3(2.0 * x - 1.0, 2.0 * y - 1.0, 2.0 * z - 1.0);
    };
    int compared = 0;
    for (int k = 0; k < 2000; ++k) {
        const Vec3 away = (2.0 + 30.0 * stream.uniform() * stream.uniform()) * random();
        const FlatPolygon p = polygon({random(), random(), random()});
        const FlatPolygon q = polygon({random() + away, random() + away, random() + away});
        const PolygonEnd P(p, p.area_vector().normalized()), Q(q, q.area_vector().normalized());
        const auto in_front = [](const FlatPolygon& polygon, const Plane& plane) {
            return !polygon.empty() && plane.height(polygon[0]) > 0.0 && plane.height(polygon[1]) > 0.0 &&
                   plane.height(polygon[2]) > 0.0;
        };
        if (!in_front(p, Q.plane) || !in_front(q, P.plane)) {
            continue;
        }
        const double exact = contour_exchange(p, q).value;
        for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
            const Estimate fast = unblocked_exchange(P, Q, tolerance);
            EXPECT_NEAR(fast.value, exact, tolerance + 1e-13) << k;
            EXPECT_LE(std::abs(fast.value - exact), fast.error + 1e-13) << k;
        }
        ++compared;
    }
    EXPECT_GT(compared, 200);
}

/// A naive twin: points that look at random points of a polygon, some of them through a triangle. Polygons that meet
/// the plane, and obstacles that are higher than some of their corners, or reach below the plane, have regions without
/// end.
TEST(ShadowRegion, HoldsThePointsThatAreInTheShadow) {
    RandomStream stream(1, "shadow");
    const auto random = [&](double low, double high) { return low + (high - low) * stream.uniform(); };
    const auto floor_at = [](const Vec3& x, double size) {
        return PolygonEnd(
            polygon({x - Vec3(size, size, 0), x + Vec3(2 * size, -size, 0), x + Vec3(-size, 2 * size, 0)}),
            Vec3::UnitZ());
    };
    int in_shadow = 0;
    for (int k = 0; k < 400; ++k) {
        const double foot = k % 2 == 0 ? 0.0 : random(0.0, 0.5), top = foot + random(0.2, 1.0);
        const std::vector<Vec3> wall{Vec3(0, 0, foot), Vec3(random(0.5, 2.0), 0, foot), Vec3(1, 0, top),
                                     Vec3(0, 0, top)};
        std::vector<Vec3> obstacle;
        for (int corner = 0; corner < 3; ++corner) {
            obstacle.emplace_back(random(0.2, 1.5), random(0.2, 1.5), random(-0.2, 1.5));
        }
        const Vec3 normal = (obstacle[1] - obstacle[0]).cross(obstacle[2] - obstacle[0]);
        for (int trial = 0; trial < 40; ++trial) {
            const double u = stream.uniform(), v = stream.uniform() * (1.0 - u);
            const Vec3 seen = wall[0] + u * (wall[1] - wall[0]) + v * (wall[2] - wall[0]);
            const double s = stream.uniform(), t = stream.uniform() * (1.0 - s);
            const Vec3 met = obstacle[0] + s * (obstacle[1] - obstacle[0]) + t * (obstacle[2] - obstacle[0]);
            const double above = seen.z() - met.z();
            if (!(met.z() > 0.0) || !(above > 1e-3) || !(std::abs(normal.dot(seen - met)) > 0.0)) {
                continue; // the segment does not come from the floor
            }
            const Vec3 x = seen + seen.z() / above * (met - seen);
            const PolygonEnd floor = trial % 2 == 0 ? floor_at(x, 1e-3) : floor_at(Vec3(1, 1, 0), 3.0);
            if (x.head<2>().norm() > (trial % 2 == 0 ? 1e3 : 20.0)) {
                continue; // the region is cut off, or rounding decides
            }
            const PlaneFrame frame(floor);
            const ShadowRegion region(frame, floor, wall, obstacle);
            constexpr double half = 1e-6;
            const std::array<PlaneFrame::Point, 3> around{frame.flat(x + Vec3(-half, -half, 0)),
                                                          frame.flat(x + Vec3(half, -half, 0)),
                                                          frame.flat(x + Vec3(0, half, 0))};
            EXPECT_GT(region.within(around).area, 0.0) << k;
            ++in_shadow;
        }
    }
    EXPECT_GT(in_shadow, 1000);
}

/// A square parallel to both triangles, so near to the lower one that all it hides from the upper one is hidden from
/// within the lower one: the exchange lacks that of the square with the upper one. No point of the rules need be in its
/// shadow.
TEST(BlockedExchange, SmallShadowsBetweenThePointsAreFound) {
    const PolygonEnd floor(polygon({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}), Vec3::UnitZ()),
        ceiling(polygon({Vec3(0, 0, 1), Vec3(0, 1, 1), Vec3(1, 0, 1)}), -Vec3::UnitZ());
    for (const Vec3& centre : {Vec3(0.25, 0.25, 0), Vec3(0.3, 0.15, 0), Vec3(0.45, 0.1, 0), Vec3(0.2, 0.5, 0)}) {
        for (const double half : {0.04, 0.02, 0.01}) {
            for (const double height : {0.01, 0.003}) {
                FlatPolygon square;
                for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
                    square.add(centre + Vec3(half * x, half * y, height));
                }
                FlatPolygon other_side;
                for (const std::size_t k : {3U, 2U, 1U, 0U}) {
                    other_side.add(square[k]);
                }
                const std::array<Blocker, 2> sides{Blocker(square), Blocker(other_side)};
                const std::array<Obstacle, 2> obstacles{Obstacle(std::span(sides).first(1)),
                                                        Obstacle(std::span(sides).last(1))};
                const std::array<const Obstacle*, 2> both{&obstacles[0], &obstacles[1]};
                const double exact = unblocked_exchange(floor, ceiling, 1e-12).value -
                                     unblocked_exchange(PolygonEnd(square, Vec3::UnitZ()), ceiling, 1e-12).value;
                for (const double tolerance : {1e-4, 1e-5, 1e-6}) {
                    for (const std::size_t count : {1U, 2U}) { // one side of the sheet, or both
                        BlockedView view;
                        const Estimate found = blocked_exchange(floor, ceiling, std::span(both).first(count), 1e-12,
                                                                tolerance, view, Execution{});
                        EXPECT_LE(found.error, tolerance);
                        EXPECT_NEAR(found.value, exact, tolerance)
                            << centre.transpose() << " " << half << " " << height;
                    }
                }
            }
        }
    }
}

} // namespace
} // namespace difusa::contour_test
