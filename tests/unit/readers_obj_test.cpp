// The reader `obj` and its material libraries on good, odd and hostile files.
#include <readers.h>

#include <difusa/import/material_library.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <random>

namespace difusa::readers_obj_test {
namespace {

using readers::notes;
using readers::refusal;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
namespace fs = std::filesystem;

PolygonSoup obj(std::string_view content) {
    return readers::parse("obj", content);
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\n";

/// A fresh directory that is removed at the end.
class ObjLibraries : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("difusa_obj_" + std::to_string(std::random_device{}()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    void write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }
    PolygonSoup read(const std::string& text) const {
        write("room.obj", text);
        return readers::reader("obj")->read(folder_ / "room.obj");
    }
    fs::path folder_;
};

TEST(ObjReader, ReadsPolygonsAndTheirLines) {
    const PolygonSoup soup = obj("# a square\n" + square);
    ASSERT_EQ(soup.points.size(), 4U);
    EXPECT_EQ(soup.points[2], Vec3(1, 1, 0));
    ASSERT_EQ(soup.face_count(), 2U);
    EXPECT_THAT(soup.face(1), ElementsAre(0, 1, 2, 3));
    EXPECT_THAT(soup.point_line, ElementsAre(2, 3, 4, 5));
    EXPECT_THAT(soup.face_line, ElementsAre(6, 7));
    EXPECT_THAT(soup.face_material, ElementsAre(none, none));
    EXPECT_THAT(soup.point_reflectance, IsEmpty());
    EXPECT_THAT(soup.notes, IsEmpty());
}

TEST(ObjReader, ReadsAllFormsOfCorners) {
    const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\n";
    const PolygonSoup plain = obj(points + "f 1 2 3\n");
    for (const char* face : {"f 1/1 2/1 3/1\n", "f 1//1 2//1 3//1\n", "f 1/1/1 2/1/1 3/1/1\n", "f -3 -2 -1\n",
                             "f -3/-1/-1 2/1/1 -1\n", "fo 1 2 3\n", "f 1 2 3 # remark\r\n", "f 1 \\\n  2\\\r\n 3\n",
                             "  f\t1  2 3  \n", "o a\ng b c\ns off\nf +1 2 3\n"}) {
        SCOPED_TRACE(face);
        readers::expect_equal(obj(points + face), plain);
    }
}

TEST(ObjReader, RelativeIndicesCountFromTheLatestPoint) {
    const PolygonSoup soup = obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -3 -2 -1\nf 1 2 5\nv 9 9 9\n");
    EXPECT_THAT(soup.face(0), ElementsAre(0, 1, 2));
    EXPECT_THAT(soup.face(1), ElementsAre(1, 2, 3));
    EXPECT_THAT(soup.face(2), ElementsAre(0, 1, 4)); // a point may follow the faces that use it
}

TEST(ObjReader, RefusesIndicesThatNameNoPointByTheNumbersOfTheFile) {
    EXPECT_THAT(
        refusal("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n"),
        HasSubstr("test.obj:5: the face refers to point 4, but the file has 3 points (OBJ numbers them from 1)"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf 1 1 \\\n 0\n"),
                HasSubstr("test.obj:2: the face refers to point 0, but OBJ numbers points from 1"));
    EXPECT_THAT(
        refusal("obj", "v 0 0 0\nf 1 1 -2\nv 0 0 0\n"),
        AllOf(HasSubstr("test.obj:2: the face refers to point -2, which counts back"), HasSubstr("only 1 point:")));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf 1 1 99999999999\n"),
                AllOf(HasSubstr("test.obj:2: the face refers to point 99999999999"), HasSubstr("2^32")));
}

TEST(ObjReader, NotesNormalsAgainstTheOrderOfTheCorners) {
    const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvn 0 0 -1\nvn 0.9 0 -0.1\nvn\n";
    const PolygonSoup soup = obj(points + "f 1//1 2//1 3//1\nf 1//2 2//2 3//2\nf 1/5/2 2//-3 3\n");
    EXPECT_THAT(soup.face(1), ElementsAre(0, 1, 2));
    EXPECT_THAT(notes(soup), AllOf(HasSubstr("faces whose normals (vn) point to their back: 2 (first at line 9)"),
                                   HasSubstr("the order of the corners decides")));
    // Slanted ones, and those that make no sense or do not exist, say nothing.
    EXPECT_THAT(obj(points + "f 1//3 2//3 3//3\nf 1//4 2//4 3//4\nf 1//9 2//0 3/1/-99\nf 1//2 1//2 1//2\n").notes,
                IsEmpty());
}

TEST(ObjReader, LinesAreCountedAcrossContinuedOnes) {
    const PolygonSoup soup =
        obj("# a comment is not continued \\\nv 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 \\\n2 \\\n3\nf 3 2 1\n");
    EXPECT_THAT(soup.point_line, ElementsAre(2, 4, 5));
    EXPECT_THAT(soup.face_line, ElementsAre(6, 9));
}

TEST(ObjReader, KeepsDoublesToTheLastBit) {
    const PolygonSoup soup = obj("v 1e-300 0.1 0.33333333333333331\nv 0.725 1.2345678901234567 nan\n");
    EXPECT_EQ(soup.points[0], Vec3(1e-300, 0.1, 1.0 / 3.0));
    EXPECT_EQ(soup.points[1][0], 0.725);
    EXPECT_EQ(soup.points[1][1], 1.2345678901234567);
    EXPECT_TRUE(std::isnan(soup.points[1][2]));
}

TEST(ObjReader, PointColoursTo255EqualColoursTo1) {
    const PolygonSoup whole = obj("v 0 0 0 255 51 0\nv 1 0 0 102 0 153 255\nv 0 1 0 0 0 0\nf 1 2 3\n");
    const PolygonSoup real = obj("v 0 0 0 1 0.2 0\nv 1 0 0 0.4 0 0.6 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
    readers::expect_equal(whole, real);
    EXPECT_TRUE((whole.point_reflectance[0] == Rgb(1, 0.2, 0)).all());
    EXPECT_THAT(whole.notes, IsEmpty());
}

TEST(ObjReader, PointsWithoutColourAmongColouredOnesAreNoted) {
    const PolygonSoup soup = obj("v 0 0 0\nv 1 0 0 0.25 0.5 1.0\nv 0 1 0 1\nf 1 2 3\n");
    ASSERT_EQ(soup.point_reflectance.size(), 3U);
    EXPECT_TRUE((soup.point_reflectance[0] == 0.5).all());
    EXPECT_TRUE((soup.point_reflectance[1] == Rgb(0.25, 0.5, 1)).all());
    EXPECT_TRUE((soup.point_reflectance[2] == 0.5).all());
    EXPECT_THAT(notes(soup), HasSubstr("2 of 3 points have no colour"));
}

TEST(ObjReader, NotesWhatItDoesNotRead) {
    const std::string text = notes(obj(square + "l 1 2\np 1\nl 2 3\nfoo 1\nsurf 0 1 0 1 1 2\nv 0 0 0 2\n"));
    EXPECT_THAT(text, AllOf(HasSubstr("lines of kind l or p: 3 (first at line 7: 'l'); they have no surface"),
                            HasSubstr("first at line 10: 'foo'"), HasSubstr("first at line 11: 'surf'"),
                            HasSubstr("points with a weight other than 1: 1 (first at line 12)")));
}

TEST(ObjReader, RefusesMalformedLines) {
    EXPECT_THAT(refusal("obj", "v 0 0\n"), AllOf(HasSubstr("test.obj:1: "), HasSubstr("coordinate")));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nv a b c\n"), AllOf(HasSubstr(":2: "), HasSubstr("'a'")));
    EXPECT_THAT(refusal("obj", "v 0 0 0 1 2\n"), HasSubstr("not 5 numbers"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf 1/a 1 1\n"), AllOf(HasSubstr(":2: "), HasSubstr("'1/a'")));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf 1/1/1/1 1 1\n"), HasSubstr("'1/1/1/1'"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf /1 1 1\n"), HasSubstr("'/1'"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf 1.0 1 1\n"), HasSubstr("'1.0'"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf\nv 1 0 0\n"), HasSubstr(":2: the line ends where a corner"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nmtllib\n"), HasSubstr("names no file"));
    EXPECT_THAT(refusal("obj", "solid a\nendsolid\n"), HasSubstr("neither points (v) nor faces (f)"));
    EXPECT_THAT(refusal("obj", "\n \n"), HasSubstr("neither points (v) nor faces (f)"));
}

TEST(ObjReader, IsSafeOnFilesCutShort) {
    readers::expect_safe_prefixes("obj", square);
}

TEST(ObjReader, TakesTimeInProportionToAHostileFile) {
    std::string repeated, distinct;
    for (int i = 0; i < 20000; ++i) {
        repeated += "mtllib same.mtl\n";
        distinct += "usemtl m" + std::to_string(i) + "\nf 1 1 1\nword" + std::to_string(i) + "\n";
    }
    const auto start = std::chrono::steady_clock::now();
    const PolygonSoup soup = obj("v 0 0 0\n" + repeated + distinct);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10)); // quadratic: minutes
    EXPECT_EQ(soup.face_count(), 20000U);
    EXPECT_LE(soup.notes.size(), 5U);
}

TEST_F(ObjLibraries, KdIsReflectanceAndKeIsEmission) {
    write("room.mtl", "newmtl red\nKd 0.725 0.1 0.05\nKs 1 1 1\nillum 1\n\nnewmtl lamp top\n\tKd 0.78 \\\n0.78 "
                      "0.78\nKe 1e6 17 nan\n");
    const PolygonSoup soup = read("mtllib room.mtl\n" + square +
                                  "usemtl lamp top  # bright\nf 1 2 3\nusemtl red\nf 1 2 3\n"
                                  "usemtl\nf 1 2 3\n");
    ASSERT_EQ(soup.materials.size(), 2U);
    EXPECT_EQ(soup.materials[0].name, "red");
    EXPECT_TRUE((soup.materials[0].reflectance == Rgb(0.725, 0.1, 0.05)).all());
    EXPECT_TRUE((soup.materials[0].emission == 0.0).all());
    EXPECT_EQ(soup.materials[1].name, "lamp top");
    EXPECT_TRUE((soup.materials[1].reflectance == 0.78).all());
    EXPECT_EQ(soup.materials[1].emission[0], 1e6);
    EXPECT_TRUE(std::isnan(soup.materials[1].emission[2]));
    EXPECT_THAT(soup.face_material, ElementsAre(none, none, 1, 0, none));
    EXPECT_THAT(soup.notes, IsEmpty());
}

TEST_F(ObjLibraries, LibrariesMayFollowTheFacesBeSeveralAndHaveBlanksInTheirNames) {
    write("my room.mtl", "newmtl a\nKd 0.1 0.1 0.1\n");
    write("b.mtl", "newmtl b\nKd 0.2 0.2 0.2\n");
    write("c.mtl", "newmtl c\r\nKd 0.3\r\nnewmtl a\r\nKd 0.9\r\n");
    const PolygonSoup soup = read(square + "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n"
                                           "mtllib my room.mtl\nmtllib b.mtl old\\place\\c.mtl\nmtllib b.mtl\n");
    ASSERT_EQ(soup.materials.size(), 3U);
    EXPECT_THAT(soup.face_material, ElementsAre(none, none, 0, 1, 2));
    EXPECT_EQ(soup.materials[2].reflectance[1], 0.3);
    EXPECT_THAT(notes(soup), AllOf(HasSubstr("materials defined by more than one library: 1 "), HasSubstr("'a'"),
                                   Not(HasSubstr("missing"))));
}

TEST_F(ObjLibraries, WhatIsMissingIsNoted) {
    write("room.mtl", "newmtl a\nKd 0.1 0.1 0.1\n");
    const PolygonSoup soup = read("mtllib room.mtl\nmtllib gone.mtl\nmtllib .\n" + square +
                                  "usemtl b\nf 1 2 3\nf 1 2 3\nusemtl c\nf 1 2 3\n");
    EXPECT_THAT(soup.face_material, ElementsAre(none, none, 1, 1, 2)); // after a, which is defined
    EXPECT_TRUE(soup.materials[1].is_undefined && soup.materials[2].is_undefined && !soup.materials[0].is_undefined);
    EXPECT_EQ(soup.materials[2].name, "c");
    EXPECT_THAT(notes(soup), AllOf(HasSubstr("mtllib lines with missing files: 2 (first at line 2: 'gone.mtl')"),
                                   HasSubstr("materials that are used but not defined: 2 (first at line 10: 'b')"),
                                   HasSubstr("their faces, 3 in all, are like faces without a material")));
}

TEST_F(ObjLibraries, AMalformedLibraryIsRefusedWithItsLine) {
    write("room.mtl", "newmtl a\nKd 0,1 0,1 0,1\n");
    try {
        read("mtllib room.mtl\n" + square);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), AllOf(HasSubstr("room.mtl:2: "), HasSubstr("'0,1'")));
    }
}

