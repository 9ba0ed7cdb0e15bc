// What a dry run predicts, as far as it does not depend on the machine.
#include <difusa/bake.h>

#include <support/plugins.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace difusa::dry_run_test {
namespace {

BakeOptions options_of(const std::string& analytic) {
    BakeOptions options;
    options.sites = 400;
    options.rays = 64;
    options.analytic = analytic;
    return options;
}

std::vector<std::string> names(const std::vector<std::pair<std::string, double>>& phases) {
    std::vector<std::string> names;
    for (const auto& [name, seconds] : phases) {
        names.push_back(name);
    }
    return names;
}

/// Also exact form factors, which are timed by themselves: where the bake has them, where they are ordered although
/// they do not pay, and not where they are forbidden.
TEST(DryRun, PredictsThePhasesOfTheBake) {
    const std::string phase = "exact form factors";
    for (const char* const analytic : {"auto", "always", "never"}) {
        const BakeOptions options = options_of(analytic);
        const std::string file = DIFUSA_TEST_DATA "/ball_over_disc.obj";
        const BakeResult predicted = dry_run(test::registry(), file, options, Execution{});
        const BakeResult baked = bake(test::registry(), file, options, Execution{});
        EXPECT_THAT(names(predicted.estimate.phases),
                    testing::UnorderedElementsAreArray(names(baked.journal.seconds())));
        bool any = false;
        for (const auto& [name, seconds] : predicted.estimate.phases) {
            any = any || (name == phase && seconds > 0.0);
        }
        EXPECT_EQ(any, std::string(analytic) != "never") << analytic;
    }
}

} // namespace
} // namespace difusa::dry_run_test
