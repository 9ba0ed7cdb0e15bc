// Scene files: what they say becomes one soup, and what is wrong with them is said with its line.
#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/import/json_tree.h>
#include <difusa/import/placement.h>
#include <difusa/import/scene_file.h>
#include <difusa/output/bake_files.h>
#include <difusa/scene/sky_dome.h>

#include <nlohmann/json.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "scratch_directory.h"

namespace difusa {
namespace {

using test::ScratchDirectory;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string square_off = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

/// A picture of 2 by 1 pixels, black and white, as BMP.
std::string black_and_white() {
    std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\1\0\0\0\1\0\x18\0", 30);
    return bmp + std::string(24, '\0') + std::string(3, '\0') + std::string(3, '\xff') + std::string(2, '\0');
}

class SceneFile : public testing::Test {
  protected:
    void SetUp() override { write("square.off", square_off); }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }
    PolygonSoup read(const std::string& text) const {
        write("scene.json", text);
        return read_scene(registry_, folder_ / "scene.json");
    }
    /// A scene with one square, and these further members.
    PolygonSoup with(const std::string& members) const {
        return read("{\"difusa_scene\": 1,\n\"meshes\": [{\"file\": \"square.off\"}],\n" + members + "}");
    }
    PolygonSoup with_mesh(const std::string& members) const {
        return read("{\"difusa_scene\": 1, \"materials\": {\"a\": {\"reflectance\": 0.25}, \"b\": {}},\n\"meshes\": "
                    "[{\"file\": \"square.off\",\n" +
                    members + "}]}");
    }
    template <class F> std::string refusal(F read_it) const {
        try {
            read_it();
        } catch (const InputError& error) {
            return error.what();
        }
        ADD_FAILURE() << "accepted";
        return "";
    }
    std::string refused(const std::string& text) const {
        return refusal([&] { read(text); });
    }
    std::string refused_with(const std::string& members) const {
        return refusal([&] { with(members); });
    }
    std::string refused_mesh(const std::string& members) const {
        return refusal([&] { with_mesh(members); });
    }
    ScratchDirectory folder_;
    Registry registry_ = Registry::load();
};

// ---- JSON -----------------------------------------------------------------------------------------------------

TEST(JsonTree, ValuesKnowTheirLines) {
    const JsonValue root =
        parse_json("{\n\"a\": 1,\n\"b\"\n:\n[true\n,2\n,-3.5e1\n, null], \"c\": {\"d\":\n\"x\\ny\"}\n}\n", "a.json");
    EXPECT_EQ(root.line, 1U);
    EXPECT_EQ(root.find("a")->line, 2U);
    const JsonValue& b = *root.find("b");
    EXPECT_EQ(b.line, 5U);
    ASSERT_EQ(b.items.size(), 4U);
    EXPECT_EQ(b.items[0].line, 5U);
    EXPECT_TRUE(b.items[0].truth);
    EXPECT_EQ(b.items[1].line, 6U);
    EXPECT_EQ(b.items[1].number, 2.0);
    EXPECT_EQ(b.items[2].line, 7U);
    EXPECT_EQ(b.items[2].number, -35.0);
    EXPECT_EQ(b.items[3].line, 8U);
    EXPECT_EQ(b.items[3].kind, JsonValue::Kind::null);
    EXPECT_EQ(root.find("c")->line, 8U);
    EXPECT_EQ(root.find("c")->find("d")->line, 9U);
    EXPECT_EQ(root.find("c")->find("d")->text, "x\ny");
    EXPECT_EQ(root.find("e"), nullptr);
}

TEST(JsonTree, RefusesWhatIsNoJson) {
    const auto refusal = [](const std::string& text) -> std::string {
        try {
            parse_json(text, "a.json");
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_THAT(refusal("{\n\"a\": 1,\n}"), AllOf(HasSubstr("a.json:3: "), HasSubstr("this is not JSON")));
    EXPECT_THAT(refusal(""), HasSubstr("a.json:1: "));
    EXPECT_THAT(refusal("{} {}"), HasSubstr("a.json:1: "));
    EXPECT_THAT(refusal("[1, nan]"), HasSubstr("not JSON"));
    EXPECT_THAT(refusal("[1,\n1e999,\n2]"), AllOf(HasSubstr("a.json:2: '1e999' is too large a number"),
                                                  Not(HasSubstr("exception")), Not(HasSubstr("not JSON"))));
    EXPECT_THAT(refusal("-1e400"), HasSubstr("a.json:1: '-1e400' is too large a number"));
    EXPECT_THAT(refusal("{\"a\": 1,\n\"b\": 2,\n\"a\": 3}"),
                AllOf(HasSubstr("a.json:3: 'a' stands twice"), HasSubstr("line 1")));
    EXPECT_EQ(refusal(std::string(64, '[') + std::string(64, ']')), "");
    EXPECT_THAT(refusal(std::string(65, '[') + std::string(65, ']')), HasSubstr("nested"));
    EXPECT_THAT(refusal(std::string(1000000, '[')), HasSubstr("nested"));
}

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
                AllOf(HasSubstr("bad.off:6: face 0 (line 6) names point 3"), HasSubstr("3 points")));
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
                HasSubstr("faces from 0 to 4, the last one not included"));
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

TEST_F(SceneFile, Lights) {
    const PolygonSoup soup = with(
        "\"unit\": \"cm\", \"lights\": [{\"type\": \"sun\", \"towards\": [0, 3, 4], \"irradiance\": 5}, {\"type\": "
        "\"point\", \"name\": \"p\", \"position\": [100, 200, 300], \"power\": [4, 8, 12]}, {\"type\": \"spot\", "
        "\"position\": [0, 0, 200], \"look_at\": [0, 0, 0], \"intensity\": 7, \"outer_degrees\": 60}, {\"type\": "
        "\"spot\", \"position\": [0, 0, 0], \"direction\": [2, 0, 0], \"intensity\": 7, \"inner_degrees\": 30, "
        "\"outer_degrees\": 30}]");
    ASSERT_EQ(soup.lights.suns.size(), 1U);
    EXPECT_LT((soup.lights.suns[0].towards - Vec3(0, 0.6, 0.8)).norm(), 1e-15);
    EXPECT_TRUE((soup.lights.suns[0].irradiance == 5.0).all());
    ASSERT_EQ(soup.lights.points.size(), 3U);
    const PointLight &point = soup.lights.points[0], &spot = soup.lights.points[1];
    EXPECT_EQ(point.name, "p");
    EXPECT_EQ(point.position, Vec3(1, 2, 3));
    EXPECT_FALSE(point.is_spot());
    // Intensity in all directions adds up to the power.
    EXPECT_NEAR(point.intensity[2] * 4.0 * std::numbers::pi, 12.0, 1e-14);
    EXPECT_EQ(spot.position, Vec3(0, 0, 2));
    EXPECT_EQ(spot.direction, Vec3(0, 0, -1));
    EXPECT_EQ(spot.falloff(Vec3(0, 0, -1)), 1.0);
    EXPECT_NEAR(spot.falloff(Vec3(std::sin(1.0), 0, -std::cos(1.0))), std::pow((std::cos(1.0) - 0.5) / 0.5, 2), 1e-14);
    EXPECT_EQ(soup.lights.points[2].direction, Vec3(1, 0, 0));
    EXPECT_EQ(soup.lights.points[2].cos_inner, soup.lights.points[2].cos_outer);
}

TEST_F(SceneFile, Skies) {
    EXPECT_TRUE(
        (*with("\"sky\": {\"type\": \"uniform\", \"irradiance\": [1, 2, 3]}").lights.sky == Rgb(1, 2, 3)).all());
    const PolygonSoup gradient =
        with("\"up\": \"y\", \"sky\": {\"type\": \"gradient\", \"zenith\": 4, \"horizon\": 2, \"ground\": 1}");
    ASSERT_TRUE(gradient.lights.dome);
    EXPECT_EQ(gradient.lights.dome->radiance(Vec3(0, 1, 0))[0], 4.0);
    EXPECT_EQ(gradient.lights.dome->radiance(Vec3(0.8, 0.6, 0))[0], 2.0 + 0.6 * 2.0);
    EXPECT_EQ(gradient.lights.dome->radiance(Vec3(0, -1, 0))[0], 1.0);
}

/// 64 by 32 pixels of radiance 1, and one of 256 in the row and column given (-1: none).
std::string bright_spot(int row, int column) {
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n";
    for (int r = 0; r < 32; ++r) {
        for (int c = 0; c < 64; ++c) {
            hdr += std::string("\x80\x80\x80", 3) + (r == row && c == column ? '\x89' : '\x81');
        }
    }
    return hdr;
}

TEST_F(SceneFile, ASkysBrightSpotsBecomeSuns) {
    write("sky.hdr", bright_spot(10, 40));
    const PolygonSoup soup = with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"scale\": 2}");
    ASSERT_EQ(soup.lights.suns.size(), 1U);
    ASSERT_TRUE(soup.lights.dome);
    const Sun& sun = soup.lights.suns[0];
    EXPECT_EQ(sun.name, "sky");
    EXPECT_TRUE(sun.of_sky);
    EXPECT_THAT(soup.notes, testing::ElementsAre(HasSubstr("its brightest spots count as suns: 1")));
    // The middle column lies towards y, the next ones to the right of it, x.
    const double polar = 10.5 / 32.0 * std::numbers::pi, azimuth = (40.5 / 64.0 - 0.5) * 2.0 * std::numbers::pi;
    EXPECT_LT(
        (sun.towards - Vec3(std::sin(polar) * std::sin(azimuth), std::sin(polar) * std::cos(azimuth), std::cos(polar)))
            .norm(),
        1e-12);
    // What the sun has and what is left add up to the image: 512 times the solid angle of the pixel.
    const double step = std::numbers::pi / 32.0;
    const double size = 2.0 * std::numbers::pi / 64.0 * (std::cos(10 * step) - std::cos(11 * step));
    const double left = soup.lights.dome->radiance(sun.towards)[0];
    EXPECT_NEAR(sun.irradiance[0] + left * size, 512.0 * size, 1e-6 * 512.0 * size);
    // Ten times the mean of the sphere is left: 2 everywhere and 510 more in the pixel.
    EXPECT_NEAR(left, 10.0 * (2.0 + 510.0 * size / (4.0 * std::numbers::pi)), 1e-5);

