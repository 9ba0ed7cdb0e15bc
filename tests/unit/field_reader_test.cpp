#include <difusa/core/error.h>
#include <difusa/io/field_reader.h>

#include "support/sanitized.h"
#include <example_field.h>
#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkShortArray.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLPolyDataWriter.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <span>

namespace difusa::field_reader_test {
namespace {

using test::ScratchDirectory;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Corners = std::vector<std::array<Index, 3>>;

FieldFile example(int level = 2) {
    return test::example_field(level, "W/m^2");
}

bool same_bits(const Values& a, const Values& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() &&
           std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

void expect_same(const FieldArray& a, const FieldArray& b) {
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.unit, b.unit) << a.name;
    EXPECT_EQ(a.components, b.components) << a.name;
    ASSERT_EQ(a.data.index(), b.data.index()) << a.name;
    if (const Values* values = values_of(a)) {
        EXPECT_TRUE(same_bits(*values, *values_of(b))) << a.name;
    } else {
        using Bytes = std::vector<std::uint8_t>;
        using Integers = std::vector<std::int32_t>;
        if (std::holds_alternative<Bytes>(a.data)) {
            EXPECT_EQ(std::get<Bytes>(a.data), std::get<Bytes>(b.data)) << a.name;
        } else {
            EXPECT_EQ(std::get<Integers>(a.data), std::get<Integers>(b.data)) << a.name;
        }
    }
}

void expect_same(const std::vector<FieldArray>& a, const std::vector<FieldArray>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        expect_same(a[i], b[i]);
    }
}

void expect_same(const FieldFile& a, const FieldFile& b) {
    EXPECT_EQ(a.points, b.points);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.triangles, b.triangles);
    expect_same(a.point_arrays, b.point_arrays);
    expect_same(a.cell_arrays, b.cell_arrays);
    EXPECT_EQ(a.active_colours, b.active_colours);
    ASSERT_EQ(a.notes.size(), b.notes.size());
    for (std::size_t i = 0; i < a.notes.size(); ++i) {
        EXPECT_EQ(a.notes[i].name, b.notes[i].name);
        EXPECT_EQ(a.notes[i].value, b.notes[i].value) << a.notes[i].name;
    }
}

const FieldArray& array(const std::vector<FieldArray>& arrays, const std::string& name) {
    for (const FieldArray& a : arrays) {
        if (a.name == name) {
            return a;
        }
    }
    ADD_FAILURE() << "no array " << name;
    return arrays.at(0);
}

FieldFile read_text(const ScratchDirectory& scratch, const std::string& name, const std::string& content) {
    std::ofstream(scratch / name, std::ios::binary) << content;
    return read_field(scratch / name);
}

TEST(FieldReader, VtpComesBackAsItWas) {
    const ScratchDirectory scratch;
    const FieldFile field = example();
    write_field(field, scratch / "out.vtp");
    expect_same(read_field(scratch / "out.vtp"), field);
}

TEST(FieldReader, PointCloudsAndEmptyFilesComeBack) {
    const ScratchDirectory scratch;
    FieldFile cloud;
    cloud.points = {{0, 0, 0}, {1, 2, 3}, {-1, 1e-300, 1e100}};
    cloud.point_arrays.push_back({"radius", "m", {}, Values(Values::Constant(3, 1, 0.1))});
    cloud.cell_arrays.push_back({"region", "", {}, std::vector<std::int32_t>{4, 5, 6}});
    write_field(cloud, scratch / "sites.vtp");
    expect_same(read_field(scratch / "sites.vtp"), cloud);
    write_field({}, scratch / "empty.vtp");
    expect_same(read_field(scratch / "empty.vtp"), {});
}

TEST(FieldReader, NanAndInfinityComeBackFromVtp) {
    const ScratchDirectory scratch;
    FieldFile field = example(0);
    Values& values = std::get<Values>(field.point_arrays[1].data);
    values(3, 0) = std::numeric_limits<double>::quiet_NaN();
    values(5, 0) = std::numeric_limits<double>::infinity();
    write_field(field, scratch / "out.vtp");
    expect_same(read_field(scratch / "out.vtp"), field);
}

