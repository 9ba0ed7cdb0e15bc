// Orders of convergence of whole bakes on a smooth field that is known: the manufactured box.
#include <difusa/study/measure.h>

#include <support/plugins.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace difusa::convergence_test {
namespace {

struct Method {
    std::string basis, projection;
    double order;
};

class Convergence : public testing::TestWithParam<Method> {};

/// Sites at 0.24 and 0.12. The order of an element is that of the approximation: 1 for what reproduces constants, 2 for
/// what reproduces linear functions. Over one halving of so coarse a spacing it shows to within a tenth; the noise of
/// the rays, some 1e-4, is below a fifth of the smaller error.
TEST_P(Convergence, IsThatOfTheElements) {
    MeasureOptions how;
    how.places = 2000;
    static const Judge judge(reference_case("manufactured-box"), how, Execution{2, nullptr});
    ASSERT_TRUE(judge.reference.smooth);
    std::vector<double> spacing, error;
    for (const double h : {0.24, 0.12}) {
        double squares = 0.0; // over some sets of sites: that of one set depends on where its sites happen to lie
        for (const std::uint64_t seed : {1, 2, 3, 4}) {
            BakeOptions options;
            options.basis = GetParam().basis;
            options.projection = GetParam().projection;
            options.spacing = h;
            options.rays = 1024;
            options.error_points = 0;
            options.seed = seed;
            const Measurement m = measure(test::registry(), judge, options, how, Execution{2, nullptr});
            ASSERT_FALSE(m.failed) << m.failure;
            squares += m.total.l2.error * m.total.l2.error;
        }
        spacing.push_back(h);
        error.push_back(std::sqrt(squares / 4.0));
    }
    EXPECT_GT(convergence_order(spacing, error), GetParam().order);
}

INSTANTIATE_TEST_SUITE_P(Bakes, Convergence,
                         testing::Values(Method{"shepard", "natural", 0.9}, Method{"normalized-radial", "natural", 0.9},
                                         Method{"moving-least-squares", "galerkin", 1.9}),
                         [](const auto& which) {
                             std::string name = which.param.basis;
                             name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                             return name;
                         });

} // namespace
} // namespace difusa::convergence_test