    const PolygonSoup whole =
        with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"split_suns\": false, \"ahead\": "
             "[1, 0, 5]}");
    EXPECT_THAT(whole.lights.suns, IsEmpty());
    EXPECT_NEAR(whole.lights.dome->radiance(Vec3(std::sin(polar) * std::cos(azimuth),
                                                 -std::sin(polar) * std::sin(azimuth), std::cos(polar)))[0],
                256.0, 1e-9);
}

TEST_F(SceneFile, BrightSpotsTooWideForSunsAreNoted) {
    // A pixel here is 0.0095 sr wide at the horizon: two of them are no sun.
    std::string hdr = bright_spot(15, 40);
    hdr[hdr.size() - 4U * (32 * 64 - 15 * 64 - 41) + 3] = '\x89';
    write("sky.hdr", hdr);
    const PolygonSoup soup = with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\"}");
    EXPECT_THAT(soup.lights.suns, IsEmpty());
    EXPECT_THAT(soup.notes, testing::ElementsAre(HasSubstr("sr stay more than 20 times as bright as its mean")));
    EXPECT_THAT(with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"split_suns\": false}").notes, IsEmpty());
}

TEST_F(SceneFile, ASkyOfManySpotsDoesNotBecomeManySuns) {
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n";
    for (int r = 0; r < 32; ++r) {
        for (int c = 0; c < 64; ++c) {
            hdr += std::string("\x80\x80\x80", 3) +
                   (r % 4 == 1 && c % 16 == 3 ? static_cast<char>(0x88 + (r == 13 ? c / 16 : 0)) : '\x78');
        }
    }
    write("sky.hdr", hdr);
    const PolygonSoup soup = with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\"}");
    EXPECT_GE(soup.lights.suns.size(), 1U);
    EXPECT_LE(soup.lights.suns.size(), 16U);
}

