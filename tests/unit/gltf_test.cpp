// The reader `gltf` on scenes put together here, byte for byte, and on damaged ones.
#include <readers.h>

#include <difusa/import/scene_file.h>
#include <difusa/repair/diagnosis.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "scratch_directory.h"

namespace {

using namespace difusa;
using readers::Bytes;
using readers::notes;
using readers::refusal;
using test::ScratchDirectory;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string base64(const std::string& bytes) {
    const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63U];
        }
    }
    return text;
}

/// Collects arrays as buffer views and accessors of one buffer.
class Arrays {
  public:
    /// Returns the number of the accessor. `more`: further members, beginning with a comma.
    template <class T>
    std::size_t add(const char* type, int component, std::size_t count, std::initializer_list<T> values,
                    const std::string& more = {}) {
        while (data_.size() % 4 != 0) {
            data_ += '\0';
        }
        const std::string bytes = Bytes(std::endian::little).add(values).content();
        views_ += (views_.empty() ? "" : ",") + std::string("{\"buffer\":0,\"byteOffset\":") +
                  std::to_string(data_.size()) + ",\"byteLength\":" + std::to_string(bytes.size()) + "}";
        accessors_ += (accessors_.empty() ? "" : ",") + std::string("{\"bufferView\":") + std::to_string(count_) +
                      ",\"componentType\":" + std::to_string(component) + ",\"count\":" + std::to_string(count) +
                      ",\"type\":\"" + type + "\"" + more + "}";
        data_ += bytes;
        return count_++;
    }
    const std::string& data() const { return data_; }
    std::string members(const std::string& uri) const {
        return "\"accessors\":[" + accessors_ + "],\"bufferViews\":[" + views_ +
               "],\"buffers\":[{\"byteLength\":" + std::to_string(data_.size()) + uri + "}]";
    }
    std::string embedded() const {
        return members(",\"uri\":\"data:application/octet-stream;base64," + base64(data_) + "\"");
    }

  private:
    std::string data_, views_, accessors_;
    std::size_t count_ = 0;
};

/// A whole file; `members` follow one another with commas.
std::string file(const std::string& members) {
    return "{\"asset\":{\"version\":\"2.0\"},\n" + members + "}";
}

PolygonSoup gltf(const std::string& members) {
    return readers::parse("gltf", file(members));
}

std::string refused(const std::string& members) {
    return refusal("gltf", file(members));
}

/// The unit square in z = 0, four vertices with texture coordinates, as indexed triangles: accessors 0, 1, 2.
Arrays square() {
    Arrays arrays;
    arrays.add<float>("VEC3", 5126, 4, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    arrays.add<float>("VEC2", 5126, 4, {0, 1, 1, 1, 1, 0, 0, 0.25F});
    arrays.add<std::uint16_t>("SCALAR", 5123, 6, {0, 1, 2, 0, 2, 3});
    return arrays;
}

const std::string square_mesh =
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"indices\":2,\"material\":0}]}]";

/// The square with these nodes and further members; material 0 is white paint.
std::string scene(const std::string& nodes, const std::string& more = {}) {
    return "\"scenes\":[{\"nodes\":[0]}],\"scene\":0,\"nodes\":[" + nodes +
           "],\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.125,1],"
           "\"metallicFactor\":0}}]," +
           square_mesh + "," + square().embedded() + more;
}

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
    EXPECT_THAT(refused(scene("{\"children\":[7]}")), HasSubstr("entry 7 of \"nodes\" is asked for, which has 1"));
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
                            "vertices left over that make no triangle: 2 (mesh 0); they are not read; "
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

TEST(GltfReader, ColoursOfVerticesAreFactors) {
    Arrays arrays = square();
    arrays.add<std::uint8_t>("VEC4", 5121, 4, {255, 0, 51, 255, 255, 255, 255, 0, 0, 0, 0, 0, 255, 255, 255, 255},
                             ",\"normalized\":true");
    const std::string mesh =
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":3},\"indices\":2,"
        "\"material\":0},{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":0},{"
        "\"attributes\":{\"POSITION\":0},\"indices\":2},{\"attributes\":{\"POSITION\":0,\"COLOR_0\":3},"
        "\"indices\":2}]}],";
    const PolygonSoup soup =
        gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.5,0.5,1],"
             "\"metallicFactor\":0.5}}]," +
             mesh + arrays.embedded());
    ASSERT_EQ(soup.point_reflectance.size(), 16U);
    EXPECT_TRUE((soup.point_reflectance[0] == Rgb(0.25, 0, 0.25 * 0.2)).all());
    EXPECT_TRUE((soup.point_reflectance[12] == Rgb(1, 0, 0.2)).all());
    EXPECT_TRUE(soup.painted(0));
    EXPECT_FALSE(soup.painted(2));
    EXPECT_EQ(soup.face_material[4], none);
    EXPECT_FALSE(soup.painted(4));
    EXPECT_TRUE(soup.painted(6));
}

