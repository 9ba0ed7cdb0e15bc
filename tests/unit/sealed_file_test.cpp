#include <difusa/core/error.h>
#include <difusa/io/field_file.h>
#include <difusa/io/hdf5_file.h>
#include <difusa/io/sealed_file.h>

#include <scratch_directory.h>
#include <support/refusal.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

namespace difusa::sealed_file_test {
namespace {

using test::read_file;
using test::refusal_of;
using test::ScratchDirectory;
using testing::AllOf;
using testing::HasSubstr;

const SealKind kind{"a kind of file", 3, "make it again"};

void write(const std::filesystem::path& file, const SealKind& of, const std::string& content) {
    WholeFile whole(file);
    write_sealed(whole, of, content);
    whole.commit();
}

std::string refused(const std::filesystem::path& file) {
    return refusal_of([&] { read_sealed(file, kind); }, file.string());
}

TEST(SealedFile, GivesBackWhatWasWritten) {
    const ScratchDirectory scratch;
    for (const std::string& content :
         {std::string(), std::string("x"), std::string("\0\n\xff", 3), std::string(9999, 'a')}) {
        write(scratch / "file", kind, content);
        const std::string bytes = read_sealed(scratch / "file", kind);
        EXPECT_EQ(bytes, read_file(scratch / "file"));
        EXPECT_EQ(bytes.substr(seal_size), content);
        EXPECT_EQ(bytes.substr(0, seal_size), seal_of(kind, content));
    }
}

/// The value of CRC-32/ISO-HDLC for "123456789" in catalogues of checksums.
TEST(SealedFile, StatesThePublishedCheckValue) {
    EXPECT_THAT(seal_of(kind, "123456789"), HasSubstr("\nversion 3\nbytes 9\ncrc32 cbf43926\n"));
}

TEST(SealedFile, RefusesEveryChangedByte) {
    const ScratchDirectory scratch;
    write(scratch / "file", kind, "content of some length");
    const std::string good = read_file(scratch / "file");
    for (std::size_t at = 0; at < good.size(); ++at) {
        for (const char change : {'\x01', '\x80'}) {
            std::string bad = good;
            bad[at] = static_cast<char>(bad[at] ^ change);
            write_whole_file(scratch / "bad", bad);
            EXPECT_THAT(refused(scratch / "bad"), HasSubstr("; make it again")) << at;
        }
    }
}

TEST(SealedFile, RefusesEveryOtherLength) {
    const ScratchDirectory scratch;
    write(scratch / "file", kind, "content of some length");
    const std::string good = read_file(scratch / "file");
    for (std::size_t length = 0; length < good.size(); ++length) {
        write_whole_file(scratch / "bad", good.substr(0, length));
        EXPECT_THAT(refused(scratch / "bad"), HasSubstr("; make it again")) << length;
    }
    write_whole_file(scratch / "bad", good + "x");
    EXPECT_THAT(refused(scratch / "bad"), HasSubstr("is too long"));
    write_whole_file(scratch / "bad", good.substr(0, good.size() - 1));
    EXPECT_THAT(refused(scratch / "bad"), HasSubstr("is cut short"));
    write_whole_file(scratch / "bad", "");
    EXPECT_THAT(refused(scratch / "bad"), HasSubstr("is empty"));
}

TEST(SealedFile, SaysWhatAnotherFileIs) {
    const ScratchDirectory scratch;
    write(scratch / "older", {kind.name, 2, ""}, "content");
    EXPECT_THAT(refused(scratch / "older"), AllOf(HasSubstr("has version 2"), HasSubstr("reads version 3")));
    write(scratch / "other", {"another kind", 3, ""}, "content");
    EXPECT_THAT(refused(scratch / "other"), HasSubstr("is not a file of the kind `a kind of file`"));
    write_whole_file(scratch / "hdf5", "\x89HDF\r\n\x1a\n");
    EXPECT_THAT(refused(scratch / "hdf5"), HasSubstr("is not a file of the kind"));
    EXPECT_THAT(refused(scratch / "none"), HasSubstr("cannot be opened"));
    EXPECT_THAT(refused(scratch.path()), HasSubstr("is a directory"));
}

/// What a file with attributes and arrays holds; small enough to be wrong everywhere.
std::string hdf5_content() {
    Hdf5Writer writer(seal_size);
    writer.attribute("/", "name", std::string("\xc3\xbc"));
    writer.attribute("/", "half", 0.5);
    writer.group("/group");
    writer.attribute("/group", "many", std::uint64_t{1} << 63U);
    std::vector<double> numbers(6);
    std::iota(numbers.begin(), numbers.end(), -1.0);
    writer.array("/group/numbers", std::span<const double>(numbers), 3, "of a test");
    const std::vector<std::uint8_t> bytes{7, 255};
    writer.array("/group/bytes", std::span<const std::uint8_t>(bytes), 1, "of a test");
    writer.array("/group/none", std::span<const std::uint32_t>(), 1, "of a test");
    return writer.finish();
}

TEST(Hdf5File, GivesBackWhatWasWritten) {
    const std::string content = hdf5_content();
    EXPECT_EQ(content, hdf5_content()) << "the same bytes at any time";
    const Hdf5Reader reader(seal_of(kind, content) + content, "file", "remedy");
    EXPECT_EQ(reader.text("/", "name"), "\xc3\xbc");
    EXPECT_EQ(reader.number("/", "half"), 0.5);
    EXPECT_EQ(reader.whole("/group", "many"), std::uint64_t{1} << 63U);
    EXPECT_EQ(reader.array<double>("/group/numbers", 3, 2), (std::vector<double>{-1, 0, 1, 2, 3, 4}));
    EXPECT_EQ(reader.array<std::uint8_t>("/group/bytes", 1), (std::vector<std::uint8_t>{7, 255}));
    EXPECT_TRUE(reader.array<std::uint32_t>("/group/none", 1).empty());
    EXPECT_TRUE(reader.has("/group/bytes"));
    EXPECT_FALSE(reader.has("/group/bits"));
    EXPECT_EQ(reader.attribute_names("/"), (std::vector<std::string>{"half", "name"}));
}

TEST(Hdf5File, RefusesWhatIsNotThere) {
    const std::string content = hdf5_content();
    const Hdf5Reader reader(seal_of(kind, content) + content, "file", "remedy");
    const auto refusal = [&](const auto& act) { return refusal_of([&] { act(); }, "an item"); };
    EXPECT_EQ(refusal([&] { reader.text("/", "nme"); }), "file: `/ nme` is missing; remedy");
    EXPECT_THAT(refusal([&] { reader.text("/", "half"); }), HasSubstr("has another type"));
    EXPECT_THAT(refusal([&] { reader.number("/", "name"); }), HasSubstr("has another type"));
    EXPECT_THAT(refusal([&] { reader.whole("/nowhere", "many"); }), HasSubstr("is missing"));
    EXPECT_THAT(refusal([&] { reader.array<double>("/group/none", 1); }), HasSubstr("has another type"));
    EXPECT_THAT(refusal([&] { reader.array<double>("/group/numbers", 2); }), HasSubstr("2 numbers in a row"));
    EXPECT_THAT(refusal([&] { reader.array<double>("/group/numbers", 3, 3); }), HasSubstr("has 2 rows, not 3"));
    EXPECT_THAT(refusal([&] { reader.array<double>("/group", 1); }), HasSubstr("is missing"));
    EXPECT_THAT(refusal_of([] { Hdf5Reader(std::string(4096, 'x'), "file", "remedy"); }, "no HDF5"),
                HasSubstr("is not an HDF5 file"));
}

} // namespace
} // namespace difusa::sealed_file_test
