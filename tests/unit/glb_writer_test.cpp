// glTF files hold what the field has, in glTF's own terms.
#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/io/field_file.h>

#include <meshes.h>
#include <readers.h>
#include <scratch_directory.h>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>

namespace difusa::glb_writer_test {
namespace {

using test::read_file;
using test::ScratchDirectory;
using testing::HasSubstr;

FieldFile example(const Vec3& up) {
    const Mesh mesh = test::moved(test::icosphere(1), 2.0, Vec3(100.0, -7.0, 3.0));
    FieldFile field;
    field.points = mesh.points;
    field.triangles = mesh.triangles;
    field.up = up;
    const auto count = static_cast<Eigen::Index>(mesh.points.size());
    Values radiosity(count, 3), brightness(count, 1);
    std::vector<std::uint8_t> display;
    for (Eigen::Index i = 0; i < count; ++i) {
        field.normals.push_back((mesh.points[static_cast<std::size_t>(i)] - Vec3(100.0, -7.0, 3.0)).normalized());
        radiosity.row(i) << 0.1 * static_cast<double>(i), 7.25, 1e-3;
        brightness(i, 0) = static_cast<double>(i);
        for (int c = 0; c < 3; ++c) {
            display.push_back(static_cast<std::uint8_t>(6 * i + c));
        }
    }
    field.point_arrays = {{"radiosity", "W/m^2", {"R", "G", "B"}, radiosity},
                          {"my array-1", "", {}, brightness},
                          {"display_rgb", "", {"R", "G", "B"}, display}};
    field.active_colours = "display_rgb";
    field.notes = {{"scene", std::string("a \"b\" \xff.obj")}, {"exposure", std::vector<double>{0.25}}};
    return field;
}

/// The parts of a binary glTF file.
struct Glb {
    nlohmann::json json;
    std::string bytes;

    explicit Glb(const std::string& content) {
        EXPECT_EQ(content.substr(0, 4), "glTF");
        EXPECT_EQ(word(content, 4), 2U);
        EXPECT_EQ(word(content, 8), content.size());
        const std::size_t length = word(content, 12);
        EXPECT_EQ(length % 4, 0U);
        EXPECT_EQ(content.substr(16, 4), "JSON");
        json = nlohmann::json::parse(content.substr(20, length));
        EXPECT_EQ(word(content, 20 + length), content.size() - 28 - length);
        EXPECT_EQ(content.substr(24 + length, 4), std::string("BIN\0", 4));
        bytes = content.substr(28 + length);
        EXPECT_EQ(json["buffers"][0]["byteLength"], bytes.size());
    }
    static std::uint32_t word(const std::string& content, std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            value |= std::uint32_t{static_cast<unsigned char>(content.at(at + i))} << (8 * i);
        }
        return value;
    }
    const nlohmann::json& accessor(const std::string& name) const {
        return json["accessors"][json["meshes"][0]["primitives"][0]["attributes"][name].get<std::size_t>()];
    }
    /// Number k of the array of floats.
    float real(const std::string& name, std::size_t k) const {
        EXPECT_EQ(accessor(name)["componentType"], 5126);
        return std::bit_cast<float>(word(bytes, offset(name) + 4 * k));
    }
    std::size_t offset(const std::string& name) const {
        return json["bufferViews"][accessor(name)["bufferView"].get<std::size_t>()]["byteOffset"];
    }
};

TEST(GlbWriter, HoldsColoursNumbersAndNotes) {
    const ScratchDirectory scratch;
    const FieldFile field = example(Vec3::UnitZ());
    write_field(field, scratch / "a.GLB");
    const Glb glb(read_file(scratch / "a.GLB"));
    EXPECT_EQ(glb.json["asset"]["version"], "2.0");
    EXPECT_EQ(glb.json["asset"]["extras"]["exposure"][0], 0.25);
    EXPECT_THAT(glb.json["asset"]["extras"]["scene"].get<std::string>(), HasSubstr("a \"b\" "));
    EXPECT_EQ(glb.accessor("_MY_ARRAY_1")["type"], "SCALAR");
    EXPECT_EQ(glb.accessor("COLOR_0")["normalized"], true);
    const Values& radiosity = *values_of(field.point_arrays[0]);
    const auto& display = std::get<std::vector<std::uint8_t>>(field.point_arrays[2].data);
    for (std::size_t i = 0; i < field.points.size(); ++i) {
        EXPECT_EQ(glb.real("_MY_ARRAY_1", i), static_cast<float>(i));
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_EQ(glb.real("_RADIOSITY", 3 * i + c),
                      static_cast<float>(radiosity(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c))));
            EXPECT_EQ(glb.real("NORMAL", 3 * i + c),
                      static_cast<float>(field.normals[i][static_cast<Eigen::Index>(c)]));
            const std::size_t at = glb.offset("COLOR_0") + 8 * i + 2 * c;
            const auto linear = Glb::word(glb.bytes, at) & 0xffffU;
            EXPECT_EQ(std::lround(255.0 * srgb(linear / 65535.0)), display[3 * i + c]) << "the byte that it came from";
        }
    }
    for (std::size_t c = 0; c < 3; ++c) { // the bounds are those of the numbers in the file
        float low = glb.real("POSITION", c), high = low;
        for (std::size_t i = 1; i < field.points.size(); ++i) {
            low = std::min(low, glb.real("POSITION", 3 * i + c));
            high = std::max(high, glb.real("POSITION", 3 * i + c));
        }
        EXPECT_EQ(glb.accessor("POSITION")["min"][c].get<float>(), low);
        EXPECT_EQ(glb.accessor("POSITION")["max"][c].get<float>(), high);
    }
}