TEST(GltfReader, MaterialsAndLight) {
    const PolygonSoup soup = gltf(
        "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"name\":\"lamp\",\"emissiveFactor\":[1,0.5,0],\"doubleSided\":true,"
        "\"alphaMode\":\"BLEND\",\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":683}},"
        "\"pbrMetallicRoughness\":{\"metallicFactor\":0.25}}]," +
        square_mesh + "," + square().embedded());
    const Material& lamp = soup.materials[0];
    EXPECT_TRUE(lamp.double_sided);
    EXPECT_TRUE((lamp.reflectance == 0.75).all());
    // A Lambertian surface of luminance 683 cd/m² sends pi 683 lm/m², which count as pi W/m².
    EXPECT_NEAR(lamp.emission[0], std::numbers::pi, 1e-14);
    EXPECT_NEAR(lamp.emission[1], 0.5 * std::numbers::pi, 1e-14);
    EXPECT_THAT(notes(soup), HasSubstr("materials that are not opaque: 1"));
    EXPECT_THAT(notes(gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{}]," + square_mesh + "," + square().embedded())),
                AllOf(HasSubstr("materials without \"metallicFactor\": 1 (\"material 0\"); glTF then means metal"),
                      HasSubstr("black here; for paint export \"metallicFactor\": 0")));
    EXPECT_THAT(notes(gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"name\":\"gold\",\"pbrMetallicRoughness\":{"
                           "\"metallicFactor\":1}}]," +
                           square_mesh + "," + square().embedded())),
                HasSubstr("materials of metal: 1 (\"gold\")"));
}

