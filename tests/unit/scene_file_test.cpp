// Scene files: what they say becomes one soup, and what is wrong with them is said with its line.
#include <difusa/import/placement.h>
#include <difusa/import/scene_file.h>

#include <gmock/gmock.h>
#include <readers.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "gltf_text.h"
#include "scene_file_fixture.h"

namespace difusa::scene_file_test {
namespace {

using test::black_and_white;
using test::bright_spot;
using test::SceneFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// ---- what a scene says ----------------------------------------------------------------------------------------

TEST_F(SceneFile, AMeshStaysAsItIs) {
    const PolygonSoup soup = with("\"comment\": [\"any\", 1]");
    EXPECT_EQ(soup.points[2], Vec3(1, 1, 0));
    EXPECT_EQ(soup.face_count(), 2U);
    EXPECT_THAT(soup.face_material, ElementsAre(none, none));
    EXPECT_THAT(soup.face_line, ElementsAre(7, 8));
    ASSERT_EQ(soup.parts.size(), 1U);
    EXPECT_EQ(soup.parts[0].file, (folder_ / "square.off").string());
    EXPECT_THAT(soup.notes, IsEmpty());
    EXPECT_FALSE(soup.camera || soup.lights.sky || soup.default_reflectance);
}

TEST_F(SceneFile, GltfIsInMetresAndItsUpIsTold) {
    write("square.gltf", gltf_text::file(gltf_text::scene("{\"mesh\":0}")));
    const auto read_with = [&](const std::string& up, const std::string& more) {
        return read("{\"difusa_scene\": 1, \"unit\": \"mm\"," + up + "\"meshes\": [{\"file\": \"square.gltf\"" + more +
                    "}]}");
    };
    const PolygonSoup soup = read_with("", "");
    EXPECT_EQ(soup.points[2], Vec3(1, 1, 0));
    EXPECT_THAT(soup.notes, ElementsAre(HasSubstr("up is (0, 1, 0) in this file and (0, 0, 1) in the scene")));
    EXPECT_EQ(read_with("", ", \"unit\": \"cm\"").points[2], Vec3(0.01, 0.01, 0));
    EXPECT_THAT(read_with("\"up\": \"y\",", "").notes, IsEmpty());
    EXPECT_THAT(read_with("", ", \"transform\": {\"rotate\": {\"axis\": [1, 0, 0], \"degrees\": 90}}").notes,
                IsEmpty());
    EXPECT_THAT(read_with("", ", \"transform\": {\"scale\": 2}").notes, ElementsAre(HasSubstr("turn the mesh")));
}

TEST_F(SceneFile, CommentsMayStandAmongMaterials) {
    const PolygonSoup soup =
        read("{\"difusa_scene\": 1, \"materials\": {\"comment\": \"paint\", \"a\": {\"reflectance\": 0.25}},"
             "\"meshes\": [{\"file\": \"square.off\", \"material\": \"a\", \"materials\": {\"comment\": 7}}]}");
    EXPECT_EQ(soup.materials.size(), 1U);
    EXPECT_EQ(soup.materials[soup.face_material[0]].name, "a");
    const PolygonSoup of_this_name = read("{\"difusa_scene\": 1, \"materials\": {\"comment\": {}},"
                                          "\"meshes\": [{\"file\": \"square.off\", \"material\": \"comment\"}]}");
    EXPECT_EQ(of_this_name.materials[of_this_name.face_material[0]].name, "comment");
}

TEST_F(SceneFile, OtherFilesAreLeftToTheReaders) {
    const PolygonSoup soup = read_scene(registry_, folder_ / "square.off");
    EXPECT_EQ(soup.face_count(), 2U);
    EXPECT_THAT(soup.parts, IsEmpty());
}

TEST_F(SceneFile, PlacesMeshes) {
    // (1, 0, 0) cm twice as long is 2 cm along x, then y; 3 in = 7.62 cm further along z.
    const PolygonSoup soup =
        read("{\"difusa_scene\": 1, \"unit\": \"in\", \"meshes\": [{\"file\": \"square.off\", \"unit\": \"cm\", "
             "\"transform\": "
             "{\"scale\": [2, 4, 1], \"rotate\": {\"axis\": [0, 0, 2], \"degrees\": 90}, \"translate\": [0, 0, 3]}}]}");
    EXPECT_LT((soup.points[1] - Vec3(0, 0.02, 0.0762)).norm(), 1e-15);
    EXPECT_LT((soup.points[2] - Vec3(-0.04, 0.02, 0.0762)).norm(), 1e-15);
    EXPECT_THAT(soup.face(0), ElementsAre(0, 1, 2));
    const PolygonSoup turned = with_mesh("\"transform\": {\"rotate\": [{\"axis\": [0, 0, 1], \"degrees\": -270}, "
                                         "{\"axis\": [1, 0, 0], \"degrees\": 90}]}");
    EXPECT_EQ(turned.points[1], Vec3(0, 0, 1)) << "x to y, then y to z, without rounding";
    EXPECT_EQ(turned.points[3], Vec3(-1, 0, 0));
    const PolygonSoup matrix =
        with_mesh("\"transform\": {\"matrix\": [0, 2, 0, 5,  3, 0, 0, 6,  0, 0, 1, 7,  0, 0, 0, 1]}");
    EXPECT_EQ(matrix.points[1], Vec3(5, 9, 7));
    EXPECT_EQ(matrix.points[3], Vec3(7, 6, 7));
    EXPECT_THAT(matrix.face(1), ElementsAre(0, 3, 2)) << "it mirrors: the front stays in front";
}

TEST_F(SceneFile, RotationsAboutAnyAxis) {
    const Vec3 axis(1, -2, 0.5);
    for (const double degrees : {0.0, 30.0, 90.0, -135.0, 1000.0}) {
        const Eigen::Matrix3d expected =
            Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis.normalized()).toRotationMatrix();
        EXPECT_LT((rotation(axis, degrees) - expected).norm(), 1e-14) << degrees;
    }
}

TEST_F(SceneFile, SeveralMeshesAreNumberedThrough) {
    write("room.mtl", "newmtl red\nKd 0.5 0.1 0.1\nnewmtl blue\nKd 0.1 0.1 0.5\n");
    write("room.obj", "mtllib room.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nusemtl blue\nf 1/1 2/1 3/1\nusemtl "
                      "red\nf 1 3 2\nl 1 2\n");
    const PolygonSoup soup =
        read("{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"square.off\"}, {\"file\": \"room.obj\"}, "
             "{\"file\": \"square.off\", \"material\": \"a\"}], \"materials\": {\"a\": {}}}");
    ASSERT_EQ(soup.face_count(), 6U);
    EXPECT_THAT(soup.face(2), ElementsAre(4, 5, 6));
    EXPECT_THAT(soup.face(4), ElementsAre(7, 8, 9));
    EXPECT_EQ(soup.points[7 + 2], Vec3(1, 1, 0));
    EXPECT_EQ(soup.face_material[0], none);
    EXPECT_EQ(soup.materials[soup.face_material[2]].name, "blue");
    EXPECT_EQ(soup.materials[soup.face_material[3]].name, "red");
    EXPECT_EQ(soup.materials[soup.face_material[4]].name, "a");
    ASSERT_EQ(soup.parts.size(), 3U);
    EXPECT_EQ(soup.parts[2].first_face, 4U);
    EXPECT_EQ(soup.parts[2].first_point, 7U);
    ASSERT_EQ(soup.corner_texture.size(), 18U);
    EXPECT_TRUE(std::isnan(soup.corner_texture[0][0]));
    EXPECT_EQ(soup.corner_texture[6], TextureCoordinates(0.5, 0.25));
    ASSERT_EQ(soup.notes.size(), 1U);
    EXPECT_THAT(soup.notes[0], AllOf(HasSubstr("room.obj: lines of kind l or p")));
}

TEST_F(SceneFile, AFaceOfOneMeshCannotNamePointsOfTheNext) {
    write("bad.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n");
    EXPECT_THAT(refused("{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"bad.off\"}, {\"file\": \"square.off\"}]}"),
                AllOf(HasSubstr("bad.off:6: face 0 (line 6) refers to point 3"), HasSubstr("3 points")));
}

TEST_F(SceneFile, PaintedAndPlainMeshes) {
    write("painted.off", "COFF\n3 1 0\n0 0 0 1.0 0 0 1\n1 0 0 1.0 0 0 1\n0 1 0 1.0 0 0 1\n3 0 1 2\n");
    const PolygonSoup soup =
        read("{\"difusa_scene\": 1, \"defaults\": {\"reflectance\": 0.25}, \"meshes\": [{\"file\": "
             "\"square.off\"}, {\"file\": \"painted.off\"}]}");
    EXPECT_FALSE(soup.painted(0));
    EXPECT_TRUE(soup.painted(2));
    EXPECT_EQ(soup.point_reflectance[4][0], 1.0);
    EXPECT_TRUE((*soup.default_reflectance == 0.25).all());
}

TEST_F(SceneFile, MaterialsThatNoFaceHasAreNoted) {
    EXPECT_TRUE(with("\"up\": \"z\"").notes.empty());
    const PolygonSoup soup = with_mesh("\"material\": \"a\"");
    ASSERT_EQ(soup.notes.size(), 1U);
    EXPECT_THAT(soup.notes[0], HasSubstr("1 material of the scene that no face has: 'b'; assign materials"));
    EXPECT_THAT(with_mesh("\"flip\": true").notes[0], HasSubstr("2 materials of the scene that no face has: 'a', 'b'"));
}

/// A name that no library defines can still be assigned a material of the scene.
TEST_F(SceneFile, MaterialsReplaceNamesThatAreNotDefined) {
    write("room.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl floor\nf 1 2 3\nusemtl wall\nf 1 3 2\n");
    const PolygonSoup soup = read("{\"difusa_scene\": 1, \"materials\": {\"a\": {\"reflectance\": 0.25}}, "
                                  "\"meshes\": [{\"file\": \"room.obj\", \"materials\": {\"floor\": \"a\"}}]}");
    EXPECT_EQ(soup.materials[soup.face_material[0]].reflectance[0], 0.25);
    EXPECT_EQ(soup.materials[soup.face_material[1]].name, "wall");
    EXPECT_TRUE(soup.materials[soup.face_material[1]].is_undefined);
    EXPECT_THAT(soup.notes, ElementsAre(HasSubstr("materials that are used but not defined: 2")));
    const PolygonSoup all =
        read("{\"difusa_scene\": 1, \"materials\": {\"a\": {}}, \"meshes\": [{\"file\": \"room.obj\", "
             "\"materials\": {\"floor\": \"a\", \"wall\": \"a\"}}]}");
    EXPECT_THAT(all.notes, IsEmpty()); // no face is left without a definition
    const PolygonSoup same = read("{\"difusa_scene\": 1, \"materials\": {\"wall\": {\"reflectance\": 0.125}}, "
                                  "\"meshes\": [{\"file\": \"room.obj\"}]}");
    EXPECT_EQ(same.materials[same.face_material[1]].reflectance[0], 0.125); // the same name will do
    EXPECT_TRUE(same.materials[same.face_material[0]].is_undefined);
}

/// Faces of such names have the vertex colours, if there are any, in a scene file as well.
TEST_F(SceneFile, NamesThatAreNotDefinedKeepVertexColours) {
    write("painted.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nusemtl floor\nf 1 2 3\nf 1 3 2\n");
    const PolygonSoup soup = read("{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"painted.obj\"}]}");
    EXPECT_TRUE(soup.painted(0) && soup.painted(1));
    EXPECT_EQ(soup.materials[soup.face_material[0]].name, "floor");
}

TEST_F(SceneFile, MaterialsByMeshNameAndRange) {
    write("room.mtl", "newmtl red\nKd 0.5 0.1 0.1\nnewmtl blue\nKd 0.1 0.1 0.5\n");
    write("room.obj", "mtllib room.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 3\nf 1 3 "
                      "2\nusemtl\nf 1 2 3\n");
    const std::string head =
        "{\"difusa_scene\": 1, \"materials\": {\"a\": {}, \"b\": {}, \"c\": {}}, \"meshes\": [{\"file\": "
        "\"room.obj\",\n";
    const auto names = [&](const std::string& members) {
        const PolygonSoup soup = read(head + members + "}]}");
        std::string result;
        for (const Index m : soup.face_material) {
            result += (m == none ? "-" : soup.materials[m].name) + " ";
        }
        return result;
    };
    EXPECT_EQ(names("\"name\": \"x\""), "red blue blue - ");
    EXPECT_EQ(names("\"material\": \"a\""), "a a a a ");
    EXPECT_EQ(names("\"materials\": {\"blue\": \"b\"}"), "red b b - ");
    EXPECT_EQ(names("\"faces\": [{\"first\": 2, \"last\": 3, \"material\": \"c\"}]"), "red blue c c ");
    EXPECT_EQ(names("\"faces\": [{\"first\": 2, \"last\": 2, \"material\": \"c\"}], \"materials\": {\"blue\": \"b\"}, "
                    "\"material\": \"a\""),
              "a b c a ");
    EXPECT_THAT(refused(head + "\"materials\": {\"blua\": \"b\"}}]}"),
                AllOf(HasSubstr("scene.json:2: "), HasSubstr("room.obj has no material 'blua'; did you mean 'blue'?")));
    EXPECT_THAT(refused(head + "\"materials\": {\"blue\": \"z\"}}]}"),
                AllOf(HasSubstr("scene.json:2: "), HasSubstr("has no 'z'; did you mean 'a'?")));
    EXPECT_THAT(refused(head + "\"material\": \"zebra\"}]}"), HasSubstr("It has: 'a', 'b', 'c'"));
    EXPECT_THAT(refused(head + "\"faces\": [{\"first\": 2, \"last\": 4, \"material\": \"c\"}]}]}"),
                HasSubstr("faces from 0 to 3"));
    EXPECT_THAT(refused(head + "\"faces\": [{\"first\": 2, \"last\": 1, \"material\": \"c\"}]}]}"),
                HasSubstr("2 to 1"));
}

TEST_F(SceneFile, Materials) {
    write("a.bmp", black_and_white());
    const PolygonSoup soup =
        with("\"defaults\": {\"reflectance\": [0.1, 0.2, 0.3]}, \"materials\": {\n\"bare\": {},\n\"full\": "
             "{\"reflectance\": "
             "0.5, \"reflectance_texture\": \"a.bmp\", \"emission\": [1, 2, 3], \"emission_texture\": \"a.bmp\", "
             "\"double_sided\": true, \"light_group\": \"g\"},\n\"picture\": {\"reflectance_texture\": \"a.bmp\"}}");
    ASSERT_EQ(soup.materials.size(), 3U);
    EXPECT_TRUE((soup.materials[0].reflectance == Rgb(0.1, 0.2, 0.3)).all());
    const Material& full = soup.materials[1];
    EXPECT_TRUE((full.reflectance == 0.5).all());
    EXPECT_TRUE((full.emission == Rgb(1, 2, 3)).all());
    EXPECT_TRUE(full.double_sided);
    EXPECT_EQ(full.light_group, "g");
    EXPECT_EQ(full.reflectance_texture, full.emission_texture) << "decoded once";
    EXPECT_EQ(full.reflectance_texture->at({0.25, 0.5})[0], 0.0);
    EXPECT_EQ(full.reflectance_texture->at({0.75, 0.5})[0], 1.0);
    EXPECT_TRUE((soup.materials[2].reflectance == 1.0).all());
}

// ---- what is refused ------------------------------------------------------------------------------------------

TEST_F(SceneFile, SymmetryPlanesAndPeriods) {
    const PolygonSoup soup = with("\"unit\": \"cm\", \"symmetry\": [{\"point\": [1, 2, 3], \"normal\": [0, 0, 2]}], "
                                  "\"periodic\": [{\"translation\": [300, 0, 0]}]");
    ASSERT_EQ(soup.repetition.planes.size(), 1U);
    EXPECT_LT((soup.repetition.planes[0].point - Vec3(0.01, 0.02, 0.03)).norm(), 1e-15);
    EXPECT_EQ(soup.repetition.planes[0].normal, Vec3::UnitZ());
    EXPECT_THAT(soup.repetition.periods, ElementsAre(Vec3(3, 0, 0)));
    EXPECT_THAT(refused_with("\"symmetry\": [{\"point\": [1, 2, 3]}]"), HasSubstr("normal"));
    EXPECT_THAT(refused_with("\"symmetry\": [{\"point\": [1, 2, 3], \"normal\": [0, 0, 0]}]"), HasSubstr("zero"));
    EXPECT_THAT(refused_with("\"symmetry\": {\"point\": [1, 2, 3]}"), HasSubstr("list"));
    EXPECT_THAT(refused_with("\"periodic\": [{\"translation\": [0, 0, 0]}]"),
                AllOf(HasSubstr("scene.json:3"), HasSubstr("zero")));
    EXPECT_THAT(refused_with("\"periodic\": [{\"shift\": [1, 0, 0]}]"), HasSubstr("shift"));
}

TEST_F(SceneFile, UnknownNamesAreRefusedWithTheirLine) {
    EXPECT_THAT(refused_with("\"ligths\": []"),
                AllOf(HasSubstr("scene.json:3: "), HasSubstr("has no 'ligths'; did you mean 'lights'?")));
    EXPECT_THAT(refused_with("\"lights\": [\n{\"type\": \"point\", \"position\": [0, 0, 0],\n\"intesity\": 1}]"),
                AllOf(HasSubstr("scene.json:5: "), HasSubstr("did you mean 'intensity'?")));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"pointy\"}]"), HasSubstr("did you mean 'point'?"));
    EXPECT_THAT(refused_with("\"sky\": {\"type\": \"cloudy\"}"), HasSubstr("It has: 'uniform', 'gradient', 'image'"));
    EXPECT_THAT(refused_with("\"unit\": \"yard\""), HasSubstr("'yard'; it must be one of m cm mm km in ft"));
    EXPECT_THAT(refused_with("\"up\": \"w\""), HasSubstr("'w'"));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"colour\": 1}}"), HasSubstr("a material has no 'colour'"));
    EXPECT_THAT(refused("{\"scene\": 1}"), HasSubstr("not a difusa scene"));
    EXPECT_THAT(refused("[1]"), HasSubstr("must be an object"));
    EXPECT_THAT(refused("{\"difusa_scene\": 2}"), HasSubstr("version"));
    EXPECT_THAT(refused("{\"difusa_scene\": 1}"), HasSubstr("needs \"meshes\""));
    EXPECT_THAT(refused("{\"difusa_scene\": 1, \"meshes\": []}"), HasSubstr("needs a mesh"));
}

