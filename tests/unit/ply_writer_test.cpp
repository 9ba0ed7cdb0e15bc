#include <difusa/core/error.h>
#include <difusa/io/field_file.h>

#include <file_size_limit.h>
#include <meshes.h>
#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <sstream>

namespace difusa::ply_writer_test {
namespace {

using test::FileSizeLimit;
using test::read_file;
using test::ScratchDirectory;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Names = std::set<std::string>;

/// The lines of a PLY header, and the bytes after it one by one.
class Ply {
  public:
    explicit Ply(const std::string& content) {
        const std::string last = "end_header\n";
        const std::size_t end = content.find(last);
        EXPECT_NE(end, std::string::npos);
        std::istringstream header(content.substr(0, end));
        for (std::string line; std::getline(header, line);) {
            (line.starts_with("comment ") ? comments : lines).push_back(line);
        }
        body_ = content.substr(end + last.size());
    }

    std::vector<std::string> lines, comments;

    /// The next `size` bytes, the first one least significant.
    std::uint64_t number(int size) {
        std::uint64_t value = 0;
        for (int i = 0; i < size; ++i, ++next_) {
            value |= std::uint64_t{static_cast<unsigned char>(body_.at(next_))} << (8 * i);
        }
        return value;
    }
    double real() { return std::bit_cast<double>(number(8)); }
    float single() { return std::bit_cast<float>(static_cast<std::uint32_t>(number(4))); }
    bool at_end() const { return next_ == body_.size(); }

  private:
    std::string body_;
    std::size_t next_ = 0;
};

FieldFile example() {
    const Mesh mesh = test::moved(test::icosphere(1), 1e-3, Vec3(1e6, 0, -1.0 / 3));
    const std::size_t count = mesh.points.size();
    FieldFile field;
    field.points = mesh.points;
    field.triangles = mesh.triangles;
    Values luminance(static_cast<Eigen::Index>(count), 1);
    std::vector<std::uint8_t> colours;
    for (std::size_t p = 0; p < count; ++p) {
        field.normals.push_back(Vec3(1, static_cast<double>(p), 0.1).normalized());
        luminance(static_cast<Eigen::Index>(p), 0) = 1.0 / static_cast<double>(p + 1);
        for (std::size_t k = 0; k < 3; ++k) {
            colours.push_back(static_cast<std::uint8_t>(255 - 3 * p - k));
        }
    }
    field.point_arrays.push_back({"other", "", {}, Values(Values::Zero(static_cast<Eigen::Index>(count), 1))});
    field.point_arrays.push_back({"display_rgb", "", {"R", "G", "B"}, colours});
    field.point_arrays.push_back({"luminance", "W/m^2", {}, luminance});
    field.active_colours = "display_rgb";
    field.quality = "luminance";
    field.notes = {{"version", "1.2.3"}, {"times", std::vector<double>{0.1, 2, 1e-9}}};
    return field;
}

TEST(PlyWriter, EveryByteIsInItsPlace) {
    const ScratchDirectory scratch;
    const FieldFile field = example();
    write_field(field, scratch / "out.ply");
    EXPECT_EQ(scratch.names(), Names{"out.ply"});
    Ply ply(read_file(scratch / "out.ply"));
    EXPECT_THAT(ply.lines,
                ElementsAre("ply", "format binary_little_endian 1.0", "element vertex 42", "property double x",
                            "property double y", "property double z", "property float nx", "property float ny",
                            "property float nz", "property uchar red", "property uchar green", "property uchar blue",
                            "property float quality", "element face 80", "property list uchar int vertex_indices"));
    EXPECT_THAT(ply.comments, ElementsAre("comment version: 1.2.3", "comment times: 0.1 2 1e-09",
                                          "comment quality: luminance in W/m^2"));
    const auto& colours = std::get<std::vector<std::uint8_t>>(field.point_arrays[1].data);
    for (std::size_t p = 0; p < field.points.size(); ++p) {
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(ply.real(), field.points[p][k]);
        }
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(ply.single(), static_cast<float>(field.normals[p][k]));
        }
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(ply.number(1), colours[3 * p + k]);
        }
        EXPECT_EQ(ply.single(), static_cast<float>(1.0 / static_cast<double>(p + 1)));
    }
    for (const auto& triangle : field.triangles) {
        EXPECT_EQ(ply.number(1), 3u);
        for (const Index corner : triangle) {
            EXPECT_EQ(ply.number(4), corner);
        }
    }
    EXPECT_TRUE(ply.at_end());
}