TEST_F(SceneFile, Cameras) {
    const PolygonSoup soup =
        with("\"unit\": 2, \"up\": [0, 2, 0], \"camera\": {\"eye\": [1, 2, 3], \"look_at\": [1, 2, 0], "
             "\"view_degrees\": 60}");
    ASSERT_TRUE(soup.camera);
    EXPECT_EQ(soup.camera->eye, Vec3(2, 4, 6));
    EXPECT_EQ(soup.camera->towards, Vec3(0, 0, -1));
    EXPECT_EQ(soup.camera->up, Vec3(0, 1, 0));
    EXPECT_NEAR(soup.camera->view_angle, std::numbers::pi / 3.0, 1e-15);
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1], \"look_at\": [0, 0, 0]}"), HasSubstr("straight along"));
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1]}"), HasSubstr("either \"towards\" or \"look_at\""));
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1], \"look_at\": [0, 0, 1]}"), HasSubstr("from where"));
}

// ---- what is refused ------------------------------------------------------------------------------------------

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
    EXPECT_THAT(refused("{\"scene\": 1}"), HasSubstr("no scene of difusa"));
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
    EXPECT_THAT(refused_with("\"materials\": {\"a\": {\"emission_texture\": \"x.png\"}}"), HasSubstr("\"emission\""));
    EXPECT_THAT(refused_with("\"materials\": {\"a\":\n\n{\"reflectance_texture\": \"x.png\"}}"),
                AllOf(HasSubstr("scene.json:5: "), HasSubstr("x.png: cannot be opened")));
    EXPECT_THAT(refused_with("\"defaults\": {\"reflectance\": 2}"), HasSubstr("from 0 (none) to 1"));
    EXPECT_THAT(refused_with("\"unit\": 0"), HasSubstr("above 0"));
    EXPECT_THAT(refused_with("\"up\": [0, 0, 0]"), HasSubstr("no direction"));
    EXPECT_THAT(refused_with("\"up\": [0, 0]"), HasSubstr("a list of 3 numbers, not a list of 2"));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"sun\", \"towards\": [0, 0, 1], \"irradiance\": -1}]"),
                HasSubstr("\"irradiance\" must be from 0"));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"sun\", \"irradiance\": 1}]"), HasSubstr("needs \"towards\""));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"point\", \"position\": [0, 0, 0]}]"),
                HasSubstr("needs either"));
    EXPECT_THAT(
        refused_with("\"lights\": [{\"type\": \"point\", \"position\": [0, 0, 0], \"power\": 1, \"intensity\": 1}]"),
        AllOf(HasSubstr("only one may be given"), Not(HasSubstr("needs"))));
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1], \"look_at\": [1, 0, 0], \"towards\": [1, 0, 0]}"),
                AllOf(HasSubstr("\"towards\" and \"look_at\""), HasSubstr("only one may be given")));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"spot\", \"position\": [0, 0, 0], \"direction\": [1, 0, 0], "
                             "\"intensity\": 1, \"inner_degrees\": 40, \"outer_degrees\": 30}]"),
                HasSubstr("not 40 and 30"));
    EXPECT_THAT(refused_with("\"sky\": {\"type\": \"image\", \"file\": \"square.off\"}"), HasSubstr("no picture"));
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
    EXPECT_THAT(refused("{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"scene.json\"}]}"), HasSubstr("another one"));
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

