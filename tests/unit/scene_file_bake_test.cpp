// Bakes of scene files.
#include <difusa/bake.h>
#include <difusa/output/bake_files.h>

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <fstream>

#include "scene_file_fixture.h"

namespace difusa::scene_file_bake_test {
namespace {

using test::black_and_white;
using test::SceneFile;

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

TEST_F(SceneFile, AFaceBehindASymmetryPlaneIsNamed) {
    const auto bake_with = [&](const std::string& x) {
        write("scene.json",
              "{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"square.off\"}], \"symmetry\": [{\"point\": [" + x +
                  ", 0, 0], \"normal\": [1, 0, 0]}]}");
        return bake(registry_, folder_ / "scene.json", coarse(), Execution{});
    };
    EXPECT_NO_THROW(bake_with("0"));
    const std::string message = refusal([&] { bake_with("0.25"); });
    for (const char* part : {"scene.json: face 0 (line 7) of ", "square.off reaches (0, 0, 0), 0.25 m behind symmetry "
                                                                "plane 1, through (0.25, 0, 0)"}) {
        EXPECT_NE(message.find(part), std::string::npos) << message;
    }
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
        upper += sheet && x.normal.z() > 0.0 ? a.solution.direct(static_cast<Eigen::Index>(i), 0) : 0.0;
        lower += sheet && x.normal.z() < 0.0 ? a.solution.direct(static_cast<Eigen::Index>(i), 0) : 0.0;
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
} // namespace difusa::scene_file_bake_test