TEST(PlyWriter, StreamsMoreThanItBuffers) {
    const ScratchDirectory scratch;
    FieldFile field;
    const Mesh mesh = test::grid(300, 300);
    field.points = mesh.points;
    field.triangles = mesh.triangles;
    write_field(field, scratch / "out.ply");
    Ply ply(read_file(scratch / "out.ply"));
    for (const Vec3& point : field.points) {
        for (int k = 0; k < 3; ++k) {
            ASSERT_EQ(ply.real(), point[k]);
        }
    }
    for (const auto& triangle : field.triangles) {
        ASSERT_EQ(ply.number(1), 3u);
        for (const Index corner : triangle) {
            ASSERT_EQ(ply.number(4), corner);
        }
    }
    EXPECT_TRUE(ply.at_end());
}

TEST(PlyWriter, PointCloudHasNoFaces) {
    const ScratchDirectory scratch;
    FieldFile field;
    field.points = {{1, 2, 3}, {4, 5, 6}};
    write_field(field, scratch / "out.ply");
    Ply ply(read_file(scratch / "out.ply"));
    EXPECT_THAT(ply.lines, ElementsAre("ply", "format binary_little_endian 1.0", "element vertex 2",
                                       "property double x", "property double y", "property double z"));
    for (const double expected : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
        EXPECT_EQ(ply.real(), expected);
    }
    EXPECT_TRUE(ply.at_end());
}

TEST(PlyWriter, NotesCannotEndTheHeader) {
    const ScratchDirectory scratch;
    FieldFile field;
    field.points = {{1, 2, 3}};
    std::string text = "a\nend_header\r\nelement\tvertex 7";
    field.notes.push_back({"options", text});
    std::string wide;
    for (int i = 0; i < 400; ++i) {
        wide += i % 3 == 0 ? "x" : "ρ€"; // characters of one, two and three bytes
    }
    field.notes.push_back({"wide", wide});
    write_field(field, scratch / "out.ply");
    Ply ply(read_file(scratch / "out.ply"));
    ASSERT_EQ(ply.lines.size(), 6u);
    EXPECT_EQ(ply.comments[0], "comment options: a end_header  element vertex 7");
    std::string joined;
    for (std::size_t i = 1; i < ply.comments.size(); ++i) {
        const std::string line = ply.comments[i].substr(8);
        EXPECT_LE(line.size(), 200u);
        EXPECT_NE(static_cast<unsigned char>(line[0]) & 0xc0u, 0x80u) << "a character was cut";
        joined += line;
    }
    EXPECT_EQ(joined, "wide: " + wide);
    EXPECT_EQ(ply.real(), 1.0);
}

TEST(PlyWriter, FullDiskIsAnErrorWhereverItStrikes) {
    const ScratchDirectory scratch;
    write_field(example(), scratch / "whole.ply");
    const auto size = static_cast<rlim_t>(std::filesystem::file_size(scratch / "whole.ply"));
    write_whole_file(scratch / "out.ply", "old");
    for (const rlim_t limit : {rlim_t{0}, rlim_t{100}, size / 2, size - 1}) {
        const FileSizeLimit full(limit);
        EXPECT_THAT([&] { write_field(example(), scratch / "out.ply"); },
                    ThrowsMessage<ResourceError>(HasSubstr((scratch / "out.ply").string())));
    }
    EXPECT_EQ(read_file(scratch / "out.ply"), "old");
    EXPECT_EQ(scratch.names(), (Names{"out.ply", "whole.ply"}));
}

} // namespace
} // namespace difusa::ply_writer_test
