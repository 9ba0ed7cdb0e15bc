#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_finder.h>

#include <gtest/gtest.h>

namespace difusa::surface_finder_test {

TEST(SurfaceFinder, FindsTheNearestPointThatFacesTheRightWay) {
    const Mesh room = box({0, 0, 0}, {4, 3, 2.5}, 3, Front::inside);
    const SurfaceFinder finder(room);
    const auto floor = finder.nearest({1, 2, 0.25});
    ASSERT_TRUE(floor);
    const double rounding = 1e-15 * room.diameter(); // of barycentric coordinates and the point that they give
    EXPECT_LE((floor->point.position - Vec3(1, 2, 0)).norm(), rounding);
    EXPECT_EQ(floor->point.normal, Vec3(0, 0, 1));
    EXPECT_EQ(floor->distance, 0.25);
    const SurfacePoint again = room.at(floor->point.face, floor->point.u, floor->point.v);
    EXPECT_EQ(again.position, floor->point.position);

    const auto ceiling = finder.nearest({1, 2, 0.25}, {0, 0, -1});
    ASSERT_TRUE(ceiling);
    EXPECT_LE((ceiling->point.position - Vec3(1, 2, 2.5)).norm(), rounding);
    EXPECT_EQ(ceiling->distance, 2.25);
}

TEST(SurfaceFinder, OnAnEdgeTheNormalTellsTheFace) {
    const Mesh room = box({0, 0, 0}, {4, 3, 2.5}, 1, Front::inside);
    const SurfaceFinder finder(room);
    // Both faces turn from both normals by less than 90°. A point ahead along the steep one is 0.8 above the floor and
    // 0.6 from the wall, which is therefore meant; along the flat one it is the other way round.
    const auto wall = finder.nearest({0, 2, 0}, {0.6, 0, 0.8}), floor = finder.nearest({0, 2, 0}, {0.8, 0, 0.6});
    ASSERT_TRUE(floor && wall);
    EXPECT_EQ(wall->distance, 0.0);
    EXPECT_EQ(floor->distance, 0.0);
    EXPECT_EQ(wall->point.normal, Vec3(1, 0, 0));
    EXPECT_EQ(floor->point.normal, Vec3(0, 0, 1));
}

TEST(SurfaceFinder, FindsNothingIfNothingFacesThatWay) {
    const Mesh square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1);
    EXPECT_TRUE(SurfaceFinder(square).nearest({0.5, 0.5, 1}, {0, 0, 1}));
    EXPECT_FALSE(SurfaceFinder(square).nearest({0.5, 0.5, 1}, {0, 0, -1}));
}

} // namespace difusa::surface_finder_test
