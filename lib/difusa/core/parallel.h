// Parallel loops whose results do not depend on the number of threads.
#pragma once

#include <difusa/core/progress.h>

#include <cstddef>
#include <functional>

namespace difusa {

/// Calls `body(begin, end, worker)` for consecutive ranges of at most `grain` indices that together cover [0, count).
/// Ranges are assigned dynamically; each worker number in [0, threads) is held by one thread at a time, so it may
/// select scratch memory. For results independent of the number of threads, `body` must write only to locations that
/// belong to its indices.
///
/// Without as many threads to be had, those there are do the work, and a note says so.
///
/// If bodies throw, the exception of the lowest range is rethrown after all threads have stopped.
/// Throws Interrupted if `execution.progress` is cancelled.
void parallel_for(std::size_t count, std::size_t grain, const Execution& execution,
                  const std::function<void(std::size_t begin, std::size_t end, unsigned worker)>& body);

} // namespace difusa
