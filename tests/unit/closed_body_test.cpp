// Closed bodies as blockers of the view between two polygons.
#include <difusa/core/random.h>
#include <difusa/form_factors/blocked.h>
#include <difusa/form_factors/closed_body.h>
#include <difusa/form_factors/form_factors.h>

#include <meshes.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace difusa::closed_body_test {
namespace {

std::vector<std::shared_ptr<const ClosedBody>> bodies_of(const Mesh& mesh) {
    return closed_bodies(mesh, flat_parts(mesh));
}

/// A ball with a deep dent, star-shaped around the origin.
Mesh dented_ball(int level) {
    Mesh ball = test::icosphere(level);
    for (Vec3& p : ball.points) {
        p *= 1.0 - 0.6 * std::exp(-4.0 * (p - Vec3(0.3, 0.2, 0.9)).squaredNorm());
    }
    ball.derive();
    return ball;
}

/// A unit cube with a pit in its top.
Mesh dented_box() {
    Mesh box = test::box(1.0, 3);
    for (Vec3& p : box.points) {
        if (p[2] == 1.0 && (p - Vec3(0.5, 0.5, 1.0)).norm() < 0.4) {
            p[2] = 0.5;
        }
    }
    box.derive();
    return box;
}

TEST(ClosedBody, IsFoundWhereTheFrontsOfASurfaceEncloseIt) {
    const Mesh scene = test::together(test::moved(test::icosphere(2), 1.0, Vec3(5, 0, 0)),
                                      test::together(dented_ball(2), test::grid(2, 2)));
    const std::vector<std::shared_ptr<const ClosedBody>> body = bodies_of(scene);
    constexpr std::size_t ball = 20 * 16;
    ASSERT_TRUE(body[0] && body[ball]);
    EXPECT_TRUE(body[0]->convex());
    EXPECT_FALSE(body[ball]->convex());
    EXPECT_EQ(body[0], body[ball - 1]);
    EXPECT_NE(body[0], body[ball]);
    EXPECT_FALSE(body[2 * ball]) << "open";
    EXPECT_EQ(body[0]->corners().size(), 2U + 10U * 16U);

    for (const bool inward : {false, true}) {
        EXPECT_EQ(bodies_of(test::box(1.0, 3, inward))[0] != nullptr, !inward);
    }
    // One corner pushed through the opposite sides.
    Mesh through = test::box(1.0);
    *std::find(through.points.begin(), through.points.end(), Vec3(1, 1, 1)) = Vec3(0.4, 0.3, -0.5);
    through.derive();
    EXPECT_FALSE(bodies_of(through)[0]);
}

/// The same triangles, and all of them turned over, as those of double-sided materials are.
Mesh double_sided(const Mesh& mesh) {
    std::vector<std::array<Index, 3>> triangles = mesh.triangles;
    for (const auto& [a, b, c] : mesh.triangles) {
        triangles.push_back({a, c, b});
    }
    return test::make_mesh(mesh.points, triangles);
}

/// An L-shaped plate, 3 by 3 less 2 by 2.
Mesh l_shape() {
    Mesh plate = test::grid(3, 3, 3.0, 3.0);
    std::vector<std::array<Index, 3>> triangles;
    for (Index t = 0; t < plate.triangles.size(); ++t) {
        if (t / 2 % 3 == 0 || t / 6 == 0) {
            triangles.push_back(plate.triangles[t]);
        }
    }
    return test::make_mesh(plate.points, triangles);
}

/// Sheets with two sides enclose nothing, whatever rounding makes of their volume.
TEST(ClosedBody, IsNoSheet) {
    for (int turn = 0; turn < 24; ++turn) {
        Mesh sheet = l_shape();
        const Eigen::AngleAxisd rotation(0.15 * turn, Vec3(1, 0.3, 0.7).normalized());
        for (Vec3& p : sheet.points) {
            p = rotation * p;
        }
        for (const auto& body : bodies_of(double_sided(sheet))) {
            EXPECT_FALSE(body) << turn;
        }
    }
}

/// What counts as convex does not depend on how far from the origin a body is.
TEST(ClosedBody, FarFromTheOriginADentIsADent) {
    for (const double far : {0.0, 1e6, 1e7}) {
        const Mesh ball = test::moved(dented_ball(2), 1.0, Vec3(far, far, 0));
        const std::shared_ptr<const ClosedBody> body = bodies_of(ball)[0];
        EXPECT_TRUE(far > 0.0 || body);
        EXPECT_FALSE(body && body->convex()) << far;
    }
}

/// The walls of a room with two sides are a body to those outside of it, not to each other.
TEST(ClosedBody, DoubleSidedRoomsAreLit) {
    constexpr double tolerance = 1e-4;
    for (int i = 0; i < 27; ++i) {
        Mesh room = test::box(1.0, 1, true);
        const Vec3 bend(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        *std::find(room.points.begin(), room.points.end(), Vec3(1, 1, 1)) += 1e-7 * bend;
        room.derive();
        const Mesh mesh = double_sided(room);
        Surfaces surfaces;
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            surfaces.of.push_back(t);
            surfaces.name.push_back(std::to_string(t));
        }
        const FormFactors F = form_factors(mesh, surfaces, {tolerance}, Execution{1});
        for (std::size_t t = 0; t < room.triangles.size(); ++t) {
            // Each of the factors with the other triangles of the room is within the tolerance.
            EXPECT_NEAR(F.row_sum(t), 1.0, 11.0 * tolerance) << "bend " << i << ", triangle " << t;
        }
    }
}

/// Row sums of a closed room with a ball, a dented one and a crate in it, some of which stand on the floor.
TEST(ClosedBody, RowSumsOfARoomWithBodies) {
    constexpr double tolerance = 1e-3;
    Mesh mesh = test::moved(test::box({6, 5, 4}, 1, true), 1.0, Vec3(-3, -2.5, -1));
    mesh = test::together(mesh, test::moved(test::icosphere(2), 0.8, Vec3(-1.5, 0, 0.5)));
    mesh = test::together(mesh, test::moved(dented_ball(1), 0.7, Vec3(1.2, 0.8, -0.3)));
    mesh = test::together(mesh, test::moved(test::box(1.0, 2), 1.0, Vec3(0.5, -1.5, -1)));
    Surfaces surfaces;
    surfaces.name = {"room", "bodies"};
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        surfaces.of.push_back(t < 12 ? 0 : 1);
    }
    const FormFactors F = form_factors(mesh, surfaces, {tolerance}, Execution{1});
    // The floor under the crate sees nothing: 1 of the area of 148. The crate's base neither: it touches the floor.
    const double bodies = F.area[1];
    EXPECT_NEAR(F.row_sum(0), 147.0 / 148.0, 2.0 * tolerance);
    EXPECT_NEAR(F.row_sum(1), (bodies - 1.0) / bodies, 2.0 * tolerance);
}

