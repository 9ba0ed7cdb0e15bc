// The light near an edge, and what it does to the order of convergence.
#pragma once

#include <difusa/study/measure.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace difusa {

/// The walls of edge_case, whose radiosity at the distance d from the edge behaves like B(0) + c d^gamma
/// (references/edge.h). As sites get closer, the error beside the edge, over a strip as wide as their spacing, comes to
/// dominate: root mean square, that of even sites falls like spacing^(gamma + 1/2) in the end.
struct EdgeTrial {
    double rho = 0.0;         ///< reflectance of both walls
    double exponent = 0.0;    ///< gamma
    double from = 0.0;        ///< the distances from the edge: from, 2 from, 4 from
    double exact_slope = 0.0; ///< the exponent that the exact light shows between these distances
    double baked_slope = std::numeric_limits<double>::quiet_NaN(); ///< of the finest graded bake; NaN: it failed
    std::vector<double> spacings;                                  ///< from coarse to fine
    std::vector<Measurement> even, graded;                         ///< bakes at these spacings
};

/// Bakes with the options at these spacings. `from`: the smallest distance, at which exponents are read off the light.
std::vector<EdgeTrial> edge_study(const Registry& registry, const std::vector<double>& reflectances,
                                  const std::vector<double>& spacings, double from, const BakeOptions& options,
                                  const MeasureOptions& how, const Execution& execution,
                                  const std::function<void(const EdgeTrial&)>& tell);

/// The exponent that values at distances d, 2 d and 4 d show: log2((f(4 d) - f(2 d)) / (f(2 d) - f(d))), exact for
/// f = a + c d^gamma.
double local_exponent(double at_d, double at_2d, double at_4d);

/// A row of a Markdown table, and its header; and as CSV, a row for each bake.
std::string edge_header(const std::vector<double>& spacings);
std::string edge_row(const EdgeTrial& trial);
std::string edge_csv_header();
std::string edge_csv_rows(const EdgeTrial& trial);

} // namespace difusa
