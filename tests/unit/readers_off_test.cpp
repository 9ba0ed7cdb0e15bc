// The reader `off` on good, odd and hostile files.
#include <readers.h>

#include <cmath>
#include <limits>

namespace difusa::readers_off_test {
namespace {

using readers::notes;
using readers::refusal;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

PolygonSoup off(std::string_view content) {
    return readers::parse("off", content);
}

const std::string tetrahedron = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
        text.replace(at, from.size(), to);
    }
    return text;
}

TEST(OffReader, ReadsPointsFacesAndTheirLines) {
    const PolygonSoup soup = off(tetrahedron);
    ASSERT_EQ(soup.points.size(), 4U);
    EXPECT_EQ(soup.points[3], Vec3(0, 0, 1));
    ASSERT_EQ(soup.face_count(), 4U);
    EXPECT_THAT(soup.face(0), ElementsAre(0, 2, 1));
    EXPECT_THAT(soup.face(3), ElementsAre(1, 2, 3));
    EXPECT_THAT(soup.point_line, ElementsAre(3, 4, 5, 6));
    EXPECT_THAT(soup.face_line, ElementsAre(7, 8, 9, 10));
    EXPECT_THAT(soup.face_material, ElementsAre(none, none, none, none));
    EXPECT_THAT(soup.materials, IsEmpty());
    EXPECT_THAT(soup.notes, IsEmpty());
    EXPECT_EQ(soup.file, "folder/test.off");
}

TEST(OffReader, ReadsTheSameHoweverTheTextIsLaidOut) {
    const PolygonSoup plain = off(tetrahedron);
    for (const std::string& same : {
             replaced(tetrahedron, "\n", "\r\n"),
             replaced(tetrahedron, "\n", "\r"),
             "\xef\xbb\xbf" + tetrahedron,
             replaced(tetrahedron, "OFF\n", "OFF "),                       // counts on the first line
             replaced(tetrahedron, "4 4 6", "4 4"),                        // no number of edges
             replaced(tetrahedron, "4 4 6", "4\n4\n6"),                    // a line for each count
             replaced(tetrahedron, "\n", " # comment\n\n  \t# another\n"), // comments and blank lines
             replaced(tetrahedron, "\n", "#comment\n"),
             replaced(tetrahedron, "0 0 0", "+0\t 0.0e+5  0."),
             replaced(tetrahedron, "OFF", "off"),
         }) {
        SCOPED_TRACE(same);
        readers::expect_equal(off(same), plain);
        EXPECT_THAT(off(same).notes, IsEmpty());
    }
}

TEST(OffReader, ReadsSeveralPointsOnALine) {
    readers::expect_equal(off("OFF 4 4 6\n0 0 0  1 0 0\n0 1 0  0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"),
                          off(tetrahedron));
}

TEST(OffReader, ReadsAFileWithoutItsFirstWordAndSaysSo) {
    const PolygonSoup soup = off(tetrahedron.substr(4));
    readers::expect_equal(soup, off(tetrahedron));
    EXPECT_THAT(notes(soup), HasSubstr("does not begin with the word OFF"));
}

TEST(OffReader, PassesOverNormalsAndTextureCoordinates) {
    const PolygonSoup soup = off("STCNOFF\n3 1 0\n0 0 0  0 0 1  255 0 51  0.5 0.5\n1 0 0  0 0 1  0 255 0 255  1 1\n"
                                 "0 1 0  0 0 1  0 0 255  0 1\n3 0 1 2\n");
    EXPECT_EQ(soup.points[2], Vec3(0, 1, 0));
    ASSERT_EQ(soup.point_reflectance.size(), 3U);
    EXPECT_EQ(soup.point_reflectance[0][0], 1.0);
    EXPECT_EQ(soup.point_reflectance[0][2], 0.2);
    EXPECT_THAT(soup.notes, IsEmpty());
    readers::expect_equal(off("NOFF 1 1 0\n1 2 3 0 0 1\n1 0\n"), off("OFF 1 1 0\n1 2 3\n1 0\n"));
    // The order of the prefixes does not matter, that of the numbers is fixed.
    readers::expect_equal(off("NCOFF 1 1 0\n1 2 3 0 0 1 9 9 9\n1 0\n"), off("COFF 1 1 0\n1 2 3 9 9 9\n1 0\n"));
    EXPECT_THAT(refusal("off", "NNOFF 1 1 0\n1 2 3\n1 0\n"), HasSubstr("'NNOFF'"));
    readers::expect_equal(off("STOFF 1 1 0\n1 2 3 0 1\n1 0\n"), off("OFF 1 1 0\n1 2 3\n1 0\n"));
}

