// What is left of the memory that a process may take, and that control groups allow.
#include <difusa/core/error.h>
#include <difusa/core/memory.h>

#include <support/sanitized.h>

#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <list>
#include <string>
#include <vector>

namespace difusa::memory_test {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
}

/// Of 128 MiB in small blocks, which allocators keep, and of a large one nothing counts once they are freed. 32 MiB
/// are for what else is given back or taken meanwhile.
TEST(Memory, FreedIsAvailableAgain) {
    if (test::sanitized()) {
        GTEST_SKIP() << "freed memory stays with the sanitizer";
    }
    constexpr std::size_t MiB = std::size_t{1} << 20U;
    EXPECT_EQ(available_memory(0.0), 0U); // what other tests have freed is given back before anything is measured
    const double most = static_cast<double>(held_memory() + 512 * MiB);
    {
        std::list<std::array<char, 1024>> small;
        for (std::size_t i = 0; i < 128 * MiB / 1024; ++i) {
            small.emplace_back().fill('x');
        }
        const std::vector<char> large(256 * MiB, 'x');
        EXPECT_LT(available_memory(most), 160 * MiB);
    }
    EXPECT_GT(available_memory(most), 480 * MiB);
    EXPECT_EQ(available_memory(0.5 * static_cast<double>(held_memory())), 0U);
}

TEST(ControlGroups, WithoutAnyThereIsNoLimit) {
    const test::ScratchDirectory scratch;
    EXPECT_EQ(left_of_control_groups(scratch.path() / "proc", scratch.path()), std::numeric_limits<std::size_t>::max());
}

TEST(ControlGroups, OfVersion2LimitWhatIsInThem) {
    const test::ScratchDirectory scratch;
    const fs::path groups = scratch.path() / "groups", user = groups / "user", job = user / "a job";
    const auto left = [&] { return left_of_control_groups(scratch.path() / "proc", groups); };
    write(scratch.path() / "proc/self/cgroup", "0::/user/a job\n");
    write(job / "memory.max", "max\n");
    write(job / "memory.current", "300\n");
    EXPECT_EQ(left(), std::numeric_limits<std::size_t>::max());
    write(user / "memory.max", "1000\n");
    write(user / "memory.current", "700\n");
    EXPECT_EQ(left(), 300U);
    write(user / "memory.stat", "anon 400\ninactive_file 200\n");
    EXPECT_EQ(left(), 500U);
    write(job / "memory.max", "310\n");
    EXPECT_EQ(left(), 10U);
    write(job / "memory.current", "320\n");
    EXPECT_EQ(left(), 0U);
    // A container shows its own group as the root, and the path of another.
    write(scratch.path() / "proc/self/cgroup", "0::/../elsewhere\n");
    write(groups / "memory.max", "90\n");
    write(groups / "memory.current", "20\n");
    EXPECT_EQ(left(), 70U);
}

TEST(ControlGroups, OfVersion1LimitWhatIsInThem) {
    const test::ScratchDirectory scratch;
    const fs::path memory = scratch.path() / "groups/memory", job = memory / "job";
    const auto left = [&] { return left_of_control_groups(scratch.path() / "proc", scratch.path() / "groups"); };
    write(scratch.path() / "proc/self/cgroup", "4:cpu,memory:/job\n3:cpuset:/\n0::/\n");
    write(memory / "memory.limit_in_bytes", "9223372036854771712\n");
    write(memory / "memory.usage_in_bytes", "5000\n");
    write(job / "memory.limit_in_bytes", "1000\n");
    write(job / "memory.usage_in_bytes", "900\n");
    EXPECT_EQ(left(), 100U);
    write(job / "memory.stat", "inactive_file 5\ntotal_inactive_file 50\n");
    EXPECT_EQ(left(), 150U);
    write(scratch.path() / "proc/self/cgroup", "3:cpuset:/job\n");
    EXPECT_EQ(left(), std::numeric_limits<std::size_t>::max());
}

TEST(RequireMemory, SaysWhatMayBeUsed) {
    EXPECT_NO_THROW(require_memory(900.0, 1000, "this", "give up"));
    try {
        require_memory(910.0, 1000, "this", "give up");
        ADD_FAILURE() << "accepted";
    } catch (const ResourceError& error) {
        EXPECT_THAT(error.what(),
                    testing::HasSubstr("1000 B are available, of which nine tenths may be used: give up"));
    }
}

} // namespace
} // namespace difusa::memory_test
