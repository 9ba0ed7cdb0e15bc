// Closed bodies as blockers of the view between two polygons.
#include <difusa/core/random.h>
#include <difusa/form_factors/blocked.h>
#include <difusa/form_factors/closed_body.h>

#include <meshes.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
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
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const Mesh mesh = test::together(scenes[s], squares);
        const std::vector<Blocker> blockers = blockers_of(mesh, flat_parts(mesh));
        std::vector<Blocker> alone = blockers;
        std::vector<const Blocker*> with_bodies, one_by_one;
        for (std::size_t i = 0; i < blockers.size(); ++i) {
            if (blockers[i].body) {
                alone[i].body = nullptr;
                with_bodies.push_back(&blockers[i]);
                one_by_one.push_back(&alone[i]);
            }
        }
        BlockedView fast, naive;
        fast.set(from, to, with_bodies, 1e-14);
        naive.set(from, to, one_by_one, 1e-14);
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
}

} // namespace
} // namespace difusa::closed_body_test
