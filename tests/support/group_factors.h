// What points see of groups of surfels by their form factors and slopes.
#pragma once

#include <difusa/transport/analytic_factors.h>

#include <vector>

namespace difusa::test {

/// What the groups contribute of b.
inline double sum_of(const AnalyticFactors& factors, const std::vector<AnalyticFactors::Factor>& found,
                     const Values& b) {
    const Values moments = factors.tree().groups().moments_of(b);
    double sum = 0.0;
    for (const auto& [group, factor, slope] : found) {
        const Index mean = SurfelGroups::mean_row(group);
        sum += factor * moments(mean, 0) + slope.dot(Vec3(moments.block<3, 1>(mean + 1, 0)));
    }
    return sum;
}

} // namespace difusa::test
