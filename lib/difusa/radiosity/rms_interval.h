// Means of squares over the surface, from weighted random points, and the intervals of their roots.
#pragma once

#include <span>

namespace difusa {

/// The root of the mean over the area of the sum of the squares of all channels, W/m²: estimate, and the ends of an
/// interval: each with a confidence of at least 97.5 %.
struct RmsEstimate {
    double rms = 0.0, low = 0.0, high = 0.0;
};

/// A mean over the area, its standard error, how many points of equal values would leave as much doubt (Kish 1965), and
/// by how much a point raises the mean at most.
struct AreaMean {
    double value = 0.0, deviation = 0.0, effective = 1.0, largest = 0.0;
};

/// The sum of `values` times the areas `weight` that they stand for, over `area`. The weights sum to a known area, so
/// that only the deviations from the mean leave doubt.
AreaMean mean_over(double area, std::span<const double> weight, std::span<const double> values);

/// The sum of two independent means.
AreaMean sum_of(const AreaMean& a, const AreaMean& b);

/// The root of a mean of squares. Where the mean is known well enough, the interval is one of its logarithm: a few
/// large values make the distribution of means a skew one. Squared errors have heavy tails, of which the points may
/// have missed a part; the upper end allows for as many points as may have been missed, with the largest share that was
/// seen. A mean of products of independent measurements may come out below 0, which the mean square is not: the upper
/// end is then that of 0.
RmsEstimate root_of(const AreaMean& mean);

} // namespace difusa