TEST(MaterialLibrary, OneNumberStandsForThree) {
    const MaterialLibrary library = parse_material_library("newmtl a\nKd 0.5\nKe 3\n", "a.mtl");
    ASSERT_EQ(library.materials.size(), 1U);
    EXPECT_TRUE((library.materials[0].reflectance == 0.5).all());
    EXPECT_TRUE((library.materials[0].emission == 3.0).all());
}

TEST(MaterialLibrary, NotesWhatChangesTheLight) {
    const MaterialLibrary library = parse_material_library(
        "newmtl a\nKd 1 1 1\nd 0.5\nTr 0.5\nnewmtl b\nKd xyz 1 2 3\nmap_Bump x.png\nd 1.0\nTr 0\nnewmtl a\nKd 0 0 0\n"
        "newmtl c\nKe 1 1 1\nd -halo 0.25\n",
        "a.mtl");
    ASSERT_EQ(library.materials.size(), 3U);
    EXPECT_TRUE((library.materials[0].reflectance == 1.0).all());
    std::string text;
    for (const std::string& note : library.notes) {
        text += note + "\n";
    }
    EXPECT_THAT(text, AllOf(HasSubstr("a.mtl: materials without Kd: 2 (first at line 5)"),
                            HasSubstr("not opaque: 2 (first at line 1)"),
                            HasSubstr("with a spectral or xyz colour: 1 (first at line 6)"),
                            HasSubstr("whose name was defined before: 1 (first at line 10)")));
}