TEST_F(SceneFile, ValuesOutOfRangeAreRefused) {
    EXPECT_THAT(refused_with("\"materials\": {\"a\":\n{\"reflectance\": [0.5, 1.5, 0]}}"),
                AllOf(HasSubstr("scene.json:4: "), HasSubstr("from 0 (none) to 1")));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"emission\": -1}}"), HasSubstr("\"emission\" must be from 0"));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"emission\": [1, 2]}}"), HasSubstr("a number (grey) or a list"));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"emission\": \"1\"}}"), HasSubstr("a number (grey) or a list"));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"double_sided\": 1}}"), HasSubstr("true or false, not 1"));
    const auto gloss = [this](const std::string& members) {
        return refused_with("\"materials\": {\"a\": {\"reflectance\": 0.5, \"gloss\": {" + members + "}}}");
    };
    EXPECT_THAT(gloss("\"reflectance\": 0.3"), HasSubstr("needs either \"exponent\""));
    EXPECT_THAT(gloss("\"reflectance\": 0.3, \"exponent\": 5, \"roughness\": 0.5"), HasSubstr("needs either"));
    EXPECT_THAT(gloss("\"exponent\": 5"), HasSubstr("\"reflectance\""));
    EXPECT_THAT(gloss("\"reflectance\": 0.3, \"exponent\": 0.5"), HasSubstr("\"exponent\" must be from 1 to 10000"));
    EXPECT_THAT(gloss("\"reflectance\": 0.3, \"roughness\": 2"), HasSubstr("\"roughness\" must be from 0.03 to 1"));
    EXPECT_THAT(gloss("\"reflectance\": 0.6, \"roughness\": 0.5"), HasSubstr("add up to more than 1"));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"mirror\": 1.5}}"), HasSubstr("\"mirror\" must be from 0"));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"mirror\": 0.75, \"reflectance\": [0.5, 0, 0]}}"),
                HasSubstr("add up to more than 1"));
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"emission_texture\": \"x.png\"}}"), HasSubstr("\"emission\""));
    EXPECT_THAT(refused_with("\"materials\": {\"a\":\n\n{\"reflectance_texture\": \"x.png\"}}"),
                AllOf(HasSubstr("scene.json:5: "), HasSubstr("x.png: cannot be opened")));
    EXPECT_THAT(refused_with("\"defaults\": {\"reflectance\": 2}"), HasSubstr("from 0 (none) to 1"));
    EXPECT_THAT(refused_with("\"unit\": 0"), HasSubstr("above 0"));
    EXPECT_THAT(refused_with("\"up\": [0, 0, 0]"), HasSubstr("no direction"));
    EXPECT_THAT(refused_with("\"up\": [0, 0]"), HasSubstr("a list of 3 numbers, not a list of 2"));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"sun\", \"towards\": [0, 0, 1], \"irradiance\": -1}]"),
                HasSubstr("\"irradiance\" must be from 0"));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"sun\", \"irradiance\": 1}]"),
                HasSubstr("needs either \"towards\" or \"date\""));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"point\", \"position\": [0, 0, 0]}]"),
                HasSubstr("needs either"));
    EXPECT_THAT(
        refused_with("\"lights\": [{\"type\": \"point\", \"position\": [0, 0, 0], \"power\": 1, \"intensity\": 1}]"),
        AllOf(HasSubstr("only one is allowed"), Not(HasSubstr("needs"))));
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1], \"look_at\": [1, 0, 0], \"towards\": [1, 0, 0]}"),
                AllOf(HasSubstr("\"towards\" and \"look_at\""), HasSubstr("only one is allowed")));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"spot\", \"position\": [0, 0, 0], \"direction\": [1, 0, 0], "
                             "\"intensity\": 1, \"inner_degrees\": 40, \"outer_degrees\": 30}]"),
                HasSubstr("not 40 and 30"));
    EXPECT_THAT(refused_with("\"sky\": {\"type\": \"image\", \"file\": \"square.off\"}"), HasSubstr("not an image"));
    EXPECT_THAT(refused_with("\"sky\": {\"type\": \"image\", \"file\": \"none.hdr\"}"), HasSubstr("none.hdr"));
    write("sky.hdr", bright_spot(-1, -1));
    EXPECT_THAT(refused_with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"ahead\": [0, 0, -2]}"),
                HasSubstr("straight up or down"));
    EXPECT_THAT(refused_with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"scale\": 1e31}"),
                AllOf(HasSubstr("scene.json:3: "), HasSubstr("1e+31")));
}

