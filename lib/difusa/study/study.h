// A study of speed against error: many measurements, and the tables and charts made from them.
#pragma once

#include <difusa/study/measure.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// The Cartesian product of all of these is measured.
struct StudyPlan {
    std::vector<std::string> cases; ///< empty: all cases
    std::vector<std::string> bases, projections, transports;
    std::vector<double> spacings; ///< in units of each case; empty: the case's own
    std::vector<std::size_t> rays;
    std::vector<std::size_t> final_gathers; ///< 0: the basis is evaluated
    BakeOptions common;                     ///< everything else
    MeasureOptions how;
};

/// Combinations that a bake would refuse (pairwise transport with a projection that needs more points) are left out;
/// throws UsageError if none is left. `tell` is called with each measurement as it is made.
std::vector<Measurement> run_study(const Registry& registry, const StudyPlan& plan, const Execution& execution,
                                   const std::function<void(const Measurement&)>& tell);

/// "normalized-radial, galerkin", "shepard, pairwise, final gather 256": what distinguishes the methods of a study.
std::string method_of(const Measurement& measurement);

/// One row each, with a header line; units in the column names.
std::string csv_of(const std::vector<Measurement>& measurements);

/// The same as JSON, schema "difusa-accuracy-study", version 1.
std::string json_of(const std::vector<Measurement>& measurements);

/// A Markdown table of the measurements of one case.
std::string markdown_of(const std::vector<Measurement>& measurements, const std::string& case_name);

/// Charts as SVG: relative L2 error of the radiosity against time, or against the number of sites; one line per method.
std::string error_against_time(const std::vector<Measurement>& measurements, const std::string& case_name);
std::string error_against_sites(const std::vector<Measurement>& measurements, const std::string& case_name);

} // namespace difusa