// ---- bakes ----------------------------------------------------------------------------------------------------

BakeOptions coarse() {
    BakeOptions options;
    options.sites = 60;
    options.rays = 32;
    options.error_points = 0;
    return options;
}

void expect_same_bake(const BakeResult& a, const BakeResult& b, double tolerance) {
    ASSERT_EQ(a.output.H.rows(), b.output.H.rows());
    const double scale = b.output.H.cwiseAbs().maxCoeff();
    EXPECT_GT(scale, 0.0);
    EXPECT_LE((a.output.H - b.output.H).cwiseAbs().maxCoeff(), tolerance * scale);
    EXPECT_LE((a.output.B - b.output.B).cwiseAbs().maxCoeff(), tolerance * scale);
}

/// An open box of 2 by 2 by 1 above z = 0; faces of materials m0 to m4, all on one set of texture coordinates each.
std::string box_obj(const std::string (&texture_index_of)[5]) {
    std::string text = "mtllib box.mtl\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 1\nv 2 0 1\nv 2 2 1\nv 0 2 1\n";
    for (int i = 0; i < 2; ++i) { // the centres of 2 by 2 pixels
        for (int j = 0; j < 2; ++j) {
            text += "vt " + std::to_string(0.25 + 0.5 * i) + " " + std::to_string(0.25 + 0.5 * j) + "\n";
        }
    }
    const int faces[5][4] = {{1, 2, 3, 4}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 8, 4}, {4, 8, 5, 1}};
    for (int f = 0; f < 5; ++f) {
        text += "usemtl m" + std::to_string(f) + "\nf";
        for (const int corner : faces[f]) {
            text += " " + std::to_string(corner) + texture_index_of[f];
        }
        text += "\n";
    }
    return text;
}

