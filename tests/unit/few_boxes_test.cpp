// Which rays may meet what is in a box.
#include <difusa/core/random.h>
#include <difusa/rays/few_boxes.h>

#include <gtest/gtest.h>

#include <cmath>

namespace difusa::few_boxes_test {
namespace {

using Box = FewBoxes::Box;

Vec3 random_point(RandomStream& stream, double scale) {
    return scale * Vec3(stream.uniform() - 0.5, stream.uniform() - 0.5, stream.uniform() - 0.5);
}

/// Boxes of all proportions, among them flat ones and points.
Box random_box(RandomStream& stream) {
    const Vec3 low = random_point(stream, 2.0);
    Vec3 sizes;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        sizes[axis] = stream.uniform() < 0.3 ? 0.0 : std::pow(10.0, -3.0 * stream.uniform());
    }
    return {low, Vec3(low + sizes)};
}

TEST(BoxFrom, IsMetByRaysTowardsItsPoints) {
    RandomStream stream(1, "boxes");
    for (int i = 0; i < 2000; ++i) {
        const FewBoxes grown({random_box(stream)}, 2.0);
        const Box inner = grown.boxes().front();
        const Vec3 origin = random_point(stream, 4.0);
        const BoxFrom from(inner, origin);
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 part((corner & 1) != 0 ? 0.999 : 0.001, (corner & 2) != 0 ? 0.999 : 0.001,
                            (corner & 4) != 0 ? 0.999 : 0.001);
            const Vec3 target = inner.min() + part.cwiseProduct(inner.sizes());
            EXPECT_TRUE(from.is_met((target - origin).normalized()));
        }
    }
}

TEST(BoxFrom, IsNotMetByRaysThatLeaveAPlaneBetweenThem) {
    RandomStream stream(2, "boxes");
    for (int i = 0; i < 2000; ++i) {
        const Box box = random_box(stream);
        Vec3 origin = random_point(stream, 4.0), away = random_point(stream, 1.0).normalized();
        const auto axis = static_cast<Eigen::Index>(stream.below(3));
        origin[axis] = box.max()[axis] + 1e-3;
        away[axis] = std::abs(away[axis]);
        EXPECT_FALSE(BoxFrom(box, origin).is_met(away));
    }
}

TEST(BoxFrom, IsMetByAllRaysFromWithin) {
    RandomStream stream(3, "boxes");
    for (int i = 0; i < 500; ++i) {
        const Box box(Vec3(-0.1, -1, -3), Vec3(0.2, 1, 2));
        const Vec3 origin =
            box.min() + (0.5 * Vec3::Ones() + 0.9 * random_point(stream, 1.0)).cwiseProduct(box.sizes());
        EXPECT_TRUE(BoxFrom(box, origin).is_met(random_point(stream, 1.0).normalized()));
    }
}

} // namespace
} // namespace difusa::few_boxes_test
