// The reader `gltf` on scenes put together here, byte for byte, and on damaged ones.
#include <readers.h>

#include <difusa/import/scene_file.h>
#include <difusa/repair/diagnosis.h>

#include <cmath>
#include <fstream>

#include "gltf_text.h"
#include "scratch_directory.h"

namespace difusa::gltf_test {
namespace {

using readers::Bytes;
using readers::notes;
using readers::refusal;
using test::ScratchDirectory;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using namespace gltf_text;

TEST(GltfReader, ReadsAMeshWithItsMaterial) {
    const PolygonSoup soup = gltf(scene("{\"mesh\":0}"));
    readers::expect_sound(soup);
    ASSERT_EQ(soup.points.size(), 4U);
    EXPECT_EQ(soup.points[2], Vec3(1, 1, 0));
    ASSERT_EQ(soup.face_count(), 2U);
    EXPECT_THAT(soup.face(1), ElementsAre(0, 2, 3));
    EXPECT_THAT(soup.face_material, ElementsAre(0, 0));
    EXPECT_EQ(soup.materials[0].name, "paint");
    EXPECT_TRUE((soup.materials[0].reflectance == Rgb(0.5, 0.25, 0.125)).all());
    EXPECT_TRUE((soup.materials[0].emission == 0.0).all());
    ASSERT_EQ(soup.corner_texture.size(), 6U);
    EXPECT_EQ(soup.corner_texture[0], TextureCoordinates(0, 0)) << "v runs downwards in glTF";
    EXPECT_EQ(soup.corner_texture[5], TextureCoordinates(0, 0.75));
    EXPECT_THAT(soup.notes, IsEmpty());
    EXPECT_TRUE(soup.point_reflectance.empty());
    EXPECT_FALSE(soup.camera);
}

TEST(GltfReader, BinaryFilesAndBuffersBesideThem) {
    const PolygonSoup text = gltf(scene("{\"mesh\":0}"));
    const auto with_buffer = [](const std::string& uri) {
        return file("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{"
                    "\"baseColorFactor\":[0.5,0.25,0.125,1],\"metallicFactor\":0}}]," +
                    square_mesh + "," + square().members(uri));
    };
    std::string json = with_buffer(""), data = square().data();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    data.resize((data.size() + 3) / 4 * 4, '\0');
    const auto glb = [](std::uint32_t version, const std::string& a, const std::string& b) {
        return Bytes(std::endian::little, "glTF")
                   .add<std::uint32_t>({version, static_cast<std::uint32_t>(28 + a.size() + b.size()),
                                        static_cast<std::uint32_t>(a.size()), 0x4e4f534a})
                   .content() +
               a +
               Bytes(std::endian::little)
                   .add<std::uint32_t>({static_cast<std::uint32_t>(b.size()), 0x004e4942})
                   .content() +
               b;
    };
    const std::string binary = glb(2, json, data);
    readers::expect_equal(readers::parse("gltf", binary), text);
    EXPECT_THAT(refusal("gltf", glb(1, json, data)), HasSubstr("version 1"));
    for (std::size_t length = 4; length < binary.size(); ++length) {
        EXPECT_THAT(refusal("gltf", binary.substr(0, length)), HasSubstr("test.gltf")) << length;
    }
    ScratchDirectory folder;
    std::ofstream(folder / "scene.gltf") << with_buffer(",\"uri\":\"my%20buffer.bin\"");
    EXPECT_THROW(readers::reader("gltf")->read(folder / "scene.gltf"), InputError);
    std::ofstream(folder / "my buffer.bin", std::ios::binary) << data;
    readers::expect_equal(readers::reader("gltf")->read(folder / "scene.gltf"), text);
    std::ofstream(folder / "my buffer.bin", std::ios::binary) << data.substr(0, 40);
    EXPECT_THROW(readers::reader("gltf")->read(folder / "scene.gltf"), InputError);
}

TEST(GltfReader, PlacesNodesBelowOneAnother) {
    // Turned by 90 degrees about z, twice as long, moved by (1, 2, 3); then moved by (0, 0, 10).
    const std::string turn = std::to_string(std::sqrt(0.5));
    const PolygonSoup soup = gltf(
        scene("{\"children\":[1,2],\"translation\":[0,0,10]},{\"mesh\":0,\"translation\":[1,2,3],"
              "\"rotation\":[0,0," +
              turn + "," + turn + "],\"scale\":[2,2,2]},{\"mesh\":0,\"matrix\":[0,2,0,0, 3,0,0,0, 0,0,1,0, 5,6,7,1]}"));
    ASSERT_EQ(soup.points.size(), 8U);
    EXPECT_LT((soup.points[1] - Vec3(1, 4, 13)).norm(), 1e-14);
    EXPECT_LT((soup.points[2] - Vec3(-1, 4, 13)).norm(), 1e-14);
    EXPECT_THAT(soup.face(0), ElementsAre(0, 1, 2));
    // The matrix is written column by column, and mirrors: the front stays in front.
    EXPECT_EQ(soup.points[4 + 2], Vec3(5 + 0, 6 + 2, 17)) << "turned over, the face names (1, 0, 0) last";
}

TEST(GltfReader, MirroredNodesKeepTheirFronts) {
    const PolygonSoup soup = gltf(scene("{\"mesh\":0,\"scale\":[-1,1,1]}"));
    const Vec3 a = soup.points[soup.face(0)[0]], b = soup.points[soup.face(0)[1]], c = soup.points[soup.face(0)[2]];
    EXPECT_EQ((b - a).cross(c - a), Vec3(0, 0, 1));
    EXPECT_EQ(soup.corner_texture[1], TextureCoordinates(1, 1)) << "coordinates go with their corners";
}

TEST(GltfReader, NodesAreATree) {
    EXPECT_THAT(refused(scene("{\"children\":[0]}")), HasSubstr("two parents, or is its own"));
    EXPECT_THAT(refused(scene("{\"children\":[1,2]},{\"children\":[2]},{}")), HasSubstr("node 2 has two parents"));
    EXPECT_THAT(refused(scene("{\"children\":[1]},{\"children\":[0]}")), HasSubstr("node 0"));
    EXPECT_THAT(refused(scene("{\"children\":[7]}")), HasSubstr("entry 7 of \"nodes\" is requested, which has 1"));
    // Ten thousand nodes below one another: no recursion.
    std::string chain;
    for (int n = 1; n < 10000; ++n) {
        chain += "{\"children\":[" + std::to_string(n) + "],\"translation\":[0,0,1]},";
    }
    EXPECT_EQ(gltf(scene(chain + "{\"mesh\":0}")).points[0], Vec3(0, 0, 9999));
}

TEST(GltfReader, OneSceneIsRead) {
    const std::string arrays = square().embedded() + "," + square_mesh + ",\"materials\":[{}]";
    const std::string nodes = "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[5,0,0]}],";
    EXPECT_EQ(gltf(nodes + arrays).face_count(), 4U) << "without scenes: all roots";
    const PolygonSoup second = gltf(nodes + "\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1]}],\"scene\":1," + arrays);
    EXPECT_EQ(second.points[0], Vec3(5, 0, 0));
    EXPECT_THAT(notes(second), HasSubstr("2 scenes, of which one is read"));
    EXPECT_EQ(gltf(nodes + "\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1]}]," + arrays).points[0], Vec3(0, 0, 0));
    EXPECT_EQ(gltf("\"scenes\":[{}]").face_count(), 0U);
}

TEST(GltfReader, StripsFansAndBarePoints) {
    Arrays arrays;
    arrays.add<float>("VEC3", 5126, 5, {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    const auto faces = [&](int mode, const std::string& more = {}) {
        const PolygonSoup soup =
            gltf("\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":" +
                 std::to_string(mode) + more + "}]}]," + arrays.embedded());
        EXPECT_THAT(soup.face_material, testing::Each(none));
        // By the coordinates: vertices are numbered as they come.
        std::string text;
        for (std::size_t f = 0; f < soup.face_count(); ++f) {
            for (const Index p : soup.face(f)) {
                text += std::to_string(static_cast<int>(soup.points[p].x() + 2 * soup.points[p].y()));
            }
            text += " ";
        }
        return text + notes(soup);
    };
    const std::string plain = "primitives without a material: 1 (mesh 0); their faces have the default reflectance "
                              "(--reflectance); give them a material\n";
    EXPECT_EQ(faces(4), "012 " + plain +
                            "leftover vertices that form no triangle: 2 (mesh 0); they are ignored; "
                            "export the mesh again\n");
    EXPECT_EQ(faces(5), "012 132 234 " + plain) << "every other triangle is turned";
    EXPECT_EQ(faces(6), "120 230 340 " + plain);
    EXPECT_THAT(faces(1), HasSubstr("primitives of points or lines: 1"));
    arrays.add<std::uint8_t>("SCALAR", 5121, 7, {0, 1, 2, 2, 3, 3, 4});
    EXPECT_EQ(faces(5, ",\"indices\":1"), "012 " + plain) << "joined strips: triangles without area are left out";
}

TEST(GltfReader, PrimitivesTakeTheVerticesTheyName) {
    Arrays arrays;
    arrays.add<float>("VEC3", 5126, 5, {9, 9, 9, 1, 0, 0, 0, 1, 0, 1, 1, 0, 9, 9, 9});
    arrays.add<std::uint32_t>("SCALAR", 5125, 3, {3, 1, 2});
    const PolygonSoup soup =
        gltf("\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
             "\"indices\":1}]}]," +
             arrays.embedded());
    ASSERT_EQ(soup.points.size(), 3U);
    EXPECT_THAT(soup.face(0), ElementsAre(0, 1, 2));
    EXPECT_EQ(soup.points[0], Vec3(1, 1, 0));
}

TEST(GltfReader, SparseAndInterleavedAndNormalizedArrays) {
    // Positions of zeros, two of which are replaced; texture coordinates as bytes that stand for 0 to 1, 4 bytes apart.
    Arrays arrays;
    arrays.add<std::uint8_t>("SCALAR", 5121, 2, {1, 2});
    arrays.add<float>("VEC3", 5126, 2, {1, 0, 0, 0, 1, 0});
    arrays.add<std::uint8_t>("VEC2", 5121, 3, {0, 255, 9, 9, 51, 0, 9, 9, 255, 102}, ",\"normalized\":true");
    std::string members = arrays.embedded();
    const auto replace = [&](const std::string& from, const std::string& to) {
        ASSERT_NE(members.find(from), std::string::npos) << from;
        members.replace(members.find(from), from.size(), to);
    };
    replace("\"byteLength\":10}", "\"byteLength\":10,\"byteStride\":4}");
    replace("\"accessors\":[",
            "\"accessors\":[{\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"sparse\":{\"count\":2,\"indices\":{"
            "\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":1}}},");
    const std::string head = "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                             "\"TEXCOORD_0\":3}}]}],";
    const PolygonSoup soup = gltf(head + members);
    ASSERT_EQ(soup.points.size(), 3U);
    EXPECT_EQ(soup.points[0], Vec3(0, 0, 0));
    EXPECT_EQ(soup.points[1], Vec3(1, 0, 0));
    EXPECT_EQ(soup.points[2], Vec3(0, 1, 0));
    EXPECT_EQ(soup.corner_texture[0], TextureCoordinates(0, 0));
    EXPECT_EQ(soup.corner_texture[1], TextureCoordinates(0.2, 1));
    EXPECT_EQ(soup.corner_texture[2], TextureCoordinates(1, 1.0 - 0.4));
    replace("\"count\":3,\"sparse\"", "\"count\":2,\"sparse\"");
    EXPECT_THAT(refused(head + members), HasSubstr("must ascend and be in range"));
    replace("\"count\":2,\"sparse\":{\"count\":2", "\"count\":2,\"sparse\":{\"count\":200");
    EXPECT_THAT(refused(head + members), HasSubstr("not within its buffer view"));
}

TEST(GltfReader, SaysWhyThereAreNoFaces) {
    const PolygonSoup soup =
        gltf("\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
             "\"mode\":1},{\"attributes\":{}}]}]," +
             square().embedded());
    try {
        diagnose(soup);
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(),
                    AllOf(HasSubstr("has no faces"), HasSubstr("primitives of points or lines: 1 (mesh 0)"),
                          HasSubstr("primitives without positions: 1 (mesh 0)")));
    }
}

TEST(GltfReader, RefusesWhatItCannotDoWithout) {
    for (const char* known : {"KHR_materials_clearcoat", "KHR_materials_ior", "KHR_materials_emissive_strength",
                              "KHR_texture_transform", "KHR_mesh_quantization"}) {
        EXPECT_EQ(gltf("\"extensionsRequired\":[\"" + std::string(known) + "\"]").face_count(), 0U);
    }
    for (const char* other : {"KHR_materials_madeup", "KHR_materials_transmission", "KHR_materials_"}) {
        EXPECT_THAT(refused("\"extensionsRequired\":[\"" + std::string(other) + "\"]"),
                    AllOf(HasSubstr(other), HasSubstr("export opaque metallic-roughness materials only")));
    }
    EXPECT_THAT(refused("\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"),
                AllOf(HasSubstr("test.gltf:2: "), HasSubstr("without mesh compression")));
    EXPECT_THAT(refused("\"extensionsRequired\":[\"EXT_meshopt_compression\"]"), HasSubstr("without mesh compression"));
    EXPECT_THAT(refused("\"extensionsRequired\":[\"KHR_texture_basisu\"]"), HasSubstr("PNG or JPEG"));
    EXPECT_THAT(refused("\"extensionsRequired\":[\"VENDOR_x\"]"), HasSubstr("'VENDOR_x'"));
    EXPECT_THAT(refusal("gltf", "{\"asset\":{\"version\":\"1.0\"}}"), HasSubstr("version 1.0"));
    EXPECT_THAT(refusal("gltf", "{}"), HasSubstr("needs \"asset\""));
    EXPECT_THAT(refusal("gltf", "v 0 0 0\n"), HasSubstr("not JSON"));
}

TEST(GltfReader, RefusesArraysThatAreNotThere) {
    const auto with = [](const std::string& from, const std::string& to) {
        std::string members = scene("{\"mesh\":0}");
        EXPECT_NE(members.find(from), std::string::npos) << from;
        members.replace(members.find(from), from.size(), to);
        return refused(members);
    };
    EXPECT_THAT(with("\"count\":4", "\"count\":5"), HasSubstr("accessor 0 (POSITION) is not within its buffer view"));
    EXPECT_THAT(with("\"count\":4", "\"count\":400000000000"), HasSubstr("too many vectors"));
    EXPECT_THAT(with("\"count\":4", "\"count\":-4"), HasSubstr("whole number, not -4"));
    EXPECT_THAT(with("\"count\":4", "\"count\":4,\"byteOffset\":9007199254740992"), HasSubstr("not within"));
    EXPECT_THAT(with("\"byteLength\":48", "\"byteLength\":9007199254740992"), HasSubstr("not within its buffer"));
    EXPECT_THAT(with("\"byteLength\":92", "\"byteLength\":93"), HasSubstr("should have 93 bytes, but has 92"));
    EXPECT_THAT(with("\"buffer\":0", "\"buffer\":1"), HasSubstr("entry 1 of \"buffers\""));
    EXPECT_THAT(with("\"VEC3\"", "\"VEC2\""), HasSubstr("must have 3 components"));
    EXPECT_THAT(with("5126", "5124"), HasSubstr("component type 5124"));
    EXPECT_THAT(with("5123", "5122"), HasSubstr("indices that are not unsigned"));
    EXPECT_THAT(with("\"bufferView\":0,", "\"bufferView\":0,\"bufferView\":0,"), HasSubstr("occurs twice"));
    EXPECT_THAT(with("\"bufferView\":2", "\"bufferView\":1"), HasSubstr("refers to vertex"));
    EXPECT_THAT(with("\"TEXCOORD_0\":1", "\"COLOR_0\":2"), HasSubstr("must have 3 components"));
    EXPECT_THAT(with("\"bufferView\":0,\"componentType\":5126,\"count\":4", "\"componentType\":5126,\"count\":4000000"),
                HasSubstr("without a buffer"));
    EXPECT_THAT(with("\"byteLength\":48", "\"byteStride\":0,\"byteLength\":48"), HasSubstr("from 4 to 252"));
    EXPECT_THAT(with("\"uri\":\"data:", "\"uri\":\"dota:"), HasSubstr("is missing"));
    EXPECT_THAT(with("\"material\":0", "\"material\":1"), HasSubstr("entry 1 of \"materials\""));
    EXPECT_THAT(with("\"mesh\":0", "\"mesh\":0.5"), HasSubstr("whole number"));
}

TEST(GltfReader, IsSafeOnFilesCutShort) {
    const std::string whole = file(scene("{\"mesh\":0}"));
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_THAT(refusal("gltf", whole.substr(0, length)), HasSubstr("test.gltf")) << length;
    }
}

