// Files as such: finding the reader, opening the file, and the scanners below all readers.
#include <readers.h>

#include <difusa/import/byte_scanner.h>
#include <difusa/import/file_colours.h>
#include <difusa/import/text_scanner.h>

#include <chrono>
#include <clocale>
#include <cmath>
#include <fstream>
#include <locale>
#include <random>

#include <sys/resource.h>

namespace difusa::readers_file_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;
using Reach = TextScanner::Reach;

class ReadSoup : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("difusa_read_soup_" + std::to_string(std::random_device{}()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    std::string refusal(const fs::path& file) const {
        try {
            read_soup(registry_, file);
        } catch (const InputError& error) {
            return error.what();
        }
        ADD_FAILURE() << "accepted: " << file;
        return "";
    }
    Registry registry_ = Registry::load();
    fs::path folder_;
};

TEST_F(ReadSoup, FindsTheReaderByTheExtensionInEitherCase) {
    const std::string off = "OFF 1 1 0\n0 0 0\n1 0\n";
    EXPECT_EQ(read_soup(registry_, write("a.off", off)).face_count(), 1U);
    EXPECT_EQ(read_soup(registry_, write("b.OFF", off)).face_count(), 1U);
    EXPECT_EQ(read_soup(registry_, write("c.d.Coff", off)).face_count(), 1U);
    EXPECT_EQ(read_soup(registry_, write("a.obj", "v 0 0 0\nf 1 1 1\n")).face_count(), 1U);
    EXPECT_EQ(read_soup(registry_, write("a.stl", "solid\nendsolid\n")).face_count(), 0U);
    EXPECT_EQ(read_soup(registry_, write("a.off", off)).file, (folder_ / "a.off").string());
}

TEST_F(ReadSoup, RefusesWhatIsNoReadableMeshFile) {
    EXPECT_THAT(refusal(folder_ / "gone.off"), AllOf(HasSubstr("gone.off"), HasSubstr("cannot be opened")));
    EXPECT_THAT(refusal(folder_ / "gone.xyz"), HasSubstr("cannot be opened"));
    EXPECT_THAT(refusal(write("empty.off", "")), HasSubstr("is empty"));
    EXPECT_THAT(refusal(write("a.xyz", "0 0 0\n")),
                AllOf(HasSubstr("a.xyz"), HasSubstr(".coff"), HasSubstr(".obj .off .ply")));
    EXPECT_THAT(refusal(write("plain", "0 0 0\n")), HasSubstr("no extension"));
    fs::create_directories(folder_ / "folder.off");
    EXPECT_THAT(refusal(folder_ / "folder.off"), HasSubstr("is a directory"));
    EXPECT_THAT(refusal("/dev/zero"), HasSubstr("not a regular file"));
}

TEST(HeaderLies, AreRefusedAtOnceAndBeforeTheirMemoryIsTaken) {
    const std::string rest(100, '0');
    const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
    const std::string ply = "element vertex 4000000000\n" + xyz + "element face 4000000000\n" +
                            "property list uchar int vertex_indices\nend_header\n" + rest;
    const auto stl = readers::Bytes(std::endian::little, std::string(80, ' ')).add({4000000000U}).content() + rest;
    const std::vector<std::pair<std::string, std::string>> files{
        {"off", "OFF 3 4000000000 0\n" + rest},
        {"off", readers::Bytes(std::endian::big, "OFF BINARY\n").add({3, 2000000000, 0}).content() + rest},
        {"ply", "ply\nformat ascii 1.0\n" + ply},
        {"ply", "ply\nformat binary_little_endian 1.0\n" + ply},
        {"stl", stl}};
    for (const auto& [name, content] : files) {
        const std::shared_ptr<Reader> reader = readers::reader(name);
        const auto peak_kilobytes = [] {
            rusage usage{};
            getrusage(RUSAGE_SELF, &usage);
            return usage.ru_maxrss;
        };
        const long before = peak_kilobytes();
        EXPECT_THROW(reader->parse(content, "lie"), InputError) << name;
        EXPECT_LT(peak_kilobytes() - before, 10000) << name;
    }
}

TEST(ParseReal, TakesWhatLibrariesPrintAndNothingElse) {
    double value = 0.0;
    for (const char* good : {"0", "-1.5", "+1.5", "1.", ".5", "1e5", "1E+5", "1e-5", "007"}) {
        EXPECT_TRUE(parse_real(good, value)) << good;
        EXPECT_EQ(value, std::strtod(good, nullptr)) << good;
    }
    for (const char* bad : {"", "+", "-", ".", "e5", "1e", "1,5", "0x10", "1.5f", "--1", "+-1", "1 ", "one", "1.#IN"}) {
        EXPECT_FALSE(parse_real(bad, value)) << bad;
    }
    for (const char* not_a_number : {"nan", "NaN", "-nan", "-nan(ind)", "1.#QNAN", "-1.#IND", "1.#SNAN"}) {
        EXPECT_TRUE(parse_real(not_a_number, value)) << not_a_number;
        EXPECT_TRUE(std::isnan(value)) << not_a_number;
    }
    const double infinity = std::numeric_limits<double>::infinity();
    for (const char* infinite : {"inf", "Infinity", "+INF", "1.#INF", "1e999", "1e99999999999999999999"}) {
        EXPECT_TRUE(parse_real(infinite, value)) << infinite;
        EXPECT_EQ(value, infinity) << infinite;
    }
    EXPECT_TRUE(parse_real("-1e999", value));
    EXPECT_EQ(value, -infinity);
    EXPECT_TRUE(parse_real("1e-999", value));
    EXPECT_EQ(value, 0.0);
}

struct DecimalComma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
};

