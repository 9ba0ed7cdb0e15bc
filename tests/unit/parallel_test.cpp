#include <difusa/core/parallel.h>

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

namespace difusa::parallel_test {
namespace {

TEST(ParallelFor, CoversEveryIndexOnceInRangesOfTheGrain) {
    for (const std::size_t count : {0, 1, 7, 100, 1000}) {
        for (const std::size_t grain : {0, 1, 3, 64, 5000}) {
            for (const unsigned threads : {1U, 2U, 3U, 8U}) {
                std::vector<std::atomic<int>> visits(count);
                std::atomic<bool> sound{true};
                parallel_for(count, grain, Execution{threads, nullptr},
                             [&](std::size_t begin, std::size_t end, unsigned worker) {
                                 const std::size_t most = std::max<std::size_t>(grain, 1);
                                 if (begin >= end || end > count || end - begin > most || worker >= threads ||
                                     begin % most != 0) {
                                     sound = false;
                                     return;
                                 }
                                 for (std::size_t i = begin; i < end; ++i) {
                                     ++visits[i];
                                 }
                             });
                EXPECT_TRUE(sound) << count << " " << grain << " " << threads;
                for (const auto& visit : visits) {
                    EXPECT_EQ(visit, 1);
                }
            }
        }
    }
}

TEST(ParallelFor, AWorkerNumberIsHeldByOneThreadAtATime) {
    std::vector<std::atomic<int>> busy(4);
    std::atomic<bool> shared{false};
    parallel_for(400, 1, Execution{4, nullptr}, [&](std::size_t, std::size_t, unsigned worker) {
        if (busy[worker].fetch_add(1) != 0) {
            shared = true;
        }
        std::this_thread::sleep_for(std::chrono::microseconds(20));
        --busy[worker];
    });
    EXPECT_FALSE(shared);
}

TEST(ParallelFor, RethrowsTheFailureOfTheLowestRange) {
    // Ranges are handed out in order, so range 5 runs whenever a later one does; the later one fails first.
    for (const unsigned threads : {1U, 2U, 3U, 8U}) {
        std::atomic<int> running{0};
        try {
            parallel_for(200, 1, Execution{threads, nullptr}, [&](std::size_t begin, std::size_t, unsigned) {
                ++running;
                if (begin == 5) {
                    std::this_thread::sleep_for(std::chrono::milliseconds(5));
                    throw std::runtime_error("5");
                }
                if (begin > 5 && begin < 12) {
                    throw std::runtime_error("later");
                }
            });
            FAIL() << "nothing was thrown";
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ(error.what(), "5");
        }
        EXPECT_LE(running, 12 + 8) << "ranges go on being handed out after a failure";
    }
}

class Listener : public Progress {
  public:
    void advance(double fraction) override {
        only_caller = only_caller && std::this_thread::get_id() == caller;
        ascending = ascending && fraction >= last && fraction <= 1.0;
        last = fraction;
    }
    bool cancelled() const override { return ++asked > after; }

    std::thread::id caller = std::this_thread::get_id();
    bool only_caller = true, ascending = true;
    double last = 0.0;
    int after = 1 << 30;
    mutable std::atomic<int> asked{0};
};

TEST(ParallelFor, TellsItsCallerAlone) {
    Listener listener;
    parallel_for(1000, 1, Execution{3, &listener},
                 [](std::size_t, std::size_t, unsigned) { std::this_thread::sleep_for(std::chrono::microseconds(5)); });
    EXPECT_TRUE(listener.only_caller);
    EXPECT_TRUE(listener.ascending);
    EXPECT_GT(listener.last, 0.0);
}

TEST(ParallelFor, StopsWhenCancelled) {
    for (const unsigned threads : {1U, 3U}) {
        Listener listener;
        listener.after = 10;
        std::atomic<int> ran{0};
        EXPECT_THROW(
            parallel_for(100'000, 1, Execution{threads, &listener}, [&](std::size_t, std::size_t, unsigned) { ++ran; }),
            Interrupted);
        EXPECT_LE(ran, 10);
    }
}

} // namespace
} // namespace difusa::parallel_test