TEST(GltfReader, NotesNameMaterialsAndMeshesOnce) {
    const std::string material = "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"normalTexture\":{\"index\":0},"
                                 "\"extensions\":{\"KHR_materials_madeup\":{},\"KHR_materials_ior\":{}}";
    Arrays arrays = square();
    arrays.add<std::uint16_t>("SCALAR", 5123, 4, {0, 1, 2, 0});
    std::string materials, primitives;
    for (int m = 0; m < 7; ++m) {
        const std::string comma = m == 0 ? "" : ",";
        materials += comma + material + (m == 3 ? ",\"occlusionTexture\":{\"index\":0}}" : "}");
        primitives += comma + "{\"attributes\":{\"POSITION\":0},\"indices\":" + (m == 2 ? "3" : "2") +
                      ",\"material\":" + std::to_string(m) + "}";
    }
    const PolygonSoup soup = gltf("\"nodes\":[{\"mesh\":0},{\"mesh\":0}],\"materials\":[" + materials +
                                  "],\"meshes\":[{\"primitives\":[" + primitives + "]}]," + arrays.embedded());
    EXPECT_EQ(soup.face_count(), 2U * 13);
    const std::string first = " (\"material 0\", \"material 1\", \"material 2\", \"material 3\", \"material 4\", ...)";
    EXPECT_THAT(
        soup.notes,
        testing::UnorderedElementsAre(
            "materials with normal textures: 7" + first + "; they are not read: the shape is that of the triangles",
            "materials with occlusion textures: 1 (\"material 3\"); they are not read: shade is computed",
            "materials with KHR_materials_madeup: 7" + first + "; it is not read, the rest of them counts",
            "vertices left over that make no triangle: 1 (mesh 0); they are not read; export the mesh again"));
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

TEST(GltfReader, PunctualLights) {
    const std::string half = std::to_string(std::sqrt(0.5));
    const PolygonSoup soup = gltf(
        "\"extensionsRequired\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{"
        "\"type\":"
        "\"directional\",\"intensity\":683,\"color\":[1,0.5,0]},{\"type\":\"point\",\"intensity\":1366,\"name\":"
        "\"bulb\",\"range\":"
        "5},{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":0.5,\"outerConeAngle\":1}}]}},\"nodes\":[{\"extensions\":{"
        "\"KHR_lights_punctual\":{\"light\":0}},\"rotation\":[" +
        half + ",0,0," + half +
        "]},{\"translation\":[1,2,3],\"scale\":[2,2,2],\"children\":[2],\"extensions\":{\"KHR_lights_punctual\":{"
        "\"light\":1}}},"
        "{\"translation\":[1,0,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}}]");
    ASSERT_EQ(soup.lights.suns.size(), 1U);
    // Turned by 90 degrees about x, what shone along -z shines along y: the sun is in the direction of -y.
    EXPECT_LT((soup.lights.suns[0].towards - Vec3(0, -1, 0)).norm(), 1e-6);
    EXPECT_TRUE((soup.lights.suns[0].irradiance == Rgb(1, 0.5, 0)).all());
    ASSERT_EQ(soup.lights.points.size(), 2U);
    const PointLight &bulb = soup.lights.points[0], &spot = soup.lights.points[1];
    EXPECT_EQ(bulb.name, "bulb");
    EXPECT_EQ(bulb.position, Vec3(1, 2, 3));
    EXPECT_TRUE((bulb.intensity == 2.0).all());
    EXPECT_FALSE(bulb.is_spot());
    EXPECT_EQ(spot.position, Vec3(3, 2, 3));
    EXPECT_EQ(spot.direction, Vec3(0, 0, -1));
    EXPECT_EQ(spot.cos_inner, std::cos(0.5));
    EXPECT_EQ(spot.cos_outer, std::cos(1.0));
    EXPECT_THAT(notes(soup), HasSubstr("lights with a range: 1"));
}

TEST(GltfReader, LightsDoNotCareForScale) {
    const auto lights = [](const std::string& parent, const std::string& node, const std::string& type) {
        return "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"" + type +
               "\"}]}},\"nodes\":[{\"children\":[1]," + parent + "},{" + node +
               ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]";
    };
    const std::string half = std::to_string(std::sqrt(0.5)), move = "\"translation\":[1,2,3]";
    const std::string about_x = "\"rotation\":[" + half + ",0,0," + half + "]";
    const std::string about_y = "\"rotation\":[0," + half + ",0," + half + "]";
    const std::string zero = "\"scale\":[0,0,0]", no_matrix = "\"matrix\":[0,0,0,0, 0,0,0,0, 0,0,0,0, 1,2,3,1]";
    EXPECT_EQ(gltf(lights(move + "," + zero, zero, "point")).lights.points.at(0).position, Vec3(1, 2, 3));
    EXPECT_EQ(gltf(lights(zero, no_matrix, "point")).lights.points.at(0).position, Vec3(0, 0, 0));
    // About x by 90 degrees, what shone along -z shines along y; about y then, along y still, or -z along -x.
    EXPECT_LT(
        (gltf(lights(about_y + "," + zero, about_x, "spot")).lights.points.at(0).direction - Vec3(0, 1, 0)).norm(),
        1e-6);
    EXPECT_LT((gltf(lights(about_y, zero, "directional")).lights.suns.at(0).towards - Vec3(1, 0, 0)).norm(), 1e-6);
    // A matrix that loses z alone still has a normal; of a matrix of zeros nothing is left.
    const std::string flat = "\"matrix\":[0,3,0,0, 0,0,2,0, 0,0,0,0, 0,0,0,1]";
    EXPECT_LT((gltf(lights(move, flat, "spot")).lights.points.at(0).direction - Vec3(-1, 0, 0)).norm(), 1e-15);
    EXPECT_THAT(refused(lights(move, no_matrix, "spot")), HasSubstr("cannot be told"));
    EXPECT_THAT(refused(lights(no_matrix, about_x, "directional")), HasSubstr("cannot be told"));
}

