// The reader `stl` on good, odd and hostile files.
#include <readers.h>

#include <cmath>

namespace difusa::readers_stl_test {
namespace {

using readers::notes;
using readers::refusal;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

PolygonSoup stl(std::string_view content) {
    return readers::parse("stl", content);
}

const std::string text =
    "solid two words\n  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n      vertex 1 0 0\n"
    "      vertex 0 0.5 0\n    endloop\n  endfacet\n  facet normal 0 0 1\n    outer loop\n"
    "      vertex 1 0 0\n      vertex 1 1 0\n      vertex 0 0.5 0\n    endloop\n  endfacet\n"
    "endsolid two words\n";

/// The same triangles; `count` is what the header says.
std::string binary(const std::string& header, std::uint32_t count, std::uint16_t attribute = 0) {
    readers::Bytes bytes(std::endian::little, header + std::string(80 - header.size(), ' '));
    bytes.add({count});
    bytes.add({0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 0.5F, 0.F}).add<std::uint16_t>({0});
    bytes.add({0.F, 0.F, 1.F, 1.F, 0.F, 0.F, 1.F, 1.F, 0.F, 0.F, 0.5F, 0.F}).add({attribute});
    return bytes.content();
}

TEST(StlReader, ReadsFacetsAndTheirLines) {
    const PolygonSoup soup = stl(text);
    ASSERT_EQ(soup.points.size(), 6U); // each facet brings its own
    EXPECT_EQ(soup.points[5], Vec3(0, 0.5, 0));
    ASSERT_EQ(soup.face_count(), 2U);
    EXPECT_THAT(soup.face(1), ElementsAre(3, 4, 5));
    EXPECT_THAT(soup.point_line, ElementsAre(4, 5, 6, 11, 12, 13));
    EXPECT_THAT(soup.face_line, ElementsAre(2, 9));
    EXPECT_THAT(soup.face_material, ElementsAre(none, none));
    EXPECT_THAT(soup.notes, IsEmpty());
}

TEST(StlReader, ReadsOddTexts) {
    std::string upper, joined;
    for (const char c : text) {
        upper += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
    bool first_line = true;
    for (const char c : text.substr(0, text.find("endsolid"))) {
        joined += c == '\n' && !first_line ? '\t' : c; // the name ends with its line
        first_line = first_line && c != '\n';
    }
    for (const std::string& same : {upper, joined + "endsolid", "\xef\xbb\xbf\r\n \t" + text,
                                    "solid\nendsolid\n\n" + text + "solid empty\nendsolid"}) {
        SCOPED_TRACE(same);
        readers::expect_equal(stl(same), stl(text));
    }
}

TEST(StlReader, KeepsDoublesOfTextsToTheLastBit) {
    const PolygonSoup soup = stl("solid\nfacet normal nan nan nan\nouter loop\nvertex 1e-300 0.1 0.33333333333333331\n"
                                 "vertex 0.725 -0 1e300\nvertex nan inf -inf\nendloop\nendfacet\nendsolid\n");
    EXPECT_EQ(soup.points[0], Vec3(1e-300, 0.1, 1.0 / 3.0));
    EXPECT_EQ(soup.points[1][0], 0.725);
    EXPECT_TRUE(std::isnan(soup.points[2][0]));
}

TEST(StlReader, BinaryEqualsTextWhateverItsFirstWord) {
    for (const char* header : {"", "made by nobody", "solid", "solid two words\nfacet normal 0 0 1\n"}) {
        SCOPED_TRACE(header);
        const PolygonSoup soup = stl(binary(header, 2));
        readers::expect_equal(soup, stl(text));
        EXPECT_THAT(soup.point_line, IsEmpty());
        EXPECT_THAT(soup.notes, IsEmpty());
    }
}

TEST(StlReader, NotesNormalsAgainstTheOrderOfTheCorners) {
    std::string turned = text;
    turned.replace(turned.rfind("0 0 1"), 5, "0 0 -1");
    const PolygonSoup soup = stl(turned);
    EXPECT_THAT(soup.face(1), ElementsAre(3, 4, 5));
    EXPECT_THAT(notes(soup), AllOf(HasSubstr("facets whose normal points to their back: 1 (first at line 9)"),
                                   HasSubstr("the order of the corners decides")));
    for (const char* harmless : {"0 0 0", "1 0 0", "nan 0 1"}) {
        turned = text;
        turned.replace(turned.find("0 0 1"), 5, harmless);
        EXPECT_THAT(stl(turned).notes, IsEmpty()) << harmless;
    }
    std::string bits = binary("", 2);
    bits[84 + 11] = static_cast<char>(bits[84 + 11] ^ '\x80'); // the sign of the first normal's z
    EXPECT_THAT(notes(stl(bits)), HasSubstr("facets whose normal points to their back: 1 (first at byte 84)"));
}

TEST(StlReader, NotesColourBitsAndTrailingBytes) {
    EXPECT_THAT(notes(stl(binary("", 2, 0x801f))), HasSubstr("colour bits in their attribute: 1 (first at byte 182)"));
    EXPECT_THAT(stl(binary("", 2, 0x7fff)).notes, IsEmpty());
    const PolygonSoup soup = stl(binary("solid", 2) + "abc");
    EXPECT_EQ(soup.face_count(), 2U);
    EXPECT_THAT(notes(soup), HasSubstr("last 3 bytes"));
    EXPECT_THAT(notes(stl(binary("", 1))), HasSubstr("last 50 bytes"));
}

TEST(StlReader, RefusesDamagedTextWhereItIs) {
    EXPECT_THAT(refusal("stl", "solid\nfacet normal 0 0\nouter loop\n"),
                AllOf(HasSubstr("test.stl:3: "), HasSubstr("'outer'")));
    EXPECT_THAT(refusal("stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0,5\n"), HasSubstr("'0,5'"));
    EXPECT_THAT(refusal("stl", "solid\nfacet normal 0 0 1\nendfacet\n"),
                AllOf(HasSubstr(":3: "), HasSubstr("expected outer")));
    EXPECT_THAT(refusal("stl", text + "nonsense\n"), AllOf(HasSubstr(":17: "), HasSubstr("'nonsense'")));
    EXPECT_THAT(refusal("stl", text.substr(0, text.find("endsolid"))), HasSubstr("the file ends where"));
    EXPECT_THAT(refusal("stl", "OFF\n"), HasSubstr("less than the 84"));
    EXPECT_THAT(refusal("stl", "OFF\n" + std::string(200, '#')), HasSubstr("does not begin with the word solid"));
}

TEST(StlReader, RefusesAHeaderThatPromisesMoreThanTheFileHolds) {
    EXPECT_THAT(refusal("stl", binary("", 4000000000)), AllOf(HasSubstr("byte 84"), HasSubstr("4000000000 facets")));
    EXPECT_THAT(refusal("stl", binary("solid", 3)), HasSubstr("3 facets"));
}

TEST(StlReader, IsSafeOnFilesCutShort) {
    // A text is whole when its last word is, with or without the solid's name.
    readers::expect_safe_prefixes("stl", text.substr(0, text.rfind("two")));
    readers::expect_safe_prefixes("stl", binary("made by nobody", 2));
    readers::expect_safe_prefixes("stl", binary("solid", 2));
}

} // namespace
} // namespace difusa::readers_stl_test
