#include <difusa/radiosity/rms_interval.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

/// The 98.5 % quantile of Student's t, to 1 % for 4 degrees of freedom and more (Fisher and Cornish 1960). With the
/// heavy tails of squared errors, deviations come out too small more often than too large: with this quantile, 97.5 %
/// of true means are below the upper end, and more are above the lower one.
double quantile(double freedom) {
    freedom = std::max(freedom, 4.0);
    return 2.17009 + 3.09742 / freedom + 4.27769 / (freedom * freedom) + 4.5196 / (freedom * freedom * freedom);
}

/// With a confidence of 97.5 %, no more than this many of n points would fall where none has (e^-3.69 = 2.5 %).
constexpr double unseen_points = 3.69;

} // namespace

AreaMean mean_over(double area, std::span<const double> weight, std::span<const double> values) {
    DIFUSA_REQUIRE(weight.size() == values.size());
    const auto n = static_cast<double>(weight.size());
    double weights = 0.0, sum = 0.0;
    for (std::size_t p = 0; p < weight.size(); ++p) {
        weights += weight[p];
        sum += weight[p] * values[p];
    }
    AreaMean mean;
    mean.value = sum / area;
    double squares = 0.0, deviations = 0.0;
    for (std::size_t p = 0; p < weight.size(); ++p) {
        const double share = weight[p] / area * values[p];
        const double deviation = weight[p] / area * (values[p] - sum / weights);
        squares += share * share;
        deviations += deviation * deviation;
        mean.largest = std::max(mean.largest, deviation);
    }
    mean.deviation = std::sqrt(deviations * n / std::max(1.0, n - 1.0));
    mean.effective = squares > 0.0 ? mean.value * mean.value / squares : n;
    return mean;
}

AreaMean sum_of(const AreaMean& a, const AreaMean& b) {
    const auto squares = [](const AreaMean& mean) {
        return mean.effective > 0.0 ? mean.value * mean.value / mean.effective : 0.0;
    };
    const double both = squares(a) + squares(b), value = a.value + b.value;
    return {value, std::hypot(a.deviation, b.deviation), both > 0.0 ? value * value / both : a.effective,
            std::hypot(a.largest, b.largest)};
}

RmsEstimate root_of(const AreaMean& mean) {
    const auto root = [](double square) { return std::sqrt(std::max(0.0, square)); };
    const double reach = quantile(mean.effective - 1.0) * mean.deviation;
    const double unseen = unseen_points * mean.largest;
    if (mean.value > 3.0 * mean.deviation) {
        const double factor = std::exp(reach / mean.value);
        return {root(mean.value), root(mean.value / factor), root(mean.value * factor + unseen)};
    }
    return {root(mean.value), root(mean.value - reach), root(std::max(0.0, mean.value) + reach + unseen)};
}

} // namespace difusa
