// Points chosen among others keep what they stand for.
#include <difusa/radiosity/surfel_points.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace difusa::surfel_points_test {
namespace {

TEST(ChoosePoints, TakesEachAsOftenAsItsChanceSays) {
    SurfelPoints from;
    std::vector<double> chance;
    for (Index p = 0; p < 12; ++p) {
        from.place.emplace_back();
        from.weight.push_back(1.0 + p);
        from.surfel.push_back(p);
        from.group.push_back(p % 2);
        chance.push_back(1.0 + p * p);
    }
    constexpr std::size_t shares = 40;
    RandomStream stream(1, "chances");
    const SurfelPoints points = choose_points(from, chance, shares, 2, stream);
    ASSERT_EQ(points.size(), 2 * shares);
    for (Index g = 0; g < 2; ++g) {
        double all = 0.0;
        for (Index p = g; p < 12; p += 2) {
            all += chance[p];
        }
        std::vector<double> times(12, 0.0);
        for (std::size_t k = 0; k < points.size(); ++k) {
            if (points.group[k] == g) {
                const Index p = points.surfel[k];
                times[p] += 1.0;
                EXPECT_DOUBLE_EQ(points.weight[k], from.weight[p] * all / (chance[p] * shares));
            }
        }
        for (Index p = 0; p < 12; ++p) {
            // Of the shares, it has some as a whole, and parts of two.
            EXPECT_LT(std::abs(times[p] - (p % 2 == g ? chance[p] / all * shares : 0.0)), 2.0) << p;
        }
    }
    EXPECT_EQ(choose_points({}, {}, shares, 2, stream).size(), 0U);
}

} // namespace
} // namespace difusa::surfel_points_test