TEST(OffReader, KeepsDoublesToTheLastBit) {
    const PolygonSoup soup = off("OFF 4 0 0\n1e-300 0.1 0.33333333333333331\n1.7976931348623157e308 4.9e-324 -0\n"
                                 "0.725 123456789.12345678 1e400\nnan -inf 1e-400\n");
    EXPECT_EQ(soup.points[0], Vec3(1e-300, 0.1, 1.0 / 3.0));
    EXPECT_EQ(soup.points[1][0], std::numeric_limits<double>::max());
    EXPECT_EQ(soup.points[1][1], std::numeric_limits<double>::denorm_min());
    EXPECT_TRUE(std::signbit(soup.points[1][2]));
    EXPECT_EQ(soup.points[2], Vec3(0.725, 123456789.12345678, std::numeric_limits<double>::infinity()));
    EXPECT_TRUE(std::isnan(soup.points[3][0]));
    EXPECT_EQ(soup.points[3][1], -std::numeric_limits<double>::infinity());
    EXPECT_EQ(soup.points[3][2], 0.0);
}

TEST(OffReader, KeepsPolygonsOfAnySizeAndIndicesOutOfRange) {
    std::string polygon = "1000";
    for (int i = 0; i < 1000; ++i) {
        polygon += " " + std::to_string(i);
    }
    const PolygonSoup soup =
        off("OFF 1 6 0\n0 0 0\n" + polygon + "\n0\n1 0\n2 0 7\n3 -1 4294967294 4294967295\n" + "3 99999999999 0 0\n");
    EXPECT_EQ(soup.face(0).size(), 1000U);
    EXPECT_EQ(soup.face(0)[999], 999U);
    EXPECT_EQ(soup.face(1).size(), 0U);
    EXPECT_THAT(soup.face(3), ElementsAre(0, 7));
    EXPECT_THAT(soup.face(4), ElementsAre(none, 4294967294U, none));
    EXPECT_THAT(soup.face(5), ElementsAre(none, 0, 0));
}

TEST(OffReader, FaceColoursBecomeMaterials) {
    const PolygonSoup soup = off("OFF 3 5 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 51\n3 0 1 2\n3 0 1 2 0 0 0\n"
                                 "3 0 1 2 255 0 51 255\n3 0 1 2 0 0 1\n");
    ASSERT_EQ(soup.materials.size(), 3U);
    EXPECT_THAT(soup.face_material, ElementsAre(0, none, 1, 0, 2));
    EXPECT_EQ(soup.materials[0].name, "colour 1");
    EXPECT_TRUE((soup.materials[0].reflectance == Rgb(1.0, 0.0, 0.2)).all());
    EXPECT_TRUE((soup.materials[2].reflectance == Rgb(0.0, 0.0, 1.0 / 255.0)).all());
    EXPECT_TRUE((soup.materials[0].emission == 0.0).all());
    EXPECT_THAT(soup.notes, IsEmpty());
}

TEST(OffReader, ColoursTo255EqualColoursTo1) {
    const std::string body = " 3 2 0\n0 0 0 @\n1 0 0 #\n0 1 0 @\n3 0 1 2 #\n3 2 1 0 @\n";
    const auto with = [&body](const std::string& first, const std::string& second) {
        return off("COFF" + replaced(replaced(body, "@", first), "#", second));
    };
    readers::expect_equal(with("255 51 0", "102 0 153"), with("1.0 0.2 0", "0.4 0 0.6"));
    readers::expect_equal(with("255 51 0 255", "102 0 153 255"), with("1 2e-1 0 1", "0.4 0.0 0.6 1.0"));
}

TEST(OffReader, OnlyFacesMayHaveColoursAfterTheWordCOFF) {
    const std::string body = " 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 128\n";
    readers::expect_equal(off("COFF" + body), off("OFF" + body));
    EXPECT_THAT(refusal("off", "COFF 2 1 0\n0 0 0\n1 0 0 1 1 1\n1 0\n"),
                AllOf(HasSubstr(":3: "), HasSubstr("those before it have none")));
    EXPECT_THAT(refusal("off", "COFF 2 1 0\n0 0 0 1 1 1\n1 0 0\n1 0\n"),
                AllOf(HasSubstr(":3: "), HasSubstr("a colour component of point 2 of 2")));
}

TEST(OffReader, AWholeNumberScaleThatCannotBeToldIsNoted) {
    const PolygonSoup soup = off("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 0 1\n");
    EXPECT_TRUE((soup.materials[0].reflectance == Rgb(1, 0, 1)).all());
    EXPECT_THAT(notes(soup), HasSubstr("0 or 1"));
}

TEST(OffReader, RefusesColoursOfTwoScales) {
    EXPECT_THAT(refusal("off", "OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0.5 0 0\n3 0 1 2 128 0 0\n"),
                AllOf(HasSubstr("test.off:6: "), HasSubstr("128"), HasSubstr("line 5"), HasSubstr("255")));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n1 0 0 256 0\n"), HasSubstr("256"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n1 0 0 -1 0\n"), HasSubstr("'-1'"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n1 0 0 nan 0\n"), HasSubstr("'nan'"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n1 0 0 1\n"), HasSubstr("not 2"));
}

