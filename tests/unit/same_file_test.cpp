// Files are told apart by what they are, not by how they are spelled.
#include <difusa/core/error.h>
#include <difusa/io/same_file.h>

#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <vector>

namespace difusa::same_file_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

class SameFile : public testing::Test {
  protected:
    SameFile() {
        std::ofstream(scratch / "a") << "a";
        std::ofstream(scratch / "b") << "a";
        fs::create_directory(scratch / "folder");
        fs::create_symlink("a", scratch / "soft");
        fs::create_hard_link(scratch / "a", scratch / "hard");
        fs::create_symlink("folder", scratch / "also");
        fs::create_symlink("none", scratch / "dangling");
        fs::create_symlink("dangling", scratch / "twice");
        fs::create_symlink("loop", scratch / "loop");
    }
    test::ScratchDirectory scratch;
};

TEST_F(SameFile, ByAnyName) {
    for (const char* name : {"a", "./a", "folder/../a", "also/../a", "soft", "hard"}) {
        EXPECT_TRUE(same_file(scratch / "a", scratch / name)) << name;
        EXPECT_TRUE(same_file(scratch / name, scratch / "a")) << name;
        EXPECT_FALSE(same_file(scratch / "b", scratch / name)) << name;
    }
}

TEST_F(SameFile, BeforeItExists) {
    for (const char* name : {"none", "./none", "also/../none", "dangling", "twice"}) {
        EXPECT_TRUE(same_file(scratch / "none", scratch / name)) << name;
        EXPECT_FALSE(same_file(scratch / "new", scratch / name)) << name;
        EXPECT_FALSE(same_file(scratch / "a", scratch / name)) << name;
    }
    EXPECT_TRUE(same_file(scratch / "also" / "new", scratch / "folder" / "new"));
}

/// DistinctFiles agrees with same_file on every pair of names, whichever comes first.
TEST_F(SameFile, AsTheyAreAdded) {
    const std::vector<const char*> names{"a",    "./a", "folder/../a", "also/../a",  "soft",  "hard",     "b",
                                         "none", "new", "dangling",    "folder/new", "twice", "also/new", "./none"};
    for (const char* first : names) {
        for (const char* second : names) {
            DistinctFiles files;
            EXPECT_TRUE(files.add(scratch / first)) << first;
            EXPECT_EQ(files.add(scratch / second), !same_file(scratch / first, scratch / second))
                << first << " and " << second;
        }
    }
}

TEST_F(SameFile, LinksEndOrLoop) {
    EXPECT_EQ(end_of_links(scratch / "twice"), scratch / "none");
    EXPECT_EQ(end_of_links(scratch / "a"), scratch / "a");
    EXPECT_FALSE(end_of_links(scratch / "loop").has_value());
    EXPECT_FALSE(same_file(scratch / "loop", scratch / "a"));
}

TEST_F(SameFile, InputsAreNotOverwritten) {
    const std::vector<fs::path> inputs{scratch / "b", scratch / "soft", scratch / "gone"};
    EXPECT_NO_THROW(refuse_to_overwrite(inputs, {"", scratch / "new", scratch / "gone", scratch / "dangling"}));
    EXPECT_THAT(
        [&] {
            refuse_to_overwrite(inputs, {"", scratch / "hard"});
        },
        ThrowsMessage<UsageError>(AllOf(HasSubstr("hard: would overwrite"), HasSubstr("soft, which is read"))));
}

} // namespace
} // namespace difusa::same_file_test