/// A quadrilateral, a concave pentagon, a triangle, a strip, a line and a vertex over points of the plane.
vtkNew<vtkPolyData> zoo() {
    vtkNew<vtkPolyData> mesh;
    vtkNew<vtkPoints> points; // floats, as ParaView's own sources make
    const double places[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {3, 0}, {5, 0}, {5, 2}, {4, 0.5}, {3, 2}};
    for (const auto& p : places) {
        points->InsertNextPoint(p[0], p[1], 0.1);
    }
    mesh->SetPoints(points);
    const auto add = [](vtkCellArray* cells, const std::vector<vtkIdType>& corners) {
        cells->InsertNextCell(static_cast<vtkIdType>(corners.size()), corners.data());
    };
    vtkNew<vtkCellArray> vertices, lines, polygons, strips;
    add(vertices, {4});
    add(lines, {0, 5});
    add(polygons, {0, 1, 2, 3});
    add(polygons, {4, 5, 6, 7, 8});
    add(polygons, {1, 4, 2});
    add(strips, {0, 1, 3, 2});
    mesh->SetVerts(vertices);
    mesh->SetLines(lines);
    mesh->SetPolys(polygons);
    mesh->SetStrips(strips);
    vtkNew<vtkFloatArray> temperature;
    temperature->SetName("temperature");
    vtkNew<vtkIdTypeArray> large;
    large->SetName("large");
    vtkNew<vtkShortArray> pairs;
    pairs->SetName("pairs");
    pairs->SetNumberOfComponents(2);
    vtkNew<vtkStringArray> texts;
    texts->SetName("texts");
    for (int i = 0; i < 9; ++i) {
        temperature->InsertNextValue(0.1f * static_cast<float>(i));
        large->InsertNextValue((vtkIdType{1} << 40) + i);
        pairs->InsertNextValue(static_cast<short>(i));
        pairs->InsertNextValue(static_cast<short>(-i));
        texts->InsertNextValue("text");
    }
    mesh->GetPointData()->AddArray(temperature);
    mesh->GetPointData()->AddArray(large);
    mesh->GetPointData()->AddArray(pairs);
    mesh->GetPointData()->AddArray(texts);
    vtkNew<vtkUnsignedCharArray> kind;
    kind->SetName("kind");
    for (const int k : {1, 2, 4, 5, 3, 40}) {
        kind->InsertNextValue(static_cast<unsigned char>(k));
    }
    mesh->GetCellData()->AddArray(kind);
    vtkNew<vtkStringArray> notes;
    notes->SetName("authors");
    notes->InsertNextValue("A");
    notes->InsertNextValue("B");
    mesh->GetFieldData()->AddArray(notes);
    return mesh;
}

TEST(FieldReader, ReadsEveryEncodingOfVtk) {
    const ScratchDirectory scratch;
    const vtkNew<vtkPolyData> mesh = zoo();
    std::vector<FieldFile> files;
    for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended}) {
        for (const int compressor : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB, vtkXMLWriter::LZ4, vtkXMLWriter::LZMA}) {
            if (test::sanitized() && compressor == vtkXMLWriter::LZMA) {
                continue; // VTK's codec reserves 100 MB for each array, whose every byte is then marked
            }
            for (const int choice : {0, 1, 2, 3}) { // raw or base64, byte order, header of 32 or 64 bits
                vtkNew<vtkXMLPolyDataWriter> writer;
                writer->SetInputData(mesh);
                writer->SetFileName((scratch / "out.vtp").c_str());
                writer->SetDataMode(mode);
                writer->SetCompressorType(compressor);
                writer->SetEncodeAppendedData(choice == 0 || choice == 3);
                writer->SetByteOrder(choice < 2 ? vtkXMLWriter::LittleEndian : vtkXMLWriter::BigEndian);
                writer->SetHeaderType(choice % 2 == 0 ? vtkXMLWriter::UInt32 : vtkXMLWriter::UInt64);
                ASSERT_EQ(writer->Write(), 1);
                files.push_back(read_field(scratch / "out.vtp"));
                if (files.size() > 1) {
                    expect_same(files.back(), files.front());
                }
            }
        }
    }
    const FieldFile& file = files.front();
    ASSERT_EQ(file.points.size(), 9u);
    EXPECT_EQ(file.points[7], Vec3(4.0, 0.5, static_cast<double>(0.1f)));
    const auto& temperature = std::get<Values>(array(file.point_arrays, "temperature").data);
    EXPECT_EQ(temperature(7, 0), static_cast<double>(0.1f * 7.0f));
    EXPECT_EQ(std::get<Values>(array(file.point_arrays, "large").data)(3, 0), 1099511627779.0);
    const FieldArray& pairs = array(file.point_arrays, "pairs");
    EXPECT_EQ(pairs.components, (std::vector<std::string>{"0", "1"}));
    EXPECT_EQ(std::get<std::vector<std::int32_t>>(pairs.data)[7], -3);
    EXPECT_EQ(file.point_arrays.size(), 3u); // without the texts
    ASSERT_EQ(file.notes.size(), 1u);
    EXPECT_EQ(std::get<std::string>(file.notes[0].value), "A\nB");
}