TEST(OffReader, NotesWhatItDoesNotRead) {
    const PolygonSoup soup = off("OFF 3 3 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 7\n3 0 1 2 0.5 0.5 0.5 0.25\n3 0 1 2 9\n");
    EXPECT_THAT(soup.face_material, ElementsAre(none, 0, none));
    EXPECT_THAT(notes(soup),
                AllOf(HasSubstr("colour map: 2 (first at line 5)"), HasSubstr("not opaque: 1 (first at line 6)")));
}

TEST(OffReader, RefusesWhatItCannotReadWithAReason) {
    EXPECT_THAT(refusal("off", "4OFF 1 1 0\n0 0 0 1\n1 0\n"), HasSubstr("do not have three coordinates"));
    EXPECT_THAT(refusal("off", "STC4nOFF 4\n1 1 0\n0 0 0 1\n1 0\n"), HasSubstr("do not have three coordinates"));
    EXPECT_THAT(refusal("off", "solid a\nendsolid\n"), AllOf(HasSubstr(":1: "), HasSubstr("'solid'")));
    EXPECT_THAT(refusal("off", "# nothing\n\n"), HasSubstr("only blanks"));
    EXPECT_THAT(refusal("off", "\xff\xfeO\0F\0F\0"), HasSubstr("UTF-16"));
    EXPECT_THAT(refusal("off", "OFF -1 1 0\n"), HasSubstr("-1 points and 1 faces, but a count cannot be"));
    EXPECT_THAT(refusal("off", "OFF 9 1 0\n0 0 0\n"), HasSubstr("impossible"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0\n1 0\n"), AllOf(HasSubstr(":2: "), HasSubstr("point 1 of 1")));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0,5\n1 0\n"), HasSubstr("'0,5'"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n3 0 0\n"), AllOf(HasSubstr(":3: "), HasSubstr("face 1 of 1")));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n1 0.0\n"), HasSubstr("'0.0'"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n-1\n"), HasSubstr("impossible"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0 255 0 0\n1 0\n"), AllOf(HasSubstr(":2: "), HasSubstr("COFF")));
}

TEST(OffReader, RefusesWhatFollowsTheLastFace) {
    EXPECT_THAT(refusal("off", tetrahedron + "3 0 1 2\n"), AllOf(HasSubstr(":11: "), HasSubstr("4 faces")));
}

TEST(OffReader, RefusesAHeaderThatPromisesMoreThanTheFileHolds) {
    const std::string body(200, ' ');
    EXPECT_THAT(refusal("off", "OFF 3 4000000000 0\n" + body), HasSubstr("4000000000 faces"));
    EXPECT_THAT(refusal("off", "OFF 4000000000 1 0\n" + body), HasSubstr("4000000000 points"));
    EXPECT_THAT(refusal("off", "OFF 9223372036854775807 9223372036854775807 0\n" + body), HasSubstr("impossible"));
    EXPECT_THAT(refusal("off", "OFF 99999999999999999999 1 0\n" + body), HasSubstr("the number of points"));
    EXPECT_THAT(refusal("off", "OFF 1 1 0\n0 0 0\n4000000000 0 0 0" + body), HasSubstr("4000000000 corners"));
    EXPECT_THAT(
        refusal("off", readers::Bytes(std::endian::big, "OFF BINARY\n").add({2000000000, 1, 0}).content() + body),
        HasSubstr("2000000000 points"));
}

TEST(OffReader, IsSafeOnFilesCutShort) {
    readers::expect_safe_prefixes("off", tetrahedron);
    readers::expect_safe_prefixes("off", "COFF 3 2\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n3 0 2 1\n");
}

TEST(OffReader, BinaryEqualsText) {
    readers::Bytes binary(std::endian::big, "CNOFF BINARY\n");
    binary.add({3, 3, 0});
    binary.add({0.0F, 0.0F, 0.1F, 0.0F, 0.0F, 1.0F, 0.25F, 0.5F, 1.0F, 1.0F});
    binary.add({1.0F, 0.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.5F, 1.0F, 1.0F});
    binary.add({0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.5F, 0.5F, 1.0F, 1.0F});
    binary.add({3, 0, 1, 2, 0}).add({3, 0, 2, 1, 3}).add({1.0F, 0.5F, 0.0F}).add({2, 0, -1, 1, 5});
    const PolygonSoup soup = off(binary.content());
    readers::expect_equal(soup, off("CNOFF\n3 3 0\n0 0 0.10000000149011612 0 0 1 0.25 0.5 1 1\n1 0 0 0 0 1 0 0.5 1 1\n"
                                    "0 1 0 0 0 1 0.5 0.5 1 1\n3 0 1 2\n3 0 2 1 1 0.5 0\n2 0 -1\n"));
    EXPECT_THAT(notes(soup), HasSubstr("colour map"));
    readers::expect_safe_prefixes("off", binary.content());
    EXPECT_THAT(notes(off(binary.content() + "four")), HasSubstr("4 bytes"));
    EXPECT_THAT(refusal("off", readers::Bytes(std::endian::little, "OFF BINARY\n").add({3, 1, 0, 0}).content()),
                HasSubstr("not big-endian"));
}

} // namespace
} // namespace difusa::readers_off_test