TEST(ClosedBody, TheOutlineOfABox) {
    const Mesh mesh = test::box(1.0, 4);
    const std::shared_ptr<const ClosedBody> body = bodies_of(mesh)[0];
    ASSERT_TRUE(body && body->convex());
    ClosedBody::View view;
    // Four edges of each square along a side: 6 sides of a hexagon from before a corner, 4 of a square from before a
    // face.
    EXPECT_TRUE(body->find_outline({3, 3, 3}, 1e-14, view));
    EXPECT_EQ(view.outline.size(), 24U);
    EXPECT_TRUE(body->find_outline({3, 0.5, 0.5}, 1e-14, view));
    EXPECT_EQ(view.outline.size(), 16U);
    for (const Index corner : view.outline) {
        EXPECT_EQ(body->corners()[corner][0], 1.0);
    }
    EXPECT_FALSE(body->find_outline({0.5, 0.5, 0.5}, 1e-14, view)) << "from inside";
    EXPECT_FALSE(body->find_outline({0.5, 0.5, 0.0}, 1e-14, view)) << "from below its base";
}

/// A point of the triangle with these corners.
Vec3 point_in(const std::array<Vec3, 3>& corners, RandomStream& random) {
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    return corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
}

/// What is said of a convex body between two triangles is true of the lines between their points; and it is said where
/// it is so by much.
TEST(ClosedBody, HidesOrIsApartFromTriangles) {
    RandomStream random(4, "triangles");
    const auto somewhere = [&](double half) {
        return Vec3(half * (2.0 * random.uniform() - 1.0), half * (2.0 * random.uniform() - 1.0),
                    half * (2.0 * random.uniform() - 1.0));
    };
    for (const Mesh& mesh : {test::icosphere(2), test::moved(test::box({2, 1, 0.4}, 2), 1.0, Vec3(-1, -0.5, -0.2))}) {
        const std::shared_ptr<const ClosedBody> body = bodies_of(mesh)[0];
        ASSERT_TRUE(body && body->convex());
        const auto thinner = [&](double scale, const Vec3& p, const Vec3& q) { // the body scaled around the origin
            return body->is_crossed(p / scale, q / scale, 0.0);
        };
        std::size_t hidden = 0, apart = 0, some = 0;
        for (int i = 0; i < 3000; ++i) {
            std::array<Vec3, 3> from, to;
            const Vec3 at_from = somewhere(2.5), at_to = somewhere(2.5);
            for (std::size_t k = 0; k < 3; ++k) {
                from[k] = at_from + somewhere(0.3);
                to[k] = at_to + somewhere(0.3);
            }
            bool all = true, none = true, all_of_thinner = true;
            for (int ray = 0; ray < 40; ++ray) {
                const Vec3 p = point_in(from, random), q = point_in(to, random);
                const bool crossed = body->is_crossed(p, q, 0.0);
                all = all && crossed;
                none = none && !crossed;
            }
            for (const Vec3& p : from) {
                for (const Vec3& q : to) {
                    all_of_thinner = all_of_thinner && thinner(0.9, p, q);
                }
            }
            const bool hides = body->hides(from, to, 1e-14), is_apart = body->is_apart(from, to, 1e-14);
            EXPECT_TRUE(!hides || all) << i;
            EXPECT_TRUE(!is_apart || none) << i;
            hidden += hides ? 1 : 0;
            apart += is_apart ? 1 : 0;
            some += !hides && !is_apart ? 1 : 0;
            if (all_of_thinner && body->is_apart(from, {}, -1e-3)) {
                EXPECT_TRUE(hides) << i;
            }
            // Within a ball that stays away from the body.
            const Vec3 middle = 0.5 * (at_from + at_to);
            const double reach = 0.5 * (at_from - at_to).norm() + 0.6;
            if (middle.norm() > reach + 1.2) {
                EXPECT_TRUE(is_apart) << i;
            }
        }
        EXPECT_GT(hidden, 100U);
        EXPECT_GT(apart, 500U);
        EXPECT_GT(some, 100U);
    }
}

