#include <difusa/core/parallel.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include <sched.h>

namespace difusa {

unsigned processors() {
    cpu_set_t own;
    if (sched_getaffinity(0, sizeof own, &own) == 0) { // not if there are more than the set holds
        return static_cast<unsigned>(std::max(1, CPU_COUNT(&own)));
    }
    return std::max(1U, std::thread::hardware_concurrency());
}

void parallel_for(std::size_t count, std::size_t grain, const Execution& execution,
                  const std::function<void(std::size_t, std::size_t, unsigned)>& body) {
    grain = std::max<std::size_t>(grain, 1);
    std::atomic<std::size_t> next{0};
    std::atomic<std::size_t> done{0};
    std::mutex guard;
    std::exception_ptr failure;
    std::size_t failed_at = count;

    const auto work = [&](unsigned worker) {
        for (;;) {
            const std::size_t begin = next.fetch_add(grain);
            if (begin >= count) {
                return;
            }
            const std::size_t end = std::min(begin + grain, count);
            try {
                if (execution.progress != nullptr) {
                    execution.progress->check();
                }
                body(begin, end, worker);
                const std::size_t now = done.fetch_add(end - begin) + (end - begin);
                if (worker == 0 && execution.progress != nullptr) {
                    execution.progress->advance(static_cast<double>(now) / static_cast<double>(count));
                }
            } catch (...) {
                const std::lock_guard<std::mutex> lock(guard);
                if (begin < failed_at) {
                    failed_at = begin;
                    failure = std::current_exception();
                }
                next = count; // ranges already assigned still run; no new ones start
                return;
            }
        }
    };

    const std::size_t ranges = (count + grain - 1) / grain;
    const auto helpers = static_cast<unsigned>(std::min<std::size_t>(execution.threads, ranges));
    std::vector<std::thread> threads;
    for (unsigned worker = 1; worker < helpers; ++worker) {
        try {
            threads.emplace_back(work, worker);
        } catch (const std::system_error&) {
            execution.note_once("the system provides fewer threads than requested: the computation takes longer, and "
                                "has the same result (ulimit -u, --threads)");
            break; // the others do the work
        }
    }
    work(0);
    for (std::thread& thread : threads) {
        thread.join();
    }
    if (failure) {
        std::rethrow_exception(failure);
    }
}

} // namespace difusa
