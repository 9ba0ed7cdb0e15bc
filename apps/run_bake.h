// What programs that write a field do with a bake: run it, write its files, print its summary.
#pragma once

#include "arguments.h"

#include <difusa/bake.h>
#include <difusa/output/bake_files.h>

#include <functional>

namespace difusa {

/// Runs `bake` with the threads of `run` and its progress on the terminal, and writes the files. Unless --quiet was
/// given, prints notes on standard error if it fails, and otherwise the summary, after choices, times and residuals if
/// `verbose`, and the names of the files.
void run_bake(const BakeFiles& files, const RunArguments& run, bool verbose,
              const std::function<BakeResult(const Execution& execution)>& bake);

} // namespace difusa