TEST(ParseReal, DoesNotDependOnTheLocale) {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    std::setlocale(LC_NUMERIC, "de_DE.UTF-8"); // where it is installed; the C++ locale differs in any case
    const std::locale classic = std::locale::global(std::locale(std::locale(), new DecimalComma));
    double point = 0.0, tiny = 1.0;
    const bool read = parse_real("1.5", point) && parse_real("0.00015e-999", tiny);
    std::locale::global(classic);
    std::setlocale(LC_ALL, before.c_str());
    EXPECT_TRUE(read);
    EXPECT_EQ(point, 1.5);
    EXPECT_EQ(tiny, 0.0);
}

TEST(ParseReal, RoundTripsOfRandomDoublesAreExact) {
    std::mt19937_64 generator(7);
    for (int i = 0; i < 10000; ++i) {
        const auto exact = std::bit_cast<double>(generator());
        if (!std::isfinite(exact)) {
            continue;
        }
        char text[40];
        std::snprintf(text, sizeof text, "%.17g", exact);
        double value = 0.0;
        ASSERT_TRUE(parse_real(text, value)) << text;
        ASSERT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(exact)) << text;
    }
}

TEST(ParseInteger, TakesWholeNumbersThatFit) {
    std::int64_t value = 0;
    EXPECT_TRUE(parse_integer("+12", value));
    EXPECT_EQ(value, 12);
    EXPECT_TRUE(parse_integer("-9223372036854775808", value));
    for (const char* bad : {"", "1.0", "1e3", "0x1", "9223372036854775808", "+-1", "1a"}) {
        EXPECT_FALSE(parse_integer(bad, value)) << bad;
    }
}

TEST(TextScanner, CountsLinesOfAllKinds) {
    TextScanner scanner("a\nb\r\nc\rd\n\r\ne", "f", {});
    std::vector<std::uint32_t> lines;
    std::string_view token;
    while (scanner.next(token, Reach::file)) {
        lines.push_back(scanner.line());
    }
    EXPECT_THAT(lines, ElementsAre(1, 2, 3, 4, 6));
    EXPECT_TRUE(scanner.ends_abruptly());
    EXPECT_EQ(TextScanner("a # x\n\n#y\nb", "f", {.comments = true}).count_lines(), 2U);
}

TEST(TextScanner, ReachOfALineEndsWithIt) {
    TextScanner scanner("  1 2 # three\n 4", "f", {.comments = true});
    std::string_view token;
    EXPECT_TRUE(scanner.next(token, Reach::line) && scanner.next(token, Reach::line));
    EXPECT_EQ(token, "2");
    EXPECT_FALSE(scanner.next(token, Reach::line));
    EXPECT_TRUE(scanner.at_line_end());
    EXPECT_TRUE(scanner.next(token, Reach::file));
    EXPECT_EQ(token, "4");
}

TEST(TextScanner, QuotesWhatItFindsReadably) {
    EXPECT_EQ(excerpt("a\x01\xff"), "'a\\x01\\xff'");
    EXPECT_LT(excerpt(std::string(1000, 'a')).size(), 50U);
}

TEST(ByteScanner, ReadsBothOrdersAndNotPastTheEnd) {
    const std::string bytes("\x01\x02\x03", 3);
    EXPECT_EQ(ByteScanner(bytes, "f", std::endian::big, 0).take<std::uint16_t>({"a"}), 0x0102);
    EXPECT_EQ(ByteScanner(bytes, "f", std::endian::little, 1).take<std::uint16_t>({"a"}), 0x0302);
    ByteScanner scanner(bytes, "f", std::endian::little, 2);
    EXPECT_THROW(scanner.take<std::uint16_t>({"a"}), InputError);
    EXPECT_THROW(scanner.skip(2, {"a"}), InputError);
    EXPECT_EQ(scanner.offset(), 2U);
}

TEST(ColourTable, NumbersManyDistinctColoursInTimeAndOrder) {
    ColourTable table;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 200000; ++i) {
        const double c = i / 200000.0;
        ASSERT_EQ(table.intern({c, 1.0 - c, c * c}), static_cast<Index>(i));
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10)); // quadratic: minutes
    EXPECT_EQ(table.intern({0.0, 1.0, 0.0}), 0U);
    std::vector<Material> materials;
    table.append_materials(1.0, materials);
    EXPECT_EQ(materials.size(), 200000U);
}

} // namespace
} // namespace difusa::readers_file_test