TEST(FieldReader, PolygonsAndStripsBecomeTrianglesOfTheSameSurface) {
    const ScratchDirectory scratch;
    const vtkNew<vtkPolyData> mesh = zoo();
    vtkNew<vtkXMLPolyDataWriter> writer;
    writer->SetInputData(mesh);
    writer->SetFileName((scratch / "out.vtp").c_str());
    writer->Write();
    const FieldFile file = read_field(scratch / "out.vtp");
    const auto& kind = std::get<std::vector<std::uint8_t>>(array(file.cell_arrays, "kind").data);
    ASSERT_EQ(kind.size(), file.triangles.size());
    std::map<int, double> area; // with its sign, for each cell
    for (std::size_t t = 0; t < kind.size(); ++t) {
        const auto& [a, b, c] = file.triangles[t];
        const double doubled = (file.points[b] - file.points[a]).cross(file.points[c] - file.points[a]).z();
        EXPECT_GT(doubled, 0.0);
        area[kind[t]] += 0.5 * doubled;
    }
    // The pentagon: a square of side 2 less a triangle of base 2 and height 1.5.
    EXPECT_EQ(area, (std::map<int, double>{{4, 1.0}, {5, 2.5}, {3, 1.0}, {40, 1.0}}));
}

TEST(FieldReader, PolygonsThatCrossThemselvesOrLeaveThePointsAreRefused) {
    const ScratchDirectory scratch;
    const auto with = [&](const std::string& connectivity, const std::string& offsets, int cells) {
        return R"(<?xml version="1.0"?>
<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>
<Piece NumberOfPoints="4" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys=")" +
               std::to_string(cells) + R"(">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points>
<Polys><DataArray type="Int64" Name="connectivity" format="ascii">)" +
               connectivity + R"(</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">)" +
               offsets + R"(</DataArray></Polys></Piece></PolyData></VTKFile>)";
    };
    EXPECT_EQ(read_text(scratch, "good.vtp", with("0 1 2 0 2 3", "3 6", 2)).triangles, (Corners{{0, 1, 2}, {0, 2, 3}}));
    // Repeated corners are no corners; what has no area is no surface.
    EXPECT_EQ(read_text(scratch, "slim.vtp", with("0 0 1 2 0 1 0 1", "4 8", 2)).triangles, (Corners{{0, 1, 2}}));
    const auto refused = [&](const std::string& connectivity, const std::string& offsets, const char* why) {
        EXPECT_THAT([&] { read_text(scratch, "bad.vtp", with(connectivity, offsets, 2)); },
                    ThrowsMessage<InputError>(testing::AllOf(HasSubstr("bad.vtp: "), HasSubstr(why))));
    };
    refused("0 1 2 0 2 3", "3 9", "is not a complete VTK XML PolyData file");
    refused("0 1 2 0 2 3", "6 3", "is not a complete VTK XML PolyData file");
    refused("0 1 2 0 2 1 3", "3 7", "polygon 2 crosses itself");
    refused("0 1 2 0 2 4", "3 6", "cell 2 has a corner at point 4, but the points are 0 to 3");
    refused("0 1 2 0 2 -1", "3 6", "cell 2 has a corner at point -1");
}

