// How fast and how accurate: one bake of a scene with a known answer.
#pragma once

#include <difusa/bake.h>
#include <difusa/study/metrics.h>
#include <difusa/study/reference_case.h>

#include <string>
#include <vector>

namespace difusa {

/// What one bake of a case gave.
struct Measurement {
    std::string case_name;
    BakeOptions options; ///< with what was left open filled in
    bool failed = false;
    std::string failure; ///< why, in one sentence; then nothing below is filled in

    std::size_t sites = 0, rays = 0, segments = 0;
    int iterations = 0;
    double seconds = 0.0; ///< wall time up to the field, without reading, error estimate and writing; least of all runs
    double seconds_output = 0.0; ///< of evaluating it, or gathering, at the places it was judged at
    ErrorNorms total;            ///< of the radiosity B
    ErrorNorms indirect;         ///< of rho H_indirect; empty where the reference does not know it
    double bound_rms = 0.0;      ///< of the error of B, as the bake claims; infinite if it claims none
    double residual_rms = 0.0;
};

struct MeasureOptions {
    std::size_t places = 20000; ///< surface points at which the field is compared, spread evenly
    int repeats = 1;            ///< timings; the fastest counts
    std::uint64_t seed = 1;     ///< of the places
};

/// A case with the exact answer at the places where fields are compared: random surface points, with the normals of the
/// ideal surface.
struct Judge {
    ReferenceCase reference;
    std::vector<SurfacePoint> places;
    std::vector<double> rho, H, H_direct; ///< exact, one for each place; H_direct: empty where it is not known

    Judge(ReferenceCase reference, const MeasureOptions& how, const Execution& execution);
};

/// Bakes the case and compares B = E + rho H with the exact one at the judge's places. `options.final_gather` rays are
/// used there too. A bake that ends with NotConverged or
/// ResourceError is a result: `failed`.
Measurement measure(const Registry& registry, const Judge& judge, const BakeOptions& options, const MeasureOptions& how,
                    const Execution& execution);

} // namespace difusa