TEST(GltfReader, TheFirstPerspectiveCamera) {
    const PolygonSoup soup =
        gltf("\"cameras\":[{\"type\":\"orthographic\",\"orthographic\":{}},{\"type\":\"perspective\",\"perspective\":{"
             "\"yfov\":"
             "0.75,\"znear\":0.1}}],\"nodes\":[{\"camera\":0},{\"camera\":1,\"translation\":[1,2,3]},{\"camera\":1}]");
    ASSERT_TRUE(soup.camera);
    EXPECT_EQ(soup.camera->eye, Vec3(1, 2, 3));
    EXPECT_EQ(soup.camera->towards, Vec3(0, 0, -1));
    EXPECT_EQ(soup.camera->up, Vec3(0, 1, 0));
    EXPECT_EQ(soup.camera->view_angle, 0.75);
    EXPECT_THAT(notes(soup), AllOf(HasSubstr("cameras without perspective: 1"), HasSubstr("further cameras: 1")));
}

/// A picture of 2 by 2 pixels as BMP (told by its bytes): upper row 0 and 1, lower row 1 and 1, in all channels, where
/// 1 is `bright` of 255.
std::string picture(char bright = '\xff') {
    std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\2\0\0\0\1\0\x18\0", 30);
    return bmp + std::string(24, '\0') + std::string(6, bright) + std::string(2, '\0') + std::string(3, '\0') +
           std::string(3, bright) + std::string(2, '\0');
}

TEST(GltfReader, TexturesAndTheirPlacement) {
    const auto read = [](const std::string& info, const std::string& sampler) {
        return gltf("\"nodes\":[{\"mesh\":0}],\"images\":[{\"uri\":\"data:image/png;base64," + base64(picture()) +
                    "\"}],\"samplers\":[{" + sampler +
                    "}],\"textures\":[{\"source\":0,\"sampler\":0}],\"materials\":[{\"pbrMetallicRoughness\":{"
                    "\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0" +
                    info + "}},\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0" + info + "}}]," +
                    square_mesh + "," + square().embedded());
    };
    const PolygonSoup plain = read("", "");
    const Material& material = plain.materials[0];
    ASSERT_TRUE(material.reflectance_texture);
    EXPECT_EQ(material.reflectance_texture, material.emission_texture);
    // The only dark pixel is the upper left one.
    EXPECT_EQ(material.reflectance_texture->at({0.25, 0.75})[0], 0.0);
    EXPECT_EQ(material.reflectance_texture->at({0.75, 0.75})[0], 1.0);
    EXPECT_EQ(material.reflectance_texture->at({-0.75, 1.75})[0], 0.0) << "repeated";
    const PolygonSoup clamped = read("", "\"wrapS\":33071,\"wrapT\":33648");
    EXPECT_EQ(clamped.materials[0].reflectance_texture->at({-5, 0.75})[0], 0.0);
    EXPECT_EQ(clamped.materials[0].reflectance_texture->at({0.25, 1.25})[0], 0.0) << "mirrored";
    // Scaled to half, then turned by 90 degrees counterclockwise on the picture, whose v runs downwards (u' = v/2,
    // v' = -u/2), then moved by (0, 1): (u, v) = (0.5, 0.5) shows (0.25, 0.75), which is 0.25 from below.
    const PolygonSoup turned = read(",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":"
                                    "1.5707963267948966,\"scale\":[0.5,0.5]}}",
                                    "");
    const Texture& texture = *turned.materials[0].reflectance_texture;
    for (const auto& [u, v] : {std::pair{0.5, 0.5}, std::pair{1.5, 0.5}, std::pair{0.5, 1.5}, std::pair{1.25, 1.0}}) {
        const TextureCoordinates shown(0.5 * v, 1.0 - (1.0 - 0.5 * u));
        EXPECT_NEAR(texture.at({u, 1.0 - v})[0], material.reflectance_texture->at(shown)[0], 1e-12) << u << " " << v;
    }
}