TEST(FieldReader, PlyComesBackAsFarAsPlyHoldsIt) {
    const ScratchDirectory scratch;
    FieldFile field = example();
    field.quality = "luminance";
    auto& luminance = std::get<Values>(field.point_arrays[1].data);
    luminance(2, 0) = 1e30;                      // 1e150 is no float
    const std::string two_hundred(200 - 9, 'x'); // "exactly: " and this fill one line
    field.notes.push_back({"exactly", two_hundred});
    field.notes.push_back({"long", std::string(500, 'y') + " a: b  " + std::string(300, 'z')});
    field.notes.push_back({"greek", std::string(193, 'a') + "ρρρρρρρρρ"});
    write_field(field, scratch / "out.ply");
    const FieldFile file = read_field(scratch / "out.ply");
    EXPECT_EQ(file.points, field.points);
    EXPECT_EQ(file.triangles, field.triangles);
    ASSERT_EQ(file.normals.size(), field.normals.size());
    for (std::size_t p = 0; p < file.points.size(); ++p) {
        EXPECT_EQ(file.normals[p], field.normals[p].cast<float>().cast<double>());
    }
    ASSERT_EQ(file.point_arrays.size(), 2u);
    expect_same(file.point_arrays[0], field.point_arrays[2]);
    EXPECT_EQ(file.point_arrays[1].name, "luminance");
    EXPECT_EQ(file.point_arrays[1].unit, "W/m^2");
    EXPECT_TRUE(same_bits(std::get<Values>(file.point_arrays[1].data), Values(luminance.cast<float>().cast<double>())));
    EXPECT_EQ(file.active_colours, "display_rgb");
    EXPECT_EQ(file.quality, "luminance");
    ASSERT_EQ(file.notes.size(), field.notes.size());
    for (std::size_t i = 0; i < file.notes.size(); ++i) {
        EXPECT_EQ(file.notes[i].name, field.notes[i].name);
        const std::string& text = std::get<std::string>(file.notes[i].value);
        if (field.notes[i].name == "options") { // a line break becomes a blank
            EXPECT_EQ(text, "--reflectance 0.5,<0.4>&\"x\" 'y' ρ second line");
        } else if (field.notes[i].name == "residuals") {
            EXPECT_EQ(text, "1 0.1 1e-17 0.3333333333333333");
        } else {
            EXPECT_EQ(text, std::get<std::string>(field.notes[i].value)) << field.notes[i].name;
        }
    }
    FieldFile cloud;
    cloud.points = {{0, 0, 0}, {1, 2, 3}};
    write_field(cloud, scratch / "cloud.ply");
    expect_same(read_field(scratch / "cloud.ply"), cloud);
}