/// Points, triangles and materials of a mesh, whatever their numbers were in the file.
std::string summary(const DiagnosedMesh& diagnosed, const PolygonSoup& soup) {
    const Mesh& mesh = diagnosed.mesh;
    std::ostringstream text;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const Index p : mesh.triangles[t]) {
            text << mesh.points[p].transpose() << "; ";
        }
        const Material& material = soup.materials[mesh.material[t]];
        text << material.name << " " << material.reflectance.transpose() << " " << material.emission.transpose()
             << "\n";
    }
    for (const PointLight& light : soup.lights.points) {
        text << light.position.transpose() << " " << light.intensity.transpose() << "\n";
    }
    return text.str() + std::to_string(mesh.points.size()) + " points";
}

TEST(GltfReader, OneSceneInThreeFormats) {
    ScratchDirectory folder;
    const auto write = [&](const std::string& name, const std::string& text) {
        std::ofstream(folder / name, std::ios::binary) << text;
    };
    write(
        "a.gltf",
        file(scene("{\"mesh\":0,\"children\":[1]},{\"translation\":[1,2,3],\"extensions\":{"
                   "\"KHR_lights_punctual\":{\"light\":0}}}",
                   ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":683}]}}")));
    write("a.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
    const std::string light = "\"lights\": [{\"type\": \"point\", \"position\": [1, 2, 3], \"intensity\": 1}]";
    write("a.json",
          "{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"a.off\", \"material\": \"paint\"}], \"materials\": "
          "{\"paint\": {\"reflectance\": [0.5, 0.25, 0.125]}}, " +
              light + "}");
    write("a.mtl", "newmtl paint\nKd 0.5 0.25 0.125\n");
    write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl paint\nf 1 2 3\nf 1 3 4\n");
    write("b.json", "{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"a.obj\"}], " + light + "}");
    const Registry registry = Registry::load();
    const auto read = [&](const std::string& name) {
        const PolygonSoup soup = read_scene(registry, folder / name);
        return summary(diagnose(soup), soup);
    };
    EXPECT_EQ(read("a.json"), read("a.gltf"));
    EXPECT_EQ(read("b.json"), read("a.gltf"));
    // In a scene file a glTF brings its light along, and it is moved.
    write("c.json",
          "{\"difusa_scene\": 1, \"meshes\": [{\"file\": \"a.gltf\", \"transform\": {\"translate\": [0, 0, 1]}}]}");
    const PolygonSoup moved = read_scene(registry, folder / "c.json");
    EXPECT_EQ(moved.lights.points.at(0).position, Vec3(1, 2, 4));
}

} // namespace
} // namespace difusa::gltf_test