TEST_F(SceneFile, ATextureOfEvenPixelsIsAsManyColours) {
    // Pixels 1, 0 above 0, 1: powers of two, whose mixtures with themselves round to nothing else.
    std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\2\0\0\0\1\0\x18\0", 30);
    bmp += std::string(24, '\0') + std::string(3, '\0') + std::string(3, '\xff') + std::string(2, '\0') +
           std::string(3, '\xff') + std::string(3, '\0') + std::string(2, '\0');
    write("a.bmp", bmp);
    // Lower left, upper left, lower right, upper right.
    const double shown[4] = {0.0, 1.0, 1.0, 0.0};
    std::string with_texture, with_colours, textured[5], plain[5];
    for (int f = 0; f < 5; ++f) {
        const int pixel = f % 4;
        textured[f] = "/" + std::to_string(pixel + 1);
        const std::string name = "newmtl m" + std::to_string(f) + "\n";
        with_texture += name + "Kd 0.5\nmap_Kd a.bmp\n";
        with_colours += name + "Kd " + std::to_string(0.5 * shown[pixel]) + "\n";
    }
    const auto bake_it = [&](const std::string& mtl, const std::string& obj) {
        write("box.mtl", mtl);
        write("box.obj", obj);
        return bake(registry_, folder_ / "box.obj", coarse(), Execution{});
    };
    const BakeResult a = bake_it(with_texture, box_obj(textured)), b = bake_it(with_colours, box_obj(plain));
    for (Index t = 0; t < a.scene->mesh.triangles.size(); ++t) {
        for (const auto& [u, v] : {std::pair{0.0, 0.0}, std::pair{0.3, 0.6}, std::pair{0.1, 0.1}}) {
            EXPECT_NEAR(a.scene->reflectance(a.scene->mesh.at(t, u, v))[0],
                        b.scene->reflectance(b.scene->mesh.at(t, u, v))[0], 1e-15);
        }
    }
    // But for rounding: the mean reflectance of an element is a sum where there are textures.
    expect_same_bake(a, b, 1e-12);
}