/// Lines are cut by a body as by its faces one by one.
TEST(ClosedBody, IsCrossedWhereItsFacesAre) {
    const Mesh mesh = test::icosphere(1);
    const std::shared_ptr<const ClosedBody> body = bodies_of(mesh)[0];
    ASSERT_TRUE(body && body->convex());
    RandomStream random(5, "segments");
    std::size_t crossed = 0;
    for (int i = 0; i < 4000; ++i) {
        const auto somewhere = [&] {
            return Vec3(4.0 * random.uniform() - 2.0, 4.0 * random.uniform() - 2.0, 4.0 * random.uniform() - 2.0);
        };
        const Vec3 p = somewhere(), q = somewhere();
        bool any = false;
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            const auto [a, b, c] = mesh.corners(t);
            const double at_p = mesh.normals[t].dot(p - a), at_q = mesh.normals[t].dot(q - a);
            if (at_p * at_q < 0.0) {
                const Vec3 x = p + at_p / (at_p - at_q) * (q - p);
                const auto left = [&](const Vec3& from, const Vec3& to) {
                    return mesh.normals[t].dot((to - from).cross(x - from)) >= 0.0;
                };
                any = any || (left(a, b) && left(b, c) && left(c, a));
            }
        }
        EXPECT_EQ(body->is_crossed(p, q, 0.0), any) << i;
        crossed += any ? 1 : 0;
    }
    EXPECT_GT(crossed, 500U);
}

