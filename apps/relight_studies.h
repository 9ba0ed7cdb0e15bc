// What relight computes with a saved transport besides a field: daylight coefficients, gradients of goals, powers of
// lamps, and a comparison of rendering operators.
#pragma once

#include "bake_arguments.h"
#include "run_bake.h"

#include <difusa/bake/daylight.h>
#include <difusa/radiosity/rendering_operator.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

struct StudyArguments {
    std::filesystem::path daylight;      ///< coefficients to write
    std::filesystem::path daylight_from; ///< coefficients to read
    std::string sky;
    std::filesystem::path under_sky; ///< table of what the points receive
    DaylightRequest request;
    std::filesystem::path gradients;
    bool faces = false;          ///< gradients by face
    std::optional<double> lamps; ///< level wanted
    std::filesystem::path operator_table;
    std::vector<OperatorChoice> operators;

    /// No field is evaluated.
    bool without_field() const {
        return !daylight.empty() || !daylight_from.empty() || !gradients.empty() || !operator_table.empty();
    }
};

/// --daylight --daylight-from --daylight-sky --daylight-output --sky-parts --daylight-rays --gradients --face-gradients
/// --solve-lamps --operator --operator-table.
void declare_studies(CLI::App& app, StudyArguments& studies);

/// Throws UsageError for options that lack others or contradict them. `path`: a --sun-path was given.
void check_studies(const StudyArguments& studies, const BakeArguments& bake, bool path);

/// The files that the studies write.
std::vector<OutputName> outputs_of(const StudyArguments& studies);

/// A relit scene whose field is not evaluated.
using SolveRelit = std::function<BakeResult(const Execution& execution)>;

/// Writes what is asked for, and says so unless --quiet was given. `solve` is not called if coefficients are read.
void run_studies(const StudyArguments& studies, const RunArguments& run, const SolveRelit& solve);

} // namespace difusa
