// What is left of the memory that control groups allow.
#include <difusa/core/error.h>
#include <difusa/core/memory.h>

#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace difusa::memory_test {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
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