/// The view past bodies is that past their triangles one by one.
TEST(BlockedView, ClosedBodiesHideWhatTheirTrianglesHide) {
    const auto square = [](double z, double half, double up) {
        return PolygonEnd(
            FlatPolygon(std::vector<Vec3>{
                {-half, -up * half, z}, {half, -up * half, z}, {half, up * half, z}, {-half, up * half, z}}),
            {0, 0, up});
    };
    const PolygonEnd from = square(-2.0, 1.5, 1.0), to = square(2.5, 2.0, -1.0);
    // Parts of a surface that has everything on one side are left out: the squares have to be a part of it.
    const Mesh squares = test::together(test::moved(test::grid(1, 1, 3.0, 3.0), 1.0, Vec3(-1.5, -1.5, -2.0)),
                                        test::moved(test::grid(1, 1, 4.0, 4.0), 1.0, Vec3(-2.0, -2.0, 2.5)));
    const std::vector<Mesh> scenes{
        test::icosphere(2),
        dented_ball(2),
        test::moved(test::box({1, 2, 0.3}, 3), 1.0, Vec3(-0.3, -0.8, 0.1)),
        test::moved(dented_ball(1), 1.0, Vec3(0, 0, -1.5)), // reaches below the plane of the first square
        test::moved(test::icosphere(2), 1.0, Vec3(0.2, 0.1, 2.0)),
        // These stand on the first square: what is below them sees nothing.
        test::moved(test::box(1.0, 3), 1.0, Vec3(-0.5, -0.5, -2.0)),
        test::moved(dented_box(), 1.0, Vec3(-0.5, -0.5, -2.0)),
        test::together(test::moved(test::icosphere(1), 0.5, Vec3(0.6, 0, 0)),
                       test::moved(dented_ball(1), 0.7, Vec3(-0.5, 0.2, 0.4))),
    };
    std::size_t whole = 0; // faces of bodies that are looked at as one
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const Mesh mesh = test::together(scenes[s], squares);
        std::vector<Blocker> blockers = blockers_of(mesh, flat_parts(mesh));
        std::erase_if(blockers, [](const Blocker& blocker) { return !blocker.body; });
        const ObstacleSet with_bodies(blockers);
        for (Blocker& blocker : blockers) {
            blocker.body = nullptr;
        }
        const ObstacleSet one_by_one(blockers);
        whole += one_by_one.all().size() - with_bodies.all().size();
        const auto listed = [](const ObstacleSet& set) {
            std::vector<const Obstacle*> all;
            for (const Obstacle& obstacle : set.all()) {
                all.push_back(&obstacle);
            }
            return all;
        };
        BlockedView fast, naive;
        fast.set(from, to, listed(with_bodies), 1e-14);
        naive.set(from, to, listed(one_by_one), 1e-14);
        RandomStream random(9, "points");
        std::size_t partly = 0;
        for (int i = 0; i < 200; ++i) {
            const Vec3 x(3.0 * random.uniform() - 1.5, 3.0 * random.uniform() - 1.5, -2.0);
            // Rounding of hundreds of pieces, and of the slivers between neighbours.
            const double expected = naive.form_factor(x);
            EXPECT_NEAR(fast.form_factor(x), expected, 1e-12) << "scene " << s;
            if (expected > 1e-12) { // else slivers may be left
                EXPECT_EQ(fast.seen(), naive.seen()) << "scene " << s;
            }
            partly += naive.seen() != Seen::everything ? 1 : 0;
        }
        EXPECT_GT(partly, 20U) << "scene " << s;
    }
    EXPECT_GT(whole, 600U);
}

} // namespace
} // namespace difusa::closed_body_test