TEST(GltfReader, PicturesThatAreMissingOrDamaged) {
    const auto with = [](const std::string& image) {
        return "\"nodes\":[{\"mesh\":0}],\"images\":[" + image +
               "],\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0,"
               "\"baseColorTexture\":{\"index\":0}}}]," +
               square_mesh + "," + square().embedded();
    };
    EXPECT_THAT(notes(gltf(with("{\"uri\":\"gone.png\"}"))), HasSubstr("pictures of textures that are not there: 1"));
    EXPECT_THAT(refused(with("{\"bufferView\":0}")), HasSubstr("test.gltf, image 0: "));
    EXPECT_THAT(refused(with("{\"uri\":\"data:image/png;base64,?\"}")), HasSubstr("base64"));
    EXPECT_THAT(refused(with("{\"uri\":\"https://a.b/c.png\"}")), HasSubstr("download"));
    EXPECT_THAT(refused(with("{}")), HasSubstr("needs \"uri\""));
}

TEST(GltfReader, MetalOfATextureIsItsMean) {
    const PolygonSoup soup = gltf(
        "\"nodes\":[{\"mesh\":0}],\"images\":[{\"uri\":\"data:image/bmp;base64," + base64(picture()) +
        "\"}],\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{"
        "\"index\":0}}}]," +
        square_mesh + "," + square().embedded());
    EXPECT_TRUE((soup.materials[0].reflectance == 0.25).all());
    EXPECT_THAT(notes(soup), HasSubstr("painted by a texture: 1"));
}

