// The reader `ply` on good, odd and hostile files.
#include <readers.h>

#include <cmath>

namespace difusa::readers_ply_test {
namespace {

using readers::Bytes;
using readers::notes;
using readers::refusal;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

PolygonSoup ply(std::string_view content) {
    return readers::parse("ply", content);
}

std::string header(const std::string& format, const std::string& elements) {
    return "ply\nformat " + format + " 1.0\ncomment made by hand\nobj_info nothing\n" + elements + "end_header\n";
}

const std::string xyz = "property double x\nproperty double y\nproperty double z\n";
const std::string corners = "property list uchar int vertex_indices\n";
const std::string triangle_header = header("ascii", "element vertex 3\n" + xyz + "element face 1\n" + corners);
const std::string triangle = triangle_header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// One file in three formats: points with colours and a list to skip, an unknown element, faces of two sizes with
/// colours, all numeric types.
const std::string mixed = "element vertex 3\nproperty double x\nproperty uchar red\nproperty uchar green\n"
                          "property uchar blue\nproperty float y\nproperty list ushort double extra\nproperty short z\n"
                          "element edge 2\nproperty char a\nproperty uint b\n"
                          "element face 2\nproperty ushort red\nproperty ushort green\nproperty ushort blue\n"
                          "property list uint short vertex_index\nproperty int8 flag\n";

std::string mixed_binary(std::endian order) {
    Bytes bytes(order, header(order == std::endian::big ? "binary_big_endian" : "binary_little_endian", mixed));
    using u8 = std::uint8_t;
    using u16 = std::uint16_t;
    bytes.add({0.1}).add<u8>({255, 0, 51}).add({0.5F}).add<u16>({2}).add({7.0, 8.0}).add<std::int16_t>({-3});
    bytes.add({1e-300}).add<u8>({0, 255, 0}).add({-2.5F}).add<u16>({0}).add<std::int16_t>({300});
    bytes.add({1.0 / 3.0}).add<u8>({1, 2, 3}).add({0.0F}).add<u16>({1}).add({9.0}).add<std::int16_t>({0});
    bytes.add<std::int8_t>({-1}).add<std::uint32_t>({4000000000}).add<std::int8_t>({1}).add<std::uint32_t>({0});
    bytes.add<u16>({65535, 0, 13107}).add<std::uint32_t>({3}).add<std::int16_t>({0, 1, 2}).add<std::int8_t>({0});
    bytes.add<u16>({0, 0, 0}).add<std::uint32_t>({4}).add<std::int16_t>({2, 1, 0, -1}).add<std::int8_t>({0});
    return bytes.content();
}

TEST(PlyReader, ReadsPointsFacesAndTheirLines) {
    const PolygonSoup soup = ply(triangle);
    ASSERT_EQ(soup.points.size(), 3U);
    EXPECT_EQ(soup.points[1], Vec3(1, 0, 0));
    ASSERT_EQ(soup.face_count(), 1U);
    EXPECT_THAT(soup.face(0), ElementsAre(0, 1, 2));
    EXPECT_THAT(soup.point_line, ElementsAre(12, 13, 14));
    EXPECT_THAT(soup.face_line, ElementsAre(15));
    EXPECT_THAT(soup.face_material, ElementsAre(none));
    EXPECT_THAT(soup.notes, IsEmpty());
}

TEST(PlyReader, TextAndBothBinaryOrdersAreEqual) {
    const PolygonSoup text =
        ply(header("ascii", mixed) + "0.1 255 0 51 0.5 2 7 8 -3\n1e-300 0 255 0 -2.5 0 300\n"
                                     "0.33333333333333331 1 2 3 0 1 9 0\n-1 4000000000\n1 0\n65535 0 13107 3 0 1 2 0\n"
                                     "0 0 0 4 2 1 0 -1 0\n");
    ASSERT_EQ(text.points.size(), 3U);
    EXPECT_EQ(text.points[0], Vec3(0.1, 0.5, -3));
    EXPECT_EQ(text.points[1], Vec3(1e-300, -2.5, 300));
    EXPECT_EQ(text.points[2][0], 1.0 / 3.0);
    EXPECT_TRUE((text.point_reflectance[0] == Rgb(1, 0, 0.2)).all());
    EXPECT_THAT(text.face(1), ElementsAre(2, 1, 0, none));
    EXPECT_THAT(text.face_material, ElementsAre(0, 1));
    EXPECT_TRUE((text.materials[0].reflectance == Rgb(1, 0, 0.2)).all());
    EXPECT_EQ(text.materials[1].name, "colour 2");
    EXPECT_THAT(notes(text), HasSubstr("'edge'"));

    readers::expect_equal(ply(mixed_binary(std::endian::little)), text);
    readers::expect_equal(ply(mixed_binary(std::endian::big)), text);
}

TEST(PlyReader, LineEndsOfTheHeaderMayBeThoseOfWindows) {
    const std::string binary = mixed_binary(std::endian::little);
    const std::size_t body = binary.find("end_header\n") + 11;
    std::string windows;
    for (const char c : binary.substr(0, body)) {
        windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    }
    readers::expect_equal(ply(windows + binary.substr(body)), ply(binary));
    // A first byte of data that looks like a line end is one of the data.
    const std::string small = header("binary_little_endian", "element vertex 1\nproperty uchar x\nproperty uchar y\n"
                                                             "property uchar z\nelement face 0\n" +
                                                                 corners);
    EXPECT_EQ(ply(small + "\n\r\n").points[0], Vec3(10, 13, 10));
}

TEST(PlyReader, FacesMayComeBeforePoints) {
    const PolygonSoup soup =
        ply(header("ascii", "element face 1\n" + corners + "element empty 4000000000\nelement vertex 3\n" + xyz) +
            "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n");
    readers::expect_equal(soup, ply(triangle));
}

TEST(PlyReader, RealColoursCountToOneAndDiffuseIsAColour) {
    const PolygonSoup soup = ply(header("ascii", "element vertex 1\n" + xyz +
                                                     "property float diffuse_red\n"
                                                     "property float diffuse_green\nproperty float diffuse_blue\n"
                                                     "property float alpha\nelement face 1\n" +
                                                     corners) +
                                 "0 0 0 0.25 0.5 1 0.5\n1 0\n");
    ASSERT_EQ(soup.point_reflectance.size(), 1U);
    EXPECT_TRUE((soup.point_reflectance[0] == Rgb(0.25, 0.5, 1)).all());
    EXPECT_THAT(notes(soup), HasSubstr("not opaque: 1 (first at line 16)"));
}

TEST(PlyReader, RefusesColoursOutOfTheirRange) {
    const auto file = [](const std::string& type, const std::string& colour) {
        return header("ascii", "element vertex 1\n" + xyz + "property " + type + " red\nproperty " + type +
                                   " green\nproperty " + type + " blue\nelement face 1\n" + corners) +
               "0 0 0 " + colour + "\n1 0\n";
    };
    EXPECT_THAT(refusal("ply", file("float", "255 0 0")), AllOf(HasSubstr(":15: "), HasSubstr("'red'")));
    EXPECT_THAT(refusal("ply", file("uchar", "0 256 0")), HasSubstr("'green'"));
    EXPECT_THAT(refusal("ply", file("float", "0 0 nan")), HasSubstr("'blue'"));
    EXPECT_THAT(refusal("ply", file("int", "-1 0 0")), HasSubstr("'red'"));
}

TEST(PlyReader, IncompleteColoursAreNoted) {
    const PolygonSoup soup =
        ply(header("ascii", "element vertex 1\n" + xyz + "property uchar red\nelement face 1\n" + corners) +
            "0 0 0 255\n1 0\n");
    EXPECT_THAT(soup.point_reflectance, IsEmpty());
    EXPECT_THAT(notes(soup), HasSubstr("lack red, green or blue"));
}

TEST(PlyReader, StripsBecomeTrianglesOfOneOrientation) {
    const PolygonSoup soup = ply(
        header("ascii", "element vertex 5\n" + xyz + "element tristrips 1\nproperty list int int vertex_indices\n") +
        "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n10 0 1 2 3 -1 -1 2 3 4 -1\n");
    ASSERT_EQ(soup.face_count(), 3U);
    EXPECT_THAT(soup.face(0), ElementsAre(0, 1, 2));
    EXPECT_THAT(soup.face(1), ElementsAre(2, 1, 3));
    EXPECT_THAT(soup.face(2), ElementsAre(2, 3, 4));
    for (std::size_t f = 0; f < 3; ++f) {
        const auto face = soup.face(f);
        const Vec3 normal =
            (soup.points[face[1]] - soup.points[face[0]]).cross(soup.points[face[2]] - soup.points[face[0]]);
        EXPECT_GT(normal[2], 0.0) << f;
    }
    EXPECT_THAT(notes(soup), HasSubstr("3 triangles"));
}

TEST(PlyReader, RefusesHeadersItCannotTrust) {
    const std::string points = "element vertex 1\n" + xyz;
    const std::string faces = "element face 1\n" + corners;
    EXPECT_THAT(refusal("ply", "OFF\n"), AllOf(HasSubstr("test.ply:1: "), HasSubstr("not a PLY file")));
    EXPECT_THAT(refusal("ply", header("utf8", points + faces)), HasSubstr("'utf8'"));
    EXPECT_THAT(refusal("ply", "ply\nformat ascii 2.0\n" + points + faces + "end_header\n"), HasSubstr("'2.0'"));
    EXPECT_THAT(refusal("ply", "ply\n" + points + faces + "end_header\n"), HasSubstr("no line 'format'"));
    EXPECT_THAT(refusal("ply", header("ascii", faces)), HasSubstr("'vertex'"));
    EXPECT_THAT(refusal("ply", header("ascii", points)), HasSubstr("cloud of points"));
    EXPECT_THAT(refusal("ply", header("ascii", points + points + faces)), HasSubstr("twice"));
    EXPECT_THAT(refusal("ply", header("ascii", points + "property int x\n" + faces)), HasSubstr("twice"));
    EXPECT_THAT(refusal("ply", header("ascii", points + "element face 1\nproperty int a\n")),
                HasSubstr("'vertex_indices'"));
    EXPECT_THAT(refusal("ply", header("ascii", points + "property half w\n" + faces)), HasSubstr("'half'"));
    EXPECT_THAT(refusal("ply", header("ascii", points + "property list float int w\n" + faces)),
                HasSubstr("whole-number"));
    EXPECT_THAT(refusal("ply", header("ascii", "property int w\n" + points + faces)),
                HasSubstr("before the first element"));
    EXPECT_THAT(refusal("ply", header("ascii", points + "element face 1\nproperty list uchar float vertex_indices\n")),
                HasSubstr("whole-number"));
    EXPECT_THAT(refusal("ply", header("ascii", "element vertex -1\n" + xyz + faces)), HasSubstr("impossible"));
    EXPECT_THAT(refusal("ply", header("ascii", "nonsense\n" + points + faces)), HasSubstr("'nonsense'"));
}

TEST(PlyReader, RefusesDamagedTextWhereItIs) {
    EXPECT_THAT(refusal("ply", triangle_header + "0 0 0\n1 0\n0 1 0\n3 0 1 2\n"),
                AllOf(HasSubstr(":13: "), HasSubstr("vertex 2 of 3")));
    EXPECT_THAT(refusal("ply", triangle_header + "0 0 0\n1 0 0 5\n0 1 0\n3 0 1 2\n"),
                AllOf(HasSubstr(":13: "), HasSubstr("'5'")));
    EXPECT_THAT(refusal("ply", triangle_header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 x\n"),
                AllOf(HasSubstr("face 1 of 1"), HasSubstr("'x'")));
    EXPECT_THAT(refusal("ply", triangle + "3 0 1 2\n"), AllOf(HasSubstr(":16: "), HasSubstr("continues")));
}

TEST(PlyReader, BytesThatFollowBinaryDataAreNoted) {
    EXPECT_THAT(notes(ply(mixed_binary(std::endian::big) + "abc")), HasSubstr("last 3 bytes"));
}

TEST(PlyReader, RefusesAHeaderThatPromisesMoreThanTheFileHolds) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        SCOPED_TRACE(format);
        const std::string body(200, '0');
        const auto with = [&](const std::string& points, const std::string& faces) {
            return header(format, "element vertex " + points + "\n" + xyz + "element face " + faces + "\n" + corners) +
                   body;
        };
        EXPECT_THAT(refusal("ply", with("3", "4000000000")), AllOf(HasSubstr("announces at least"), HasSubstr("20")));
        EXPECT_THAT(refusal("ply", with("4000000000", "1")), HasSubstr("announces at least"));
        EXPECT_THAT(refusal("ply", with("99999999999999999999", "1")), HasSubstr("the number of elements"));
    }
    const std::string list = header(
        "binary_little_endian", "element vertex 0\n" + xyz + "element face 1\nproperty list uint int vertex_indices\n");
    EXPECT_THAT(refusal("ply", list + "\xff\xff\xff\xff" + std::string(50, 'x')),
                AllOf(HasSubstr("byte"), HasSubstr("4294967295 entries")));
}

TEST(PlyReader, IsSafeOnFilesCutShort) {
    readers::expect_safe_prefixes("ply", triangle);
    readers::expect_safe_prefixes("ply", mixed_binary(std::endian::little));
    readers::expect_safe_prefixes("ply", mixed_binary(std::endian::big));
}

} // namespace
} // namespace difusa::readers_ply_test
