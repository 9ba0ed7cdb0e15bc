// The nearest points of a tree are those that a look at all of them finds.
#include <difusa/core/random.h>
#include <difusa/mesh/point_tree.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace difusa::point_tree_test {
namespace {

Vec3 random_place(RandomStream& random) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    return {x, y, z};
}

TEST(PointTree, FindsTheNearestOfItsMembers) {
    RandomStream random(1, "points");
    std::vector<SurfacePoint> points(300);
    for (SurfacePoint& point : points) {
        point.position = random_place(random);
    }
    std::vector<Index> members;
    for (Index i = 0; i < points.size(); i += 3) {
        members.push_back(i);
    }
    const PointTree tree(points, members);
    ASSERT_EQ(tree.size(), members.size());
    for (int query = 0; query < 100; ++query) {
        const Vec3 p = random_place(random);
        std::sort(members.begin(), members.end(), [&](Index a, Index b) {
            return (points[a].position - p).squaredNorm() < (points[b].position - p).squaredNorm();
        });
        std::vector<Index> numbers(20);
        std::vector<double> squared(20);
        ASSERT_EQ(tree.nearest(p, numbers, squared), 20U);
        EXPECT_TRUE(std::equal(numbers.begin(), numbers.end(), members.begin()));
        EXPECT_TRUE(std::is_sorted(squared.begin(), squared.end()));
        EXPECT_EQ(tree.nearest(p), members[0]);
    }
}

TEST(PointTree, HasNoMoreThanThereAre) {
    std::vector<SurfacePoint> points(3);
    points[1].position = Vec3::UnitX();
    points[2].position = 2.0 * Vec3::UnitX();
    std::vector<Index> numbers(5, none);
    std::vector<double> squared(5, -1.0);
    EXPECT_EQ(PointTree(points).nearest(Vec3(3, 0, 0), numbers, squared), 3U);
    EXPECT_EQ(numbers, (std::vector<Index>{2, 1, 0, none, none}));
    EXPECT_EQ(squared, (std::vector<double>{1.0, 4.0, 9.0, -1.0, -1.0}));
    EXPECT_EQ(PointTree(points, {}).nearest(Vec3::Zero(), numbers, squared), 0U);
}

} // namespace
} // namespace difusa::point_tree_test
