#include <difusa/core/error.h>
#include <difusa/io/field_file.h>
#include <difusa/io/whole_file.h>

#include <file_size_limit.h>
#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

namespace difusa::whole_file_test {
namespace {

namespace fs = std::filesystem;
using test::FileSizeLimit;
using test::read_file;
using test::ScratchDirectory;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Names = std::set<std::string>;

/// Permissions do not bind root, so a test of them is run as somebody else.
class OrdinaryUser {
  public:
    OrdinaryUser() : was_root_(geteuid() == 0) {
        if (was_root_) {
            EXPECT_EQ(seteuid(65534), 0);
        }
    }
    ~OrdinaryUser() {
        if (was_root_) {
            EXPECT_EQ(seteuid(0), 0);
        }
    }
    OrdinaryUser(const OrdinaryUser&) = delete;
    OrdinaryUser& operator=(const OrdinaryUser&) = delete;

  private:
    bool was_root_;
};

TEST(WholeFile, AppearsOnlyWhenCommitted) {
    const ScratchDirectory scratch;
    const std::string content("line\n\0byte", 10);
    {
        WholeFile file(scratch / "out");
        file.write(content.substr(0, 4));
        file.write("????");
        file.write(content.substr(8));
        file.seek(4);
        file.write(content.substr(4, 4));
        EXPECT_FALSE(fs::exists(scratch / "out"));
        EXPECT_EQ(scratch.names().size(), 1u); // the temporary file, in the same directory
        file.commit();
    }
    EXPECT_EQ(read_file(scratch / "out"), content);
    EXPECT_EQ(scratch.names(), Names{"out"});
}

TEST(WholeFile, AbandonedLeavesNothingAndKeepsTheOld) {
    const ScratchDirectory scratch;
    write_whole_file(scratch / "out", "old");
    {
        WholeFile file(scratch / "out");
        file.write("half of the n");
    }
    EXPECT_EQ(read_file(scratch / "out"), "old");
    EXPECT_EQ(scratch.names(), Names{"out"});
}

TEST(WholeFile, MayBeFinishedLongBeforeItIsCommitted) {
    const ScratchDirectory scratch;
    {
        WholeFile kept(scratch / "kept"), abandoned(scratch / "abandoned");
        kept.write("content");
        kept.finish();
        abandoned.finish();
        EXPECT_EQ(scratch.names().size(), 2U);
        EXPECT_FALSE(fs::exists(scratch / "kept"));
        kept.commit();
    }
    EXPECT_EQ(read_file(scratch / "kept"), "content");
    EXPECT_EQ(scratch.names(), Names{"kept"});
}

TEST(WholeFile, SaysWhyADirectoryTakesNone) {
    const ScratchDirectory scratch;
    write_whole_file(scratch / "file", "");
    EXPECT_THAT([&] { WholeFile(scratch / "file" / "out"); },
                ThrowsMessage<ResourceError>(HasSubstr("is not a directory")));
    EXPECT_THAT([&] { WholeFile(scratch / "none" / "out"); },
                ThrowsMessage<ResourceError>(HasSubstr("does not exist")));
    if (fs::is_directory("/proc")) {
        EXPECT_THAT([] { WholeFile("/proc/out"); },
                    ThrowsMessage<ResourceError>(HasSubstr("no file can be created in the directory `/proc`")));
    }
}

TEST(WholeFile, TwoAtOnceDoNotMeet) {
    const ScratchDirectory scratch;
    WholeFile a(scratch / "out"), b(scratch / "out");
    a.write("a");
    b.write("b");
    b.commit();
    a.commit();
    EXPECT_EQ(read_file(scratch / "out"), "a");
}

TEST(WholeFile, HasThePermissionsOfAnyNewFile) {
    const ScratchDirectory scratch;
    for (const mode_t mask : {022u, 027u, 077u}) {
        const mode_t old_mask = umask(mask);
        write_whole_file(scratch / std::to_string(mask), "x");
        umask(old_mask);
        struct stat status {};
        ASSERT_EQ(stat((scratch / std::to_string(mask)).c_str(), &status), 0);
        EXPECT_EQ(status.st_mode & 0777u, 0666u & ~mask);
    }
}

TEST(WholeFile, KeepsThePermissionsOfWhatItReplaces) {
    const ScratchDirectory scratch;
    for (const mode_t mode : {0600u, 0640u, 0755u}) {
        const std::filesystem::path file = scratch / std::to_string(mode);
        write_whole_file(file, "old");
        ASSERT_EQ(chmod(file.c_str(), mode), 0);
        write_whole_file(file, "new");
        struct stat status {};
        ASSERT_EQ(stat(file.c_str(), &status), 0);
        EXPECT_EQ(status.st_mode & 0777u, mode);
    }
}

TEST(WholeFile, FollowsSymbolicLinks) {
    const ScratchDirectory scratch, elsewhere;
    write_whole_file(elsewhere / "real", "old");
    fs::create_symlink(elsewhere / "real", scratch / "absolute");
    fs::create_symlink("absolute", scratch / "relative");
    fs::create_symlink(elsewhere / "new", scratch / "dangling");
    write_whole_file(scratch / "relative", "new");
    write_whole_file(scratch / "dangling", "made");
    EXPECT_EQ(read_file(elsewhere / "real"), "new");
    EXPECT_EQ(read_file(elsewhere / "new"), "made");
    EXPECT_TRUE(fs::is_symlink(scratch / "relative"));
    EXPECT_TRUE(fs::is_symlink(scratch / "dangling"));
    EXPECT_EQ(elsewhere.names(), (Names{"new", "real"}));

    fs::create_symlink("b", scratch / "a");
    fs::create_symlink("a", scratch / "b");
    EXPECT_THAT([&] { write_whole_file(scratch / "a", ""); }, ThrowsMessage<ResourceError>(HasSubstr("loop")));
}

TEST(WholeFile, RefusesWhatIsNoFile) {
    const ScratchDirectory scratch;
    fs::create_directory(scratch / "folder");
    ASSERT_EQ(mkfifo((scratch / "pipe").c_str(), 0600), 0);
    EXPECT_THAT([] { write_whole_file("-", ""); }, ThrowsMessage<UsageError>(HasSubstr("standard output")));
    EXPECT_THAT([] { write_whole_file("", ""); }, ThrowsMessage<UsageError>(HasSubstr("empty name")));
    EXPECT_THAT([&] { write_whole_file(scratch / "folder", ""); }, ThrowsMessage<UsageError>(HasSubstr("directory")));
    EXPECT_THAT([&] { write_whole_file(scratch / "new/", ""); }, ThrowsMessage<UsageError>(HasSubstr("directory")));
    EXPECT_THAT([&] { write_whole_file(scratch / "pipe", ""); }, ThrowsMessage<UsageError>(HasSubstr("pipe")));
    EXPECT_THAT([] { write_whole_file("/dev/null", ""); },
                ThrowsMessage<UsageError>(AllOf(HasSubstr("/dev/null"), HasSubstr("device"))));
    EXPECT_EQ(scratch.names(), (Names{"folder", "pipe"}));
}

TEST(WholeFile, SaysWhichDirectoryIsMissing) {
    const ScratchDirectory scratch;
    for (const std::string folder : {"none", "none/deeper"}) {
        EXPECT_THAT([&] { write_whole_file(scratch / folder / "out", ""); },
                    ThrowsMessage<ResourceError>(AllOf(HasSubstr((scratch / folder / "out").string()),
                                                       HasSubstr("directory `" + (scratch / folder).string() + "`"),
                                                       HasSubstr("does not exist"))));
    }
}

TEST(WholeFile, RespectsPermissions) {
    const ScratchDirectory scratch;
    fs::permissions(scratch.path(), fs::perms(0755));
    fs::create_directory(scratch / "locked");
    fs::permissions(scratch / "locked", fs::perms(0555));
    fs::create_directory(scratch / "open");
    fs::permissions(scratch / "open", fs::perms(0777));
    write_whole_file(scratch / "open" / "protected", "old");
    fs::permissions(scratch / "open" / "protected", fs::perms(0444));
    {
        const OrdinaryUser user;
        EXPECT_THAT([&] { write_whole_file(scratch / "locked" / "out", ""); },
                    ThrowsMessage<ResourceError>(HasSubstr("Permission denied")));
        EXPECT_THAT([&] { check_output_path(scratch / "locked" / "out", false); },
                    ThrowsMessage<ResourceError>(HasSubstr("Permission denied")));
        EXPECT_THAT([&] { write_whole_file(scratch / "open" / "protected", "new"); },
                    ThrowsMessage<ResourceError>(HasSubstr("write-protected")));
        write_whole_file(scratch / "open" / "out", "fine");
    }
    EXPECT_EQ(read_file(scratch / "open" / "protected"), "old");
    EXPECT_TRUE(fs::is_empty(scratch / "locked"));
    fs::permissions(scratch / "locked", fs::perms(0755));
}

TEST(WholeFile, FullDiskLeavesTheOldFile) {
    const ScratchDirectory scratch;
    write_whole_file(scratch / "out", "old");
    const std::string content(100'000, 'x');
    for (const rlim_t limit : {rlim_t{0}, rlim_t{5000}, rlim_t{content.size() - 1}}) {
        const FileSizeLimit full(limit);
        EXPECT_THAT([&] { write_whole_file(scratch / "out", content); },
                    ThrowsMessage<ResourceError>(HasSubstr((scratch / "out").string())));
    }
    EXPECT_EQ(read_file(scratch / "out"), "old");
    EXPECT_EQ(scratch.names(), Names{"out"});
}

TEST(CheckOutputPath, TellsBeforeTheWork) {
    const ScratchDirectory scratch;
    for (const std::string name : {"out.vtp", "out.ply", "OUT.VTP", "a.b.Ply"}) {
        EXPECT_NO_THROW(check_output_path(scratch / name, true));
    }
    for (const std::string name : {"out.obj", "out", "out.vtp.gz", ".vtp"}) {
        EXPECT_THAT([&] { check_output_path(scratch / name, true); },
                    ThrowsMessage<UsageError>(AllOf(HasSubstr(name), HasSubstr(".vtp"), HasSubstr(".ply"))));
        EXPECT_NO_THROW(check_output_path(scratch / name, false));
    }
    EXPECT_THROW(check_output_path(scratch / "none" / "out.vtp", true), ResourceError);
    EXPECT_THROW(check_output_path("-", true), UsageError);
    EXPECT_THROW(check_output_path(scratch.path(), false), UsageError);
    EXPECT_TRUE(scratch.names().empty());
}

} // namespace
} // namespace difusa::whole_file_test
