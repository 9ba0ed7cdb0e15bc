// Speed and accuracy of one bake of a scene with a known solution.
#pragma once

#include <difusa/bake.h>
#include <difusa/study/metrics.h>
#include <difusa/study/reference_case.h>

#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// The results of one bake of a case.
struct Measurement {
    std::string case_name;
    BakeOptions options; ///< with defaults filled in
    bool failed = false;
    std::string failure; ///< the reason, in one sentence; then nothing below is filled in

    std::size_t sites = 0, rays = 0, segments = 0;
    int iterations = 0;
    double seconds =
        0.0; ///< wall time up to the field, without reading, error estimate and writing; minimum of all runs
    double seconds_output = 0.0; ///< time to evaluate it, or gather, at the judge's points
    ErrorNorms total;            ///< of the radiosity B
    ErrorNorms indirect;         ///< of rho H_indirect; empty if the reference does not have it
    double bound = 0.0;          ///< error bound of B reported by the bake; infinite if there is none
    RmsEstimate estimate;        ///< of the error of B, reported by the bake
};

struct MeasureOptions {
    std::size_t places = 20000; ///< surface points at which the field is compared, evenly distributed
    int repeats = 1;            ///< timed runs; the fastest counts
    std::uint64_t seed = 1;     ///< of the points
};

/// A case with the exact solution at the points where fields are compared: random surface points, with the normals of
/// the ideal surface.
struct Judge {
    ReferenceCase reference;
    std::vector<SurfacePoint> places;
    std::vector<double> rho, H, H_direct; ///< exact, one per point; H_direct: empty if unknown

    Judge(ReferenceCase reference, const MeasureOptions& how, const Execution& execution);
};

/// Bakes the case and compares B = E + rho H with the exact solution at the judge's points. `options.final_gather` rays
/// are used there too. A bake that ends with NotConverged or ResourceError is a result: `failed`. `look`, if there is
/// one, is called with the bake.
Measurement measure(const Registry& registry, const Judge& judge, const BakeOptions& options, const MeasureOptions& how,
                    const Execution& execution, const std::function<void(const BakeResult&)>& look = {});

} // namespace difusa