TEST(MaterialLibrary, RefusesMalformedColours) {
    const auto refusal_of = [](const char* text) -> std::string {
        try {
            parse_material_library(text, "a.mtl");
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_THAT(refusal_of("newmtl a\nKd\n"), HasSubstr("a.mtl:2: "));
    EXPECT_THAT(refusal_of("newmtl a\nKd 1 1\n"), HasSubstr("two numbers"));
    EXPECT_THAT(refusal_of("newmtl a\nKe 1 1 1 1\n"), HasSubstr("'1'"));
    EXPECT_THAT(refusal_of("Kd 1 1 1\n"), HasSubstr("before the first newmtl"));
    EXPECT_THAT(refusal_of("newmtl\nKd 1 1 1\n"), HasSubstr("no name"));
}

/// A picture of 2 by 1 pixels, as BMP: left (v0 v0 v0), right (v1 v1 v1).
std::string two_pixels(unsigned char v0, unsigned char v1) {
    std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\1\0\0\0\1\0\x18\0", 30);
    bmp += std::string(24, '\0');
    return bmp + std::string(3, static_cast<char>(v0)) + std::string(3, static_cast<char>(v1)) + std::string(2, '\0');
}

TEST_F(ObjLibraries, TexturesAndTheirCoordinates) {
    write("red brick.bmp", two_pixels(0, 255));
    write("room.mtl", "newmtl wall\nmap_Kd -s 0.5 1 1 -o 0.25 0 -clamp on old\\place\\red brick.bmp\n"
                      "newmtl lamp\nKd 0.5\nKe 8\nmap_Ke red brick.bmp\n");
    const PolygonSoup soup = read("mtllib room.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0.25\nvt 0.5 0.75\nvt 1 2 3\n"
                                  "usemtl wall\nf 1/1 2/2/1 3/-1\nusemtl lamp\nf 1/1 2/2 3/4\nvt 7 8\nf 1/1 2 3/2\n");
    ASSERT_EQ(soup.corner_texture.size(), 9U);
    EXPECT_EQ(soup.corner_texture[0], TextureCoordinates(0.25, 0));
    EXPECT_EQ(soup.corner_texture[1], TextureCoordinates(0.5, 0.75));
    EXPECT_EQ(soup.corner_texture[2], TextureCoordinates(1, 2));
    EXPECT_EQ(soup.corner_texture[5], TextureCoordinates(7, 8)) << "it may follow the faces that use it";
    EXPECT_TRUE(std::isnan(soup.corner_texture[7][0]));
    const Material &wall = soup.materials[0], &lamp = soup.materials[1];
    EXPECT_TRUE((wall.reflectance == 1.0).all()) << "without Kd";
    ASSERT_TRUE(wall.reflectance_texture);
    // u' = u / 2 + 1/4, clamped: the centre of the left pixel is at u = 0, of the right one at u = 1.
    EXPECT_EQ(wall.reflectance_texture->at({0, 0.5})[0], 0.0);
    EXPECT_EQ(wall.reflectance_texture->at({1, 0.5})[0], 1.0);
    EXPECT_EQ(wall.reflectance_texture->at({9, 0.5})[0], 1.0);
    EXPECT_FALSE(wall.emission_texture);
    ASSERT_TRUE(lamp.emission_texture);
    EXPECT_EQ(lamp.emission_texture->at({0.25, 0.5})[0], 0.0);
    EXPECT_EQ(lamp.emission_texture->at({1.75, 0.5})[0], 1.0);
    EXPECT_TRUE((lamp.emission == 8.0).all());
    // The last face lacks coordinates: the mean stands for the texture.
    EXPECT_THAT(soup.face_material, ElementsAre(0, 1, 2));
    EXPECT_TRUE((soup.materials[2].emission == 4.0).all());
    EXPECT_THAT(notes(soup), HasSubstr("faces without texture coordinates whose material has a texture: 1"));
}

TEST_F(ObjLibraries, PicturesThatAreMissingOrDamaged) {
    write("room.mtl", "newmtl a\nKd 0.25\nmap_Kd gone.png\nnewmtl b\nmap_Kd gone.png\nmap_Ke gone.png\n");
    const std::string mesh = "mtllib room.mtl\n" + square + "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n";
    const PolygonSoup soup = read(mesh);
    EXPECT_TRUE((soup.materials[0].reflectance == 0.25).all());
    EXPECT_TRUE((soup.materials[1].reflectance == 0.5).all());
    EXPECT_TRUE((soup.materials[1].emission == 0.0).all());
    EXPECT_THAT(notes(soup), AllOf(HasSubstr("room.mtl: missing texture images: 3 (first at line 3: "
                                             "'gone.png')"),
                                   Not(HasSubstr("without texture coordinates"))));
    write("gone.png", "\x89PNG\r\n");
    try {
        read(mesh);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("gone.png: damaged PNG"));
    }
}

TEST(ObjReader, TextureIndicesThatNameNothing) {
    EXPECT_THAT(refusal("obj", "v 0 0 0\nvt 0 0\nf 1/1 1/1 1/1\nf 1/2 1/1 1/1\n"),
                AllOf(HasSubstr("test.obj:4: "), HasSubstr("texture coordinates"), HasSubstr("it has 1")));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nvt 0 0\nf 1/0 1/1 1/1\n"), HasSubstr(":3: "));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf 1/-1 1 1\nvt 0 0\n"), HasSubstr(":2: "));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nf 1/1+ 1 1\n"), HasSubstr("'1/1+'"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nvt a\n"), AllOf(HasSubstr(":2: "), HasSubstr("'a'")));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nvt\n"), HasSubstr("texture coordinate"));
    EXPECT_THAT(refusal("obj", "v 0 0 0\nvt 1 2 3 4\n"), HasSubstr("'4'"));
    EXPECT_THAT(obj("v 0 0 0\nf 1/1/1 1/5/1 1/9/1\n").corner_texture, IsEmpty()) << "a file without any vt";
}