TEST_F(SceneFile, ADoubleSidedSheetIsTwoFaces) {
    // A sheet between a lamp above and a floor below.
    const std::string points = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 1\nv 3 1 1\nv 3 3 1\nv 1 3 1\nv 0 0 2\nv 4 0 "
                               "2\nv 4 4 2\nv 0 4 2\n";
    const std::string floor_and_lamp = "usemtl grey\nf 1 2 3\nf 1 3 4\nusemtl lamp\nf 9 11 10\nf 9 12 11\n";
    write("a.mtl", "newmtl grey\nKd 0.5\nnewmtl lamp\nKd 0.5\nKe 1\nnewmtl sheet\nKd 0.5\n");
    write("one.obj", "mtllib a.mtl\n" + points + floor_and_lamp + "usemtl sheet\nf 5 6 7\nf 5 7 8\n");
    write("two.obj", "mtllib a.mtl\n" + points + floor_and_lamp + "usemtl sheet\nf 5 6 7\nf 5 7 8\nf 5 7 6\nf 5 8 7\n");
    write("one.json",
          "{\"difusa_scene\": 1, \"materials\": {\"both\": {\"reflectance\": 0.5, \"double_sided\": true}}, "
          "\"meshes\": [{\"file\": \"one.obj\", \"materials\": {\"sheet\": \"both\"}}]}");
    const BakeResult a = bake(registry_, folder_ / "one.json", coarse(), Execution{});
    const BakeResult b = bake(registry_, folder_ / "two.obj", coarse(), Execution{});
    EXPECT_EQ(a.scene->mesh.triangles, b.scene->mesh.triangles);
    expect_same_bake(a, b, 0.0);
    // The lamp lights the upper side; the lower one has what the floor sends alone.
    const Mesh& mesh = a.scene->mesh;
    double upper = 0.0, lower = 0.0;
    for (std::size_t i = 0; i < a.sites->size(); ++i) {
        const SurfacePoint& x = a.sites->points[i];
        const bool sheet = mesh.original_face[x.face] >= 4;
        upper += sheet && x.normal.z() > 0.0 ? a.irradiance_direct(static_cast<Eigen::Index>(i), 0) : 0.0;
        lower += sheet && x.normal.z() < 0.0 ? a.irradiance_direct(static_cast<Eigen::Index>(i), 0) : 0.0;
    }
    EXPECT_GT(upper, 0.0);
    EXPECT_EQ(lower, 0.0);
}

TEST_F(SceneFile, TheDocumentedExampleIsBaked) {
    std::ifstream stream(DIFUSA_TEST_DATA "/SCENE_FORMAT.md");
    const std::string text((std::istreambuf_iterator<char>(stream)), {});
    const std::size_t begin = text.find("```json\n");
    ASSERT_NE(begin, std::string::npos);
    const std::string example = text.substr(begin + 8, text.find("```", begin + 8) - begin - 8);
    write("poster.bmp", black_and_white());
    write("room.mtl", "newmtl paint\nKd 0.1\nnewmtl floor\nKd 0.3\n");
    write("room.obj", "mtllib room.mtl\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 3\nv 0 4 3\nusemtl floor\nf 1 2 3 "
                      "4\nusemtl paint\nf 1 4 6 5\n");
    write("chair.off",
          "OFF\n8 3 0\n0 0 40\n40 0 40\n40 40 40\n0 40 40\n0 0 0\n40 0 0\n40 40 0\n0 40 0\n4 0 1 2 3\n4 0 3 2 "
          "1\n4 5 1 0 4\n");
    write("scene.json", example);
    const BakeResult result = bake(registry_, folder_ / "scene.json", coarse(), Execution{});
    EXPECT_EQ(result.scene->suns.size(), 1U);
    EXPECT_EQ(result.scene->point_lights.size(), 2U);
    EXPECT_TRUE(result.scene->dome && result.camera);
    EXPECT_GT(result.output.H.maxCoeff(), 0.0);
    // The seat: 40 cm wide, 1.25 times, turned by 90 degrees, at (1, 2).
    const Mesh& mesh = result.scene->mesh;
    bool found = false;
    for (const Vec3& p : mesh.points) {
        found = found || (p - Vec3(0.5, 2.5, 0.5)).norm() < 1e-14;
    }
    EXPECT_TRUE(found);
    const nlohmann::json report = nlohmann::json::parse(report_of(result));
    const nlohmann::json& parts = report["input"]["parts"];
    ASSERT_EQ(parts.size(), 2U);
    EXPECT_EQ(parts[1]["file"], (folder_ / "chair.off").string());
    EXPECT_EQ(parts[1]["first_face"], 2);
    EXPECT_EQ(parts[1]["faces"], 3);
}

} // namespace
} // namespace difusa