/// Both colours of KHR_materials_pbrSpecularGlossiness, and that they take the place of the others.
TEST(GltfReader, SpecularGlossiness) {
    const auto material = [](const std::string& gloss, const std::string& name, bool required) {
        return gltf((required ? "\"extensionsRequired\":[\"" + name + "\"]," : std::string()) +
                    "\"nodes\":[{\"mesh\":0}],\"images\":[{\"uri\":\"data:image/bmp;base64," + base64(picture()) +
                    "\"},{\"uri\":\"data:image/bmp;base64," + base64(picture('\x80')) +
                    "\"}],\"textures\":[{\"source\":0},{\"source\":1}],\"materials\":[{\"pbrMetallicRoughness\":{"
                    "\"baseColorFactor\":[0.1,0.2,0.3,1]},\"extensions\":{\"" +
                    name + "\":{" + gloss + "}}}]," + square_mesh + "," + square().embedded());
    };
    const std::string extension = "KHR_materials_pbrSpecularGlossiness";
    for (const bool required : {false, true}) {
        const PolygonSoup soup = material("\"diffuseFactor\":[0.5,0.25,1,0.5],\"specularFactor\":[0.25,0.5,0],"
                                          "\"diffuseTexture\":{\"index\":1}",
                                          extension, required);
        EXPECT_TRUE((soup.materials[0].reflectance == Rgb(0.25, 0.125, 0.5)).all());
        ASSERT_TRUE(soup.materials[0].reflectance_texture);
        // 128 of 255 in sRGB: ((128/255 + 0.055) / 1.055)^2.4.
        EXPECT_NEAR(soup.materials[0].reflectance_texture->at({0.25, 0.25})[0],
                    std::pow((128.0 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
        EXPECT_THAT(soup.notes, IsEmpty());
    }
    const PolygonSoup mirror = material("", extension, false);
    EXPECT_TRUE((mirror.materials[0].reflectance == 0.0).all()) << "both colours are white by default";
    EXPECT_THAT(notes(mirror), HasSubstr("materials of metal: 1 (\"material 0\")"));
    // Three of four pixels are white: 1/4 of what is diffuse is left, with half the specular colour 5/8.
    const PolygonSoup painted =
        material("\"specularFactor\":[0.5,0,0.5],\"specularGlossinessTexture\":{\"index\":0}", extension, false);
    EXPECT_TRUE((painted.materials[0].reflectance == 0.625).all());
    EXPECT_THAT(notes(painted), HasSubstr("specular colour is painted by a texture: 1"));
    EXPECT_THAT(refused(scene("{\"mesh\":0}")
                            .replace(scene("{\"mesh\":0}").find("\"pbrMetallicRoughness\""), 0,
                                     "\"extensions\":{\"" + extension + "\":{\"diffuseFactor\":[1,1,1]}},")),
                HasSubstr("\"diffuseFactor\""));
    // Unlit materials are paint, though they do not say that they are no metal.
    const PolygonSoup unlit = material("", "KHR_materials_unlit", true);
    EXPECT_TRUE((unlit.materials[0].reflectance == Rgb(0.1, 0.2, 0.3)).all());
    EXPECT_THAT(unlit.notes, ElementsAre(HasSubstr("unlit materials: 1 (\"material 0\")")));
}

TEST(GltfReader, RefusesWhatItCannotDoWithout) {
    for (const char* known : {"KHR_materials_clearcoat", "KHR_materials_ior", "KHR_materials_emissive_strength",
                              "KHR_texture_transform", "KHR_mesh_quantization"}) {
        EXPECT_EQ(gltf("\"extensionsRequired\":[\"" + std::string(known) + "\"]").face_count(), 0U);
    }
    for (const char* other : {"KHR_materials_madeup", "KHR_materials_transmission", "KHR_materials_"}) {
        EXPECT_THAT(refused("\"extensionsRequired\":[\"" + std::string(other) + "\"]"),
                    AllOf(HasSubstr(other), HasSubstr("export opaque materials of metal and roughness alone")));
    }
    EXPECT_THAT(refused("\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"),
                AllOf(HasSubstr("test.gltf:2: "), HasSubstr("without compression of meshes")));
    EXPECT_THAT(refused("\"extensionsRequired\":[\"EXT_meshopt_compression\"]"), HasSubstr("without compression"));
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
    EXPECT_THAT(with("\"count\":4", "\"count\":400000000000"), HasSubstr("more vectors than can be numbered"));
    EXPECT_THAT(with("\"count\":4", "\"count\":-4"), HasSubstr("not negative, not -4"));
    EXPECT_THAT(with("\"count\":4", "\"count\":4,\"byteOffset\":9007199254740992"), HasSubstr("not within"));
    EXPECT_THAT(with("\"byteLength\":48", "\"byteLength\":9007199254740992"), HasSubstr("not within its buffer"));
    EXPECT_THAT(with("\"byteLength\":92", "\"byteLength\":93"), HasSubstr("should have 93 bytes, and there are 92"));
    EXPECT_THAT(with("\"buffer\":0", "\"buffer\":1"), HasSubstr("entry 1 of \"buffers\""));
    EXPECT_THAT(with("\"VEC3\"", "\"VEC2\""), HasSubstr("must have 3 components"));
    EXPECT_THAT(with("5126", "5124"), HasSubstr("component type 5124"));
    EXPECT_THAT(with("5123", "5122"), HasSubstr("indices that are not unsigned"));
    EXPECT_THAT(with("\"bufferView\":0,", "\"bufferView\":0,\"bufferView\":0,"), HasSubstr("stands twice"));
    EXPECT_THAT(with("\"bufferView\":2", "\"bufferView\":1"), HasSubstr("names vertex"));
    EXPECT_THAT(with("\"TEXCOORD_0\":1", "\"COLOR_0\":2"), HasSubstr("must have 3 components"));
    EXPECT_THAT(with("\"bufferView\":0,\"componentType\":5126,\"count\":4", "\"componentType\":5126,\"count\":4000000"),
                HasSubstr("without a buffer"));
    EXPECT_THAT(with("\"byteLength\":48", "\"byteStride\":0,\"byteLength\":48"), HasSubstr("from 4 to 252"));
    EXPECT_THAT(with("\"uri\":\"data:", "\"uri\":\"dota:"), HasSubstr("not there"));
    EXPECT_THAT(with("\"material\":0", "\"material\":1"), HasSubstr("entry 1 of \"materials\""));
    EXPECT_THAT(with("\"mesh\":0", "\"mesh\":0.5"), HasSubstr("a whole number"));
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
