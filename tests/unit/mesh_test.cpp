#include <difusa/core/error.h>
#include <difusa/mesh/mesh.h>

#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace difusa::mesh_test {
namespace {

using test::book;
using test::box;
using test::flip;
using test::grid;
using test::icosphere;
using test::l_room;
using test::make_mesh;
using test::mobius;
using test::moved;
using test::together;

constexpr double eps = std::numeric_limits<double>::epsilon();

TEST(Mesh, ABoxIsSixRegions) {
    const Mesh mesh = box(Vec3(1, 2, 3), 4);
    EXPECT_EQ(mesh.region_count, 6U);
    EXPECT_NEAR(mesh.area, 2.0 * (2 + 3 + 6), 1e-13);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        EXPECT_EQ(mesh.region[t], t / 32); // 2 · 4² triangles a side, in order
        EXPECT_EQ(mesh.normals[t].cwiseAbs().maxCoeff(), 1.0);
        const Vec3 outward = mesh.at(static_cast<Index>(t), 1.0 / 3, 1.0 / 3).position - Vec3(0.5, 1, 1.5);
        EXPECT_GT(mesh.normals[t].dot(outward), 0.0);
    }
    EXPECT_EQ(mesh.low, Vec3::Zero());
    EXPECT_EQ(mesh.high, Vec3(1, 2, 3));
    EXPECT_DOUBLE_EQ(mesh.diameter(), std::sqrt(14.0));
    EXPECT_EQ(mesh.magnitude(), 3.0);
}

TEST(Mesh, RegionsGoRoundBluntEdgesOnly) {
    EXPECT_EQ(icosphere(0).region_count, 1U);
    EXPECT_EQ(icosphere(2, 1.0, true).region_count, 1U);
    EXPECT_EQ(l_room().region_count, 8U) << "two floors, six walls";
    EXPECT_EQ(book(2).region_count, 2U) << "pages that run through the spine in one direction";
    EXPECT_EQ(book(5).region_count, 5U);
    EXPECT_EQ(mobius(40).region_count, 1U) << "one walks around the strip without the edge where it turns over";
    EXPECT_EQ(together(grid(2, 2), moved(grid(2, 2), 1.0, Vec3(1, 0, 0))).region_count, 2U) << "not welded";
    // A fold: two squares on the x axis, the second turned by `angle` out of the plane of the first.
    for (const double degrees : {10.0, 89.0, 91.0, 170.0}) {
        const double angle = degrees * std::numbers::pi / 180.0;
        const Mesh fold = make_mesh({{0, 0, 0}, {1, 0, 0}, {0.5, -1, 0}, {0.5, std::cos(angle), std::sin(angle)}},
                                    {{1, 0, 2}, {0, 1, 3}});
        EXPECT_EQ(fold.region_count, degrees < 90.0 ? 1U : 2U) << degrees;
    }
}

TEST(Mesh, AreasAndNormalsOfNeedlesAreAccurate) {
    // Two edges of nearly equal length and a short one; the height is found from the coordinates' differences.
    for (const double height : {1e-3, 1e-8, 1e-13}) {
        for (int turn = 0; turn < 3; ++turn) {
            std::array<Index, 3> corners{0, 1, 2};
            std::rotate(corners.begin(), corners.begin() + turn, corners.end());
            const Mesh needle = make_mesh({{0, 0, 0}, {1, 0, 0}, {1, height, 0}}, {corners});
            EXPECT_NEAR(needle.area, 0.5 * height, 4 * eps * height);
            EXPECT_EQ(needle.normals[0], Vec3::UnitZ());
        }
    }
}

TEST(Mesh, APointIsWhereItsBarycentricsSay) {
    const Mesh mesh = icosphere(1);
    for (const SurfacePoint& x : test::random_points(mesh, 200, RandomStream(1, "test"))) {
        EXPECT_NEAR(x.normal.norm(), 1.0, 2 * eps);
        EXPECT_NEAR(x.normal.dot(x.position - mesh.corner(x.face, 0)), 0.0, 8 * eps);
        EXPECT_LE(x.position.norm(), 1.0 + 4 * eps) << "inside the sphere through the corners";
    }
    EXPECT_EQ(mesh.at(3, 0, 0).position, mesh.corner(3, 0));
    EXPECT_EQ(mesh.at(3, 1, 0).position, mesh.corner(3, 1));
    EXPECT_EQ(mesh.at(3, 0, 1).position, mesh.corner(3, 2));
}

TEST(Mesh, ScalingByAPowerOfTwoScalesEveryBit) {
    const Mesh one = icosphere(2);
    for (const double scale : {0x1p-20, 0x1p20}) {
        const Mesh other = moved(one, scale, Vec3::Zero());
        EXPECT_EQ(other.normals, one.normals);
        EXPECT_EQ(other.region, one.region);
        EXPECT_EQ(other.area, scale * scale * one.area);
    }
}

TEST(Mesh, FlippingTurnsNormalsOverAndKeepsRegions) {
    Mesh mesh = icosphere(1);
    const Mesh before = mesh;
    flip(mesh);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        EXPECT_NEAR((mesh.normals[t] + before.normals[t]).norm(), 0.0, 4 * eps);
    }
    EXPECT_EQ(mesh.region, before.region);
}

TEST(Mesh, RefusesWhatTheDiagnosisWouldNotPass) {
    EXPECT_THROW(make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}), InputError);
    EXPECT_THROW(make_mesh({}, {}), InputError);
    EXPECT_THROW(make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}), InputError);
    EXPECT_THROW(make_mesh({{0, 0, 0}, {1, 0, 0}, {0, std::nan(""), 0}}, {{0, 1, 2}}), InputError);
}

TEST(Mesh, NoticesChangesAfterItWasDerived) {
    const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    EXPECT_TRUE(mesh.is_derived());
    Mesh moved = mesh, turned = mesh, out_of_range = mesh, broken = mesh, longer = mesh;
    moved.points[2] = Vec3(0, 1, 0.1);
    turned.turn_over(0);
    out_of_range.triangles[0][0] = 3;
    broken.points[0][0] = std::nan("");
    longer.triangles.push_back({0, 1, 2});
    for (const Mesh& changed : {moved, turned, out_of_range, broken, longer}) {
        EXPECT_FALSE(changed.is_derived());
    }
}

} // namespace
} // namespace difusa::mesh_test