TEST_F(SceneFile, MeshesThatCannotBeRead) {
    EXPECT_THAT(refused("{\"difusa_scene\": 1, \"meshes\": [\n{\"file\": \"none.off\"}]}"),
                AllOf(HasSubstr("scene.json:2: "), HasSubstr("none.off")));
    EXPECT_THAT(refused("{\"difusa_scene\": 1, \"meshes\": [\n{\"file\": \".\"}]}"),
                AllOf(HasSubstr("scene.json:2: "), HasSubstr("is a directory")));
    EXPECT_THAT(refused("{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"scene.json\"}]}"),
                HasSubstr("cannot be used as a mesh"));
    EXPECT_THAT(refused("{\"difusa_scene\": 1, \"meshes\": [{}]}"), HasSubstr("needs \"file\""));
    EXPECT_THAT(refused_mesh("\"transform\": {\"scale\": 0}"), AllOf(HasSubstr("scene.json:3: "), HasSubstr("flat")));
    EXPECT_THAT(refused_mesh("\"transform\": {\"scale\": [1, 1, 0]}"), HasSubstr("flat"));
    for (const char* wrong : {"[1, 2]", "\"2\"", "{}"}) {
        EXPECT_THAT(refused_mesh("\"transform\": {\"scale\": " + std::string(wrong) + "}"),
                    HasSubstr("\"scale\" must be a number or a list of 3 numbers"));
    }
    EXPECT_THAT(refused_mesh("\"transform\": {\"matrix\": [1, 2, 3]}"), HasSubstr("a list of 16 numbers"));
    EXPECT_THAT(refused_mesh("\"transform\": {\"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,0,0,1]}"),
                HasSubstr("last row"));
    EXPECT_THAT(refused_mesh("\"transform\": {\"rotate\": {\"axis\": [0, 0, 0], \"degrees\": 1}}"),
                HasSubstr("no direction"));
    EXPECT_THAT(refused_mesh("\"transform\": {\"rotate\": {\"axis\": [0, 0, 1]}}"), HasSubstr("needs \"degrees\""));
    EXPECT_THAT(refused_mesh("\"transform\": {\"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], \"scale\": 2}"),
                HasSubstr("either"));
}

TEST_F(SceneFile, ATextureOnAMeshWithoutCoordinatesIsItsMean) {
    write("a.bmp", black_and_white());
    const PolygonSoup soup = read("{\"difusa_scene\": 1, \"materials\": {\"a\": {\"reflectance_texture\": \"a.bmp\"}}, "
                                  "\"meshes\": [{\"file\": \"square.off\", \"material\": \"a\"}]}");
    ASSERT_EQ(soup.materials.size(), 2U);
    EXPECT_THAT(soup.face_material, ElementsAre(1, 1));
    EXPECT_TRUE((soup.materials[1].reflectance == 0.5).all());
    EXPECT_THAT(soup.notes, ElementsAre(AllOf(HasSubstr("2 (first: face 0 (line 7) of "), HasSubstr("square.off"))));
}

} // namespace
} // namespace difusa::scene_file_test
