#include <difusa/core/random.h>
#include <difusa/rays/lambert.h>

#include <gtest/gtest.h>

#include <meshes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa::lambert_test {
namespace {

constexpr double pi = std::numbers::pi;

/// Of the quadrangle abcd, which must be flat and convex.
double quadrangle(const Vec3& x, const Vec3& n, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return lambert_form_factor(x, n, a, b, c) + lambert_form_factor(x, n, a, c, d);
}

Vec3 random_point(RandomStream& stream) {
    const double x = stream.uniform(), y = stream.uniform(), z = stream.uniform();
    return 2.0 * Vec3(x, y, z) - Vec3::Ones();
}

Vec3 random_direction(RandomStream& stream) {
    for (;;) {
        const Vec3 p = random_point(stream);
        if (p.norm() <= 1.0 && p.norm() > 0.1) {
            return p.normalized();
        }
    }
}

/// Element to a parallel rectangle a by b at the distance h, one corner straight above the element.
double parallel_corner(double a, double b, double h) {
    const double X = a / h, Y = b / h, RX = std::sqrt(1.0 + X * X), RY = std::sqrt(1.0 + Y * Y);
    return (X / RX * std::atan(Y / RX) + Y / RY * std::atan(X / RY)) / (2.0 * pi);
}

/// Element to a rectangle that stands perpendicular on the element's plane at the distance c, `width` to one side of
/// the foot of the distance, `height` upwards.
double perpendicular_corner(double width, double height, double c) {
    const double X = height / width, Y = c / width, R = std::sqrt(X * X + Y * Y);
    return (std::atan(1.0 / Y) - Y / R * std::atan(1.0 / R)) / (2.0 * pi);
}

TEST(Lambert, ParallelRectangle) {
    for (const double a : {0.01, 0.5, 1.0, 30.0}) {
        for (const double b : {0.02, 1.0, 7.0}) {
            for (const double h : {0.05, 1.0, 12.0}) {
                const double F =
                    quadrangle(Vec3::Zero(), Vec3::UnitZ(), Vec3(0, 0, h), Vec3(0, b, h), Vec3(a, b, h), Vec3(a, 0, h));
                EXPECT_NEAR(F, parallel_corner(a, b, h), 1e-14) << a << " " << b << " " << h;
            }
        }
    }
}

TEST(Lambert, ParallelSquareStraightAbove) {
    // Four corners' worth: 4 · 2 · (1/√2) · atan(1/√2) / 2π for a square of side 2 at distance 1.
    const double F =
        quadrangle(Vec3(3, 4, 5), Vec3::UnitZ(), Vec3(2, 3, 6), Vec3(2, 5, 6), Vec3(4, 5, 6), Vec3(4, 3, 6));
    EXPECT_NEAR(F, 4.0 / (pi * std::sqrt(2.0)) * std::atan(1.0 / std::sqrt(2.0)), 1e-14);
}

TEST(Lambert, PerpendicularRectangle) {
    for (const double width : {0.01, 1.0, 20.0}) {
        for (const double height : {0.03, 1.0, 9.0}) {
            for (const double c : {0.01, 1.0, 5.0}) {
                const double F = quadrangle(Vec3::Zero(), Vec3::UnitZ(), Vec3(0, c, 0), Vec3(width, c, 0),
                                            Vec3(width, c, height), Vec3(0, c, height));
                EXPECT_NEAR(F, perpendicular_corner(width, height, c), 1e-14) << width << " " << height << " " << c;
            }
        }
    }
}

TEST(Lambert, WhatIsBelowTheHorizonDoesNotCount) {
    const double F =
        quadrangle(Vec3::Zero(), Vec3::UnitZ(), Vec3(0, 1, -3), Vec3(1, 1, -3), Vec3(1, 1, 2), Vec3(0, 1, 2));
    EXPECT_NEAR(F, perpendicular_corner(1, 2, 1), 1e-14);
    EXPECT_EQ(lambert_form_factor(Vec3::Zero(), Vec3::UnitZ(), Vec3(0, 1, -3), Vec3(1, 1, -3), Vec3(1, 1, -1)), 0.0);
    // A corner or an edge on the horizon.
    EXPECT_EQ(lambert_form_factor(Vec3::Zero(), Vec3::UnitZ(), Vec3(0, 1, -3), Vec3(1, 1, -3), Vec3(1, 1, 0)), 0.0);
    EXPECT_EQ(lambert_form_factor(Vec3::Zero(), Vec3::UnitZ(), Vec3(0, 1, -3), Vec3(1, 1, 0), Vec3(0, 1, 0)), 0.0);
}

/// One corner, or two, below the horizon: the clipped polygon cut by hand.
TEST(Lambert, ClippingLeavesTheVisiblePart) {
    RandomStream stream(1, "clipping");
    int with_one_below = 0, with_two_below = 0;
    while (with_one_below < 200 || with_two_below < 200) {
        const Vec3 x = random_point(stream), n = random_direction(stream);
        std::array<Vec3, 3> p{random_point(stream), random_point(stream), random_point(stream)};
        const auto height = [&](const Vec3& q) { return n.dot(q - x); };
        // Turned until the odd corner is the first.
        for (int turn = 0; turn < 3; ++turn) {
            if ((height(p[0]) > 0.0) != (height(p[1]) > 0.0) && (height(p[0]) > 0.0) != (height(p[2]) > 0.0)) {
                break;
            }
            std::rotate(p.begin(), p.begin() + 1, p.end());
        }
        if ((height(p[0]) > 0.0) == (height(p[1]) > 0.0) || (height(p[0]) > 0.0) == (height(p[2]) > 0.0)) {
            continue; // all on one side
        }
        const auto cut = [&](const Vec3& q) -> Vec3 {
            return (height(p[0]) * q - height(q) * p[0]) / (height(p[0]) - height(q));
        };
        const Vec3 q1 = cut(p[1]), q2 = cut(p[2]);
        const double F = lambert_form_factor(x, n, p[0], p[1], p[2]);
        if (height(p[0]) > 0.0) {
            ++with_two_below;
            EXPECT_NEAR(F, lambert_form_factor(x, n, p[0], q1, q2), 1e-12);
        } else {
            ++with_one_below;
            EXPECT_NEAR(F, quadrangle(x, n, q1, p[1], p[2], q2), 1e-12);
        }
    }
}

/// F(n) - F(-n) is the component along n of one vector (the vector irradiance), whatever the horizon cuts off.
TEST(Lambert, OppositeElementsDifferByTheVectorIrradiance) {
    RandomStream stream(2, "vector");
    for (int i = 0; i < 500; ++i) {
        const Vec3 x = random_point(stream), a = random_point(stream), b = random_point(stream),
                   c = random_point(stream), n = random_direction(stream);
        const auto net = [&](const Vec3& normal) {
            return lambert_form_factor(x, normal, a, b, c) - lambert_form_factor(x, -normal, a, b, c);
        };
        const Vec3 vector(net(Vec3::UnitX()), net(Vec3::UnitY()), net(Vec3::UnitZ()));
        EXPECT_NEAR(net(n), n.dot(vector), 1e-12);
    }
}

TEST(Lambert, PartsOfATriangleAddUp) {
    RandomStream stream(3, "parts");
    int seen = 0;
    for (int i = 0; i < 500; ++i) {
        const Vec3 x = random_point(stream), n = random_direction(stream), a = random_point(stream),
                   b = random_point(stream), c = random_point(stream);
        double u = stream.uniform(), v = stream.uniform();
        if (u + v > 1.0) {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        const Vec3 inside = a + u * (b - a) + v * (c - a);
        const double F = lambert_form_factor(x, n, a, b, c);
        const double parts = lambert_form_factor(x, n, a, b, inside) + lambert_form_factor(x, n, b, c, inside) +
                             lambert_form_factor(x, n, c, a, inside);
        // The place of `inside` is rounded, which tells where the triangle is seen at a slant of 1e-4 or less.
        EXPECT_NEAR(parts, F, 1e-12);
        seen += F > 0.0 ? 1 : 0;
    }
    EXPECT_GT(seen, 100); // about a quarter is expected: seen from the front, and not below the horizon
}

/// Around any element inside of a closed surface the form factors add up to 1, also for an element on the surface.
TEST(Lambert, AClosedSurfaceFillsTheHemisphere) {
    RandomStream stream(4, "closed");
    const Mesh room = test::box(Vec3(1, 2, 3), 3, true), ball = test::icosphere(2, 1.0, true);
    const auto sum = [](const Mesh& mesh, const SurfacePoint& x) {
        double F = 0.0;
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            F += lambert_form_factor(x.position, x.normal, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
        }
        return F;
    };
    for (int i = 0; i < 100; ++i) {
        SurfacePoint x;
        x.normal = random_direction(stream);
        x.position = 0.5 * (random_point(stream) + Vec3::Ones()).cwiseProduct(Vec3(1, 2, 3));
        EXPECT_NEAR(sum(room, x), 1.0, 1e-12);
        x.position = 0.4 * random_point(stream);
        EXPECT_NEAR(sum(ball, x), 1.0, 1e-12);
        // On the surface, where rounding may put the place a little behind neighbouring triangles.
        EXPECT_NEAR(sum(room, room.at(static_cast<Index>(stream.below(room.triangles.size())), 0.3, 0.4)), 1.0, 1e-12);
        EXPECT_NEAR(sum(ball, ball.at(static_cast<Index>(stream.below(ball.triangles.size())), 0.3, 0.4)), 1.0, 1e-12);
    }
}

TEST(Lambert, NeitherScaleNorPlaceMatters) {
    RandomStream stream(5, "scale");
    for (int i = 0; i < 100; ++i) {
        const Vec3 x = random_point(stream), n = random_direction(stream), a = random_point(stream),
                   b = random_point(stream), c = random_point(stream);
        const double F = lambert_form_factor(x, n, a, b, c);
        for (const double s : {1e-6, 1e-3, 1e3, 1e6}) {
            EXPECT_NEAR(lambert_form_factor(s * x, n, s * a, s * b, s * c), F, 1e-12) << s;
        }
        for (const double s : {0x1p-20, 0x1p20}) {
            EXPECT_EQ(lambert_form_factor(s * x, n, s * a, s * b, s * c), F) << s;
        }
    }
}

/// The smaller the lamp, the closer its form factor is to cos cos A / (pi r²); the differences of its corners must not
/// drown in their distance.
TEST(Lambert, SmallAndFar) {
    const Vec3 n = Vec3(1, 2, 5).normalized(), at(3, -4, 10), normal = Vec3(1, 1, -4).normalized();
    const Vec3 along = normal.unitOrthogonal(), across = normal.cross(along);
    for (const double size : {1e-3, 1e-4, 1e-5, 1e-6}) {
        const Vec3 a = at - size * along, b = at + size * along - size * across, c = at + size * along + size * across;
        const double F = lambert_form_factor(Vec3::Zero(), n, a, b, c);
        const Vec3 middle = (a + b + c) / 3.0;
        const double rm = middle.norm(),
                     point = n.dot(middle) / rm * -normal.dot(middle) / rm * 2.0 * size * size / (pi * rm * rm);
        // Next order of the size over the distance; corners rounded at 2^-52 · 10 of a size of 1e-6: 2e-9.
        EXPECT_NEAR(F / point, 1.0, 10.0 * size * size / (rm * rm) + 1e-14 / size) << size;
    }
}

TEST(Lambert, BacksAndEdgesSendNothing) {
    const Vec3 a(0, 0, 1), b(0, 1, 1), c(1, 1, 1);
    EXPECT_GT(lambert_form_factor(Vec3::Zero(), Vec3::UnitZ(), a, b, c), 0.0);
    EXPECT_EQ(lambert_form_factor(Vec3::Zero(), Vec3::UnitZ(), a, c, b), 0.0);
    EXPECT_EQ(lambert_form_factor(Vec3::Zero(), -Vec3::UnitZ(), a, b, c), 0.0);
    EXPECT_EQ(lambert_form_factor(Vec3(5, 7, 1), Vec3::UnitX(), a, b, c), 0.0); // in its plane
}

/// An element on the border of the triangle: edges through it have no angle and no direction.
TEST(Lambert, AnElementOnTheBorder) {
    const Vec3 a(0, 0, 0), b(0, 2, 0), c(0, 1, 2), n = Vec3::UnitX(); // in the plane x = 0, seen from x > 0
    for (const Vec3& x : {a, b, Vec3(0, 1, 0)}) {
        EXPECT_EQ(lambert_form_factor(x, n, a, b, c), 0.0);
        // From just in front, with a normal that leans along the triangle: finite and a share of 1.
        for (const double height : {1e-300, 1e-16, 1e-9}) {
            const double F = lambert_form_factor(x + height * n, Vec3::UnitZ(), a, b, c);
            EXPECT_GE(F, 0.0) << height;
            EXPECT_LE(F, 0.5 + 1e-12) << height;
        }
    }
    // Half of the hemisphere, from right in front of the middle of a perpendicular triangle.
    EXPECT_NEAR(lambert_form_factor(Vec3(1e-9, 1, 1), Vec3::UnitZ(), a, b, c), 0.5, 1e-8);
}

} // namespace
} // namespace difusa::lambert_test