TEST(MaterialLibrary, OptionsOfTextures) {
    const MaterialLibrary library = parse_material_library(
        "newmtl a\nmap_Kd -blendu on -o 1 2 3 -s 4 -mm 0 2 -t 0 0 0 1.png\nmap_Ke -clamp off  my picture.png # remark\n"
        "map_Ke -s 2 0.5 other.png\nillum 3\nKs 0.5 0.5 0.5\nnewmtl b\nillum 3\nKs 0 0 0\nnewmtl c\nKs 1\n",
        "a.mtl");
    ASSERT_EQ(library.textures.size(), 2U);
    EXPECT_EQ(library.textures[0].file, "1.png");
    EXPECT_FALSE(library.textures[0].emission);
    TexturePlacement place;
    place << 4, 0, 1, 0, 1, 2;
    EXPECT_EQ(library.textures[0].placement, place);
    EXPECT_EQ(library.textures[1].file, "other.png") << "the latest counts";
    EXPECT_EQ(library.textures[1].line, 4U);
    place << 2, 0, 0, 0, 0.5, 0;
    EXPECT_EQ(library.textures[1].placement, place);
    std::string text;
    for (const std::string& note : library.notes) {
        text += note + "\n";
    }
    EXPECT_THAT(text, AllOf(HasSubstr("unsupported texture options: 2 (first at line 2: '-blendu')"),
                            HasSubstr("(illum 3) add up to more than 1: 1 (first at line 1)"),
                            HasSubstr("the specular share is what Kd leaves")));
    EXPECT_THROW(parse_material_library("newmtl a\nmap_Kd -clamp on\n", "a.mtl"), InputError);
    EXPECT_THROW(parse_material_library("newmtl a\nmap_Kd -s x.png\n", "a.mtl"), InputError);
    EXPECT_THROW(parse_material_library("map_Kd x.png\n", "a.mtl"), InputError);
}

