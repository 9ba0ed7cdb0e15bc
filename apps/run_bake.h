// What programs do with a bake: run it, or light a saved transport, write its files, print its summary.
#pragma once

#include "arguments.h"
#include "bake_arguments.h"

#include <difusa/bake.h>
#include <difusa/bake/relight.h>
#include <difusa/output/bake_files.h>

#include <filesystem>
#include <functional>

namespace difusa {

/// Runs `bake` with the threads of `run` and its progress on the terminal, and writes the files. Unless --quiet was
/// given, prints notes on standard error if it fails, and otherwise the summary, after choices, times and residuals if
/// `verbose`, and the names of the files.
void run_bake(const BakeFiles& files, const RunArguments& run, bool verbose,
              const std::function<BakeResult(const Execution& execution)>& bake);

/// Loads a transport, fills in `how` what the command line leaves open with the choices of its bake, and returns the
/// result of `act`, in whose journal loading comes first.
BakeResult with_transport(const std::filesystem::path& file, const BakeArguments& arguments, RelightOptions& how,
                          const Execution& execution, const std::function<BakeResult(const SavedTransport&)>& act);

} // namespace difusa