TEST(FieldReader, ReadsEveryFormatOfPly) {
    const ScratchDirectory scratch;
    const auto header = [](const std::string& format) {
        return "ply\nformat " + format +
               " 1.0\ncomment made by hand\ncomment unit: metres\nelement vertex 4\nproperty double x\nproperty double "
               "y\nproperty double z\nproperty double quality\nproperty list uchar double extra\nproperty short "
               "number\nelement face 1\nproperty list uchar int vertex_index\nproperty uchar group\nelement edge "
               "1\nproperty int a\nend_header\n";
    };
    const std::string text =
        header("ascii") + "0 0 0 0.5 0 -1\n1 0 0 1.5 2 7 8 -2\n1 1 0 2.5 0 -3\n0 1 0 3.5 0 -4\n" + "4 0 1 2 3 9\n17\n";
    const auto binary = [&](bool big) {
        std::string body;
        const auto put = [&](auto value) {
            char bytes[sizeof value];
            std::memcpy(bytes, &value, sizeof value);
            if (big != (std::endian::native == std::endian::big)) {
                std::reverse(bytes, bytes + sizeof value);
            }
            body.append(bytes, sizeof value);
        };
        const double places[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (int p = 0; p < 4; ++p) {
            for (const double c : {places[p][0], places[p][1], 0.0, 0.5 + p}) {
                put(c);
            }
            put(static_cast<std::uint8_t>(p == 1 ? 2 : 0));
            if (p == 1) {
                put(7.0);
                put(8.0);
            }
            put(static_cast<std::int16_t>(-1 - p));
        }
        put(std::uint8_t{4});
        for (const std::int32_t corner : {0, 1, 2, 3}) {
            put(corner);
        }
        put(std::uint8_t{9});
        put(std::int32_t{17});
        return header(big ? "binary_big_endian" : "binary_little_endian") + body;
    };
    FieldFile expected;
    expected.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    expected.triangles = {{0, 1, 2}, {0, 2, 3}};
    Values quality(4, 1);
    quality << 0.5, 1.5, 2.5, 3.5;
    expected.point_arrays = {{"quality", "", {}, quality},
                             {"number", "", {}, std::vector<std::int32_t>{-1, -2, -3, -4}}};
    expected.cell_arrays = {{"group", "", {}, std::vector<std::uint8_t>{9, 9}}};
    expected.notes = {{"comment", "made by hand"}, {"unit", "metres"}};
    for (const std::string& content : {text, binary(false), binary(true)}) {
        const FieldFile file = read_text(scratch, "out.ply", content);
        expect_same(file, expected);
        EXPECT_EQ(file.quality, "quality");
        // Cut short anywhere it is no PLY file; only the last line end of a text may be missing.
        const std::size_t whole = content.size() - (content == text ? 2 : 0);
        for (std::size_t size = 0; size < whole; size += size < 300 ? 37 : 7) {
            EXPECT_THAT([&] { read_text(scratch, "cut.ply", content.substr(0, size)); },
                        ThrowsMessage<InputError>(HasSubstr("cut.ply")))
                << size;
        }
        EXPECT_THROW(read_text(scratch, "more.ply", content + "1 "), InputError);
    }
    const auto refused = [&](const std::string& from, const std::string& to, const char* why) {
        std::string content = text;
        content.replace(content.find(from), from.size(), to);
        EXPECT_THAT([&] { read_text(scratch, "bad.ply", content); }, ThrowsMessage<InputError>(HasSubstr(why))) << to;
    };
    refused("3 9\n", "3 256\n", "256 is out of the range of group");
    refused("8 -2", "8 -40000", "-40000 is out of the range of number");
    refused("8 -2", "8 -2.5", "bad.ply");
    refused("4 0 1 2 3", "4 0 1 2 4", "cell 1 has a corner at point 4");
    refused("4 0 1 2 3", "-4 0 1 2 3", "is impossible");
    refused("1 1 0 2.5", "1 nan 0 2.5", "point 3 has a non-finite coordinate");
    refused("vertex 4", "vertex 4000000000", "more data than follow");
}

TEST(FieldReader, OtherFilesAreRefusedWithTheRemedy) {
    const ScratchDirectory scratch;
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const auto refused = [&](const std::string& name, const std::string& content, const char* why) {
        EXPECT_THAT([&] { read_text(scratch, name, content); },
                    ThrowsMessage<InputError>(testing::AllOf(HasSubstr(name), HasSubstr(why))));
    };
    EXPECT_THAT([&] { read_field(scratch / "missing.vtp"); }, ThrowsMessage<InputError>(HasSubstr("cannot be opened")));
    EXPECT_THAT([&] { read_field(scratch.path()); }, ThrowsMessage<InputError>(HasSubstr("is a directory")));
    refused("a.vtk", "# vtk DataFile Version 3.0\n", "save it as VTK PolyData (.vtp)");
    refused("a.vtp", "", "is empty");
    refused("b.vtp", "# vtk DataFile Version 3.0\n", "is not a complete VTK XML PolyData file");
    refused("c.vtp", std::string(3000, '\0'), "is not a complete VTK XML PolyData file");
    refused("d.vtp", R"(<VTKFile type="ImageData"><ImageData></ImageData></VTKFile>)", "is not a complete");
    refused("e.vtp",
            R"(<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="99999999999999" NumberOfPolys="0">)"
            R"(<Points/></Piece></PolyData></VTKFile>)",
            "NumberOfPoints is not possible in a file of this size");
    refused("a.ply", "OFF\n", "this is not a PLY file");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(FieldReader, DamagedVtpIsRefusedOrReadAndNothingIsPrinted) {
    const ScratchDirectory scratch;
    std::vector<std::string> contents;
    write_field(example(0), scratch / "out.vtp");
    contents.push_back(test::read_file(scratch / "out.vtp"));
    for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Appended}) {
        vtkNew<vtkXMLPolyDataWriter> writer;
        writer->SetInputData(zoo());
        writer->SetFileName((scratch / "out.vtp").c_str());
        writer->SetDataMode(mode);
        writer->SetEncodeAppendedData(0);
        writer->Write();
        contents.push_back(test::read_file(scratch / "out.vtp"));
    }
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    for (const std::string& content : contents) {
        const std::size_t appended = content.find("<AppendedData");
        const std::size_t whole = appended != std::string::npos ? appended : content.rfind("</VTKFile>");
        for (std::size_t size = 0; size < whole; size += 1 + whole / 41) {
            EXPECT_THAT([&] { read_text(scratch, "cut.vtp", content.substr(0, size)); },
                        ThrowsMessage<InputError>(HasSubstr("cut.vtp")))
                << size << " of " << content.size();
        }
        for (std::size_t place = 0; place < content.size(); place += 1 + content.size() / 83) {
            std::string damaged = content;
            damaged[place] = damaged[place] == '7' ? '1' : '7';
            try {
                const FieldFile file = read_text(scratch, "damaged.vtp", damaged);
                for (const auto& triangle : file.triangles) {
                    for (const Index corner : triangle) {
                        EXPECT_LT(corner, file.points.size());
                    }
                }
            } catch (const InputError& error) {
                EXPECT_THAT(error.what(), HasSubstr("damaged.vtp"));
            }
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

/// A file with one point whose coordinates are the packed array `data`, in base64.
std::string packed_point(const std::string& data) {
    return "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\" "
           "compressor=\"vtkZLibDataCompressor\"><PolyData><Piece NumberOfPoints=\"1\" NumberOfVerts=\"0\" "
           "NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\"><Points><DataArray type=\"Float32\" "
           "NumberOfComponents=\"3\" format=\"binary\">" +
           data + "</DataArray></Points></Piece></PolyData></VTKFile>\n";
}

TEST(FieldReader, HeadersOfPackedArraysThatCannotBeTrueAreRefused) {
    // The header counts blocks, bytes of each block unpacked, bytes of the last, and bytes of each packed.
    const ScratchDirectory scratch;
    const auto refused = [&](const std::string& data, const std::string& why) {
        EXPECT_THAT([&] { read_text(scratch, "packed.vtp", packed_point(data)); },
                    ThrowsMessage<InputError>(HasSubstr(why)));
    };
    // 1, 12, 12, 2 GiB: refused before memory is taken.
    refused("AQAAAAwAAAAMAAAAAAAAfw==", "the size of a compressed array is not possible in a file of this size");
    // 0, 32768, 12
    refused("AAAAAACAAAAMAAAA", "a compressed array has a last block, but no blocks");
    refused("AQAAAACAAAAMAAAAD=AAQAA=", "the header of a compressed array is cut short");
    // VTK divides by the size of a block: 1, 0, 12, 12; 2, 0, 12, 12, 12; 0, 0, 0.
    refused("AQAAAAAAAAAMAAAADAAAAA==", "the blocks of a compressed array have no size");
    refused("AgAAAAAAAAAMAAAADAAAAAwAAAA=", "the blocks of a compressed array have no size");
    refused("AAAAAAAAAAAAAAAA", "the blocks of a compressed array have no size");
}

/// VTK writes as many texts as the data hold, whatever the array says, and takes the encoding in either quotes.
TEST(FieldReader, MoreTextsThanTheArrayHasRoomForAreSkipped) {
    const auto block = [](const auto& values) { // behind its size
        const auto bytes = std::as_bytes(std::span(values));
        const auto size = std::bit_cast<std::array<char, 4>>(static_cast<std::uint32_t>(bytes.size()));
        std::string all(size.begin(), size.end());
        return all.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    std::string text;
    for (int i = 0; i < 300'000; ++i) {
        text += {'x', '\0'};
    }
    const std::string texts = block(text);
    const std::string points = block(std::array{0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F});
    const auto at = [&](std::size_t extra) { return "offset=\"" + std::to_string(texts.size() + extra) + "\"/>"; };
    const std::string form = "format=\"appended\" ";
    const std::string array = "<Array type=\"String\" Name=\"t\" NumberOfTuples=\"1\" " + form + "offset=\"0\"/>";
    const std::string head = "<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\" "
                             "header_type=\"UInt32\"><PolyData><FieldData>" +
                             array +
                             "</FieldData><Piece NumberOfPoints=\"3\" NumberOfVerts=\"0\" "
                             "NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"1\"><Points><DataArray "
                             "type=\"Float32\" NumberOfComponents=\"3\" " +
                             form + at(0) + "</Points><Polys><DataArray type=\"Int32\" Name=\"connectivity\" " + form +
                             at(points.size()) + "<DataArray type=\"Int32\" Name=\"offsets\" " + form +
                             at(points.size() + 16) + "</Polys></Piece></PolyData>";
    const std::string data = "_" + texts + points + block(std::array{0, 1, 2}) + block(std::array{3});
    const ScratchDirectory scratch;
    for (const std::string encoding : {"encoding=\"raw\"", "encoding='raw'", "encoding = 'raw'"}) {
        const FieldFile file = read_text(scratch, "texts.vtp",
                                         head + "<AppendedData " + encoding + ">" + data + "</AppendedData></VTKFile>");
        EXPECT_EQ(file.points.size(), 3U);
        EXPECT_EQ(file.triangles.size(), 1U);
    }
    EXPECT_THAT(
        [&] {
            read_text(scratch, "texts.vtp",
                      head + "<AppendedData encoding=\"&#114;aw\">" + data + "</AppendedData></VTKFile>");
        },
        ThrowsMessage<InputError>(HasSubstr("encoded neither as \"raw\" nor as \"base64\"")));
    // Seven times the 600 kB: all texts of a file together may have 4 MB.
    std::string many = head;
    for (const char name : std::string("abcdef")) {
        std::string another = array;
        another.replace(another.find("\"t\"") + 1, 1, 1, name);
        many.insert(many.find(array), another);
    }
    EXPECT_THAT(
        [&] {
            read_text(scratch, "texts.vtp",
                      many + "<AppendedData encoding=\"raw\">" + data + "</AppendedData></VTKFile>");
        },
        ThrowsMessage<InputError>(HasSubstr("more than 4 MB of text")));
}

/// VTK tells the terminal if a range it has written beside an array is of the wrong length.
TEST(FieldReader, VtksNotesAboutArraysAreNotRead) {
    const ScratchDirectory scratch;
    write_field(example(0), scratch / "out.vtp");
    std::string content = test::read_file(scratch / "out.vtp");
    const std::string right = "location=\"vtkDataArray\" length=\"2\"",
                      wrong = "location=\"vtkDataArray\" length=\"1\"";
    std::size_t changed = 0;
    for (std::size_t place = 0; (place = content.find(right, place)) != std::string::npos; ++changed) {
        content.replace(place, right.size(), wrong);
    }
    ASSERT_GT(changed, 0U);
    testing::internal::CaptureStderr();
    expect_same(read_text(scratch, "wrong.vtp", content), read_field(scratch / "out.vtp"));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

} // namespace
} // namespace difusa::field_reader_test