TEST(MaterialLibrary, SaysWhatChangesTheLookAndIsNotRead) {
    const MaterialLibrary library = parse_material_library(
        "newmtl a\nKd 0 0 0\nmap_Kd a.png\nmap_d a.png\nd 0.5\nnewmtl b\nKd 1\nPm 0\nPr 0.5\nKa 1 1 1\nNi 1.5\nPm 1\n"
        "map_Bump -bm 2 b.png\n",
        "a.mtl");
    EXPECT_THAT(library.notes,
                testing::ElementsAre(HasSubstr("whose Kd of 0 makes their map_Kd black: 1 (first at line 1)"),
                                     HasSubstr("unsupported statements: 2 (first at line 12: 'Pm'); they are ignored"),
                                     HasSubstr("that are not opaque: 1 (first at line 1)")));
}

TEST(MaterialLibrary, MirrorsAreThoseOfIllum3) {
    const MaterialLibrary library = parse_material_library(
        "newmtl a\nKd 0.25 0 0\nKs 0.5 0.25 0\nillum 3\nnewmtl b\nKd 0.5\nKs 0.5\nillum 2\nnewmtl c\nillum 3\nKd 0\n"
        "Ks 0.75\nnewmtl d\nKd 0.5 0.25 0\nKs 0.75 0.5 2\nillum 3\nnewmtl e\nKd 0\nKs spectral x.rfl\nillum 3\n",
        "a.mtl");
    ASSERT_EQ(library.materials.size(), 5U);
    const auto mirror = [&](std::size_t m) { return library.materials[m].mirror; };
    EXPECT_TRUE((mirror(0) == Rgb(0.5, 0.25, 0.0)).all());
    EXPECT_TRUE((library.materials[0].reflectance == Rgb(0.25, 0.0, 0.0)).all());
    EXPECT_TRUE((mirror(1) == 0.0).all());
    EXPECT_TRUE((mirror(2) == 0.75).all());
    EXPECT_TRUE((mirror(3) == Rgb(0.5, 0.5, 1.0)).all()) << "what Kd leaves";
    EXPECT_TRUE((mirror(4) == 0.0).all());
    std::string text;
    for (const std::string& note : library.notes) {
        text += note + "\n";
    }
    EXPECT_THAT(text,
                AllOf(HasSubstr("add up to more than 1: 1 (first at line 13)"),
                      HasSubstr("a.mtl: materials with a specular colour Ks but without illum 3: 1 (first at line 5)"),
                      HasSubstr("Ks is ignored")));
    const MaterialLibrary exported =
        parse_material_library("newmtl a\nKd 0.1\nKs 0.5\nNs 250\nillum 3\nnewmtl b\nKd 0.1\nKs 0.5\nNs 1000\nillum 3\n"
                               "newmtl c\nKs 0.5\nillum 3\n",
                               "a.mtl");
    EXPECT_TRUE((exported.materials[0].mirror == 0.0).all()) << "glossy";
    EXPECT_TRUE((exported.materials[1].mirror == 0.5).all());
    EXPECT_TRUE((exported.materials[2].mirror == 0.5).all());
    EXPECT_TRUE((exported.materials[2].reflectance == 0.0).all()) << "nothing but a mirror";
    ASSERT_TRUE(exported.materials[0].gloss);
    EXPECT_EQ(exported.materials[0].gloss->shape, (LobeShape{LobeShape::Model::phong, 250.0}));
    EXPECT_TRUE((exported.materials[0].gloss->reflectance == 0.5).all());
    EXPECT_FALSE(exported.materials[1].gloss);
    EXPECT_TRUE(exported.notes.empty());
    const MaterialLibrary dull = parse_material_library(
        "newmtl a\nKd 0.7\nKs 0.5\nNs 0\nillum 3\nnewmtl b\nKd 0.1\nKs 0\nNs 10\nillum 3\n", "a.mtl");
    ASSERT_TRUE(dull.materials[0].gloss);
    EXPECT_EQ(dull.materials[0].gloss->shape.sharpness, LobeShape::least_exponent);
    EXPECT_NEAR(dull.materials[0].gloss->reflectance[0], 0.3, 1e-15) << "what Kd leaves";
    EXPECT_FALSE(dull.materials[1].gloss);
}

} // namespace
} // namespace difusa::readers_obj_test