/// Arrays of lights named "lamp", "LAMP" and in two letters beyond ASCII: each has an attribute of its own, and says
/// what it is called.
TEST(GlbWriter, NamesThatLookAlikeStayApart) {
    const ScratchDirectory scratch;
    FieldFile field = example(Vec3::UnitZ());
    const std::vector<std::string> names{"of_lamp", "of_LAMP", "of_\u00e4", "of_\u00f6", "of_lamp_2"};
    const std::size_t before = field.point_arrays.size();
    for (std::size_t k = 0; k < names.size(); ++k) {
        Values values = Values::Constant(static_cast<Eigen::Index>(field.points.size()), 1, static_cast<double>(k));
        field.point_arrays.push_back({names[k], "", {}, std::move(values)});
    }
    write_field(field, scratch / "a.glb");
    const Glb glb(read_file(scratch / "a.glb"));
    EXPECT_EQ(glb.json["meshes"][0]["primitives"][0]["attributes"].size(),
              before + names.size() + 2); // POSITION, NORMAL
    std::vector<std::string> found;
    for (const auto& [attribute, number] : glb.json["meshes"][0]["primitives"][0]["attributes"].items()) {
        if (attribute.starts_with("_OF_")) {
            found.push_back(glb.accessor(attribute)["name"]);
            EXPECT_EQ(names.at(static_cast<std::size_t>(glb.real(attribute, 0))), found.back());
        }
    }
    EXPECT_THAT(found, testing::UnorderedElementsAreArray(names));
}

TEST(GlbWriter, StandsUpright) {
    const ScratchDirectory scratch;
    for (const Vec3& up :
         {Vec3(Vec3::UnitZ()), Vec3(Vec3::UnitY()), Vec3(-Vec3::UnitY()), Vec3(1.0, 2.0, 3.0).normalized()}) {
        const FieldFile field = example(up);
        write_field(field, scratch / "a.glb");
        const PolygonSoup soup = readers::parse("gltf", read_file(scratch / "a.glb"));
        ASSERT_EQ(soup.face_count(), field.triangles.size());
        const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(up, Vec3::UnitY());
        for (std::size_t t = 0; t < field.triangles.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 &x = field.points[field.triangles[t][k]], &read = soup.points[soup.face(t)[k]];
                // Relative to the middle, which is at most 2 m away, in single precision.
                EXPECT_LE((turn * x - read).norm(), 4e-7);
                EXPECT_NEAR(read.y(), up.dot(x), 4e-7);
            }
        }
    }
}

TEST(GlbWriter, PointsHaveNoTriangles) {
    const ScratchDirectory scratch;
    FieldFile field = example(Vec3::UnitZ());
    field.triangles.clear();
    field.normals.clear();
    write_field(field, scratch / "a.glb");
    const Glb glb(read_file(scratch / "a.glb"));
    const nlohmann::json& primitive = glb.json["meshes"][0]["primitives"][0];
    EXPECT_EQ(primitive["mode"], 0);
    EXPECT_FALSE(primitive.contains("indices"));
    EXPECT_FALSE(primitive["attributes"].contains("NORMAL"));
}

} // namespace
} // namespace difusa::glb_writer_test
