#include <difusa/core/error.h>
#include <difusa/io/field_file.h>
#include <difusa/io/field_reader.h>

#include <example_field.h>
#include <file_size_limit.h>
#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLPolyDataReader.h>

#include <bit>

namespace difusa::vtp_writer_test {
namespace {

using test::awkward_values;
using test::FileSizeLimit;
using test::ScratchDirectory;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Names = std::set<std::string>;

FieldFile example() {
    return test::example_field(2, "");
}

vtkSmartPointer<vtkPolyData> read(const std::filesystem::path& file) {
    vtkNew<vtkXMLPolyDataReader> reader;
    EXPECT_EQ(reader->CanReadFile(file.c_str()), 1);
    reader->SetFileName(file.c_str());
    reader->Update();
    EXPECT_EQ(reader->GetErrorCode(), 0u);
    return reader->GetOutput();
}

void expect_same_bits(vtkDataArray* array, const double* expected, std::size_t count) {
    auto* doubles = vtkDoubleArray::SafeDownCast(array);
    ASSERT_NE(doubles, nullptr);
    ASSERT_EQ(static_cast<std::size_t>(doubles->GetNumberOfValues()), count);
    for (std::size_t i = 0; i < count; ++i) {
        ASSERT_EQ(std::bit_cast<std::uint64_t>(doubles->GetValue(static_cast<vtkIdType>(i))),
                  std::bit_cast<std::uint64_t>(expected[i]));
    }
}

template <typename Array, typename T> void expect_values(vtkDataArray* array, const std::vector<T>& expected) {
    auto* typed = Array::SafeDownCast(array);
    ASSERT_NE(typed, nullptr);
    ASSERT_EQ(static_cast<std::size_t>(typed->GetNumberOfValues()), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        ASSERT_EQ(typed->GetValue(static_cast<vtkIdType>(i)), expected[i]);
    }
}

TEST(VtpWriter, VtkReadsBackEverything) {
    const ScratchDirectory scratch;
    const FieldFile field = example();
    write_field(field, scratch / "out.vtp");
    EXPECT_EQ(scratch.names(), Names{"out.vtp"});
    const auto mesh = read(scratch / "out.vtp");

    ASSERT_EQ(static_cast<std::size_t>(mesh->GetNumberOfPoints()), field.points.size());
    expect_same_bits(mesh->GetPoints()->GetData(), field.points[0].data(), 3 * field.points.size());
    ASSERT_EQ(static_cast<std::size_t>(mesh->GetNumberOfPolys()), field.triangles.size());
    EXPECT_EQ(mesh->GetNumberOfCells(), mesh->GetNumberOfPolys());
    vtkNew<vtkIdList> corners;
    for (std::size_t t = 0; t < field.triangles.size(); ++t) {
        mesh->GetPolys()->GetCellAtId(static_cast<vtkIdType>(t), corners);
        ASSERT_EQ(corners->GetNumberOfIds(), 3);
        for (int k = 0; k < 3; ++k) {
            ASSERT_EQ(corners->GetId(k), field.triangles[t][static_cast<std::size_t>(k)]);
        }
    }

    vtkPointData* points = mesh->GetPointData();
    EXPECT_EQ(points->GetNumberOfArrays(), 4);
    ASSERT_NE(points->GetNormals(), nullptr);
    EXPECT_STREQ(points->GetNormals()->GetName(), "Normals");
    expect_same_bits(points->GetNormals(), field.normals[0].data(), 3 * field.normals.size());
    for (const std::size_t a : {0u, 1u}) {
        const FieldArray& array = field.point_arrays[a];
        const Values& values = std::get<Values>(array.data);
        vtkDataArray* found = points->GetArray(array.name.c_str());
        ASSERT_NE(found, nullptr);
        EXPECT_EQ(found->GetNumberOfComponents(), static_cast<int>(values.cols()));
        for (std::size_t c = 0; c < array.components.size(); ++c) {
            EXPECT_STREQ(found->GetComponentName(static_cast<vtkIdType>(c)), array.components[c].c_str());
        }
        expect_same_bits(found, values.data(), static_cast<std::size_t>(values.size()));
    }
    vtkInformation* information = points->GetArray("radiosity")->GetInformation();
    ASSERT_TRUE(information->Has(vtkDataArray::UNITS_LABEL()));
    EXPECT_STREQ(information->Get(vtkDataArray::UNITS_LABEL()), "W/m^2");
    EXPECT_FALSE(points->GetArray("luminance")->GetInformation()->Has(vtkDataArray::UNITS_LABEL()));
    ASSERT_NE(points->GetScalars(), nullptr);
    EXPECT_STREQ(points->GetScalars()->GetName(), "display_rgb");
    EXPECT_EQ(points->GetScalars()->GetNumberOfComponents(), 3);
    expect_values<vtkUnsignedCharArray>(points->GetScalars(),
                                        std::get<std::vector<std::uint8_t>>(field.point_arrays[2].data));

    EXPECT_EQ(mesh->GetCellData()->GetNumberOfArrays(), 1);
    expect_values<vtkIntArray>(mesh->GetCellData()->GetArray("original_face_id"),
                               std::get<std::vector<std::int32_t>>(field.cell_arrays[0].data));
}

TEST(VtpWriter, NotesAreFieldData) {
    const ScratchDirectory scratch;
    const FieldFile field = example();
    write_field(field, scratch / "out.vtp");
    const auto mesh = read(scratch / "out.vtp");
    vtkFieldData* notes = mesh->GetFieldData();
    EXPECT_EQ(notes->GetNumberOfArrays(), 4);
    for (const FieldNote& note : field.notes) {
        if (const auto* text = std::get_if<std::string>(&note.value)) {
            auto* array = vtkStringArray::SafeDownCast(notes->GetAbstractArray(note.name.c_str()));
            ASSERT_NE(array, nullptr) << note.name;
            ASSERT_EQ(array->GetNumberOfValues(), 1);
            EXPECT_EQ(array->GetValue(0), *text);
        } else {
            const auto& numbers = std::get<std::vector<double>>(note.value);
            expect_same_bits(notes->GetArray(note.name.c_str()), numbers.data(), numbers.size());
        }
    }
}

/// VTK's reader gives back the very names, whatever XML makes of their characters.
TEST(VtpWriter, NamesOfAnyCharacters) {
    const ScratchDirectory scratch;
    const std::string awkward = "Lamp & \"shade\" <1> 'ρ' &amp; \t|\n|\r|\u00e9\U0001f4a1";
    FieldFile field;
    field.points = {{0, 0, 0}, {1, 2, 3}};
    field.point_arrays.push_back({awkward, "<&\">", {"R & B", "<\"G\">"}, awkward_values(2, 2)});
    field.point_arrays.push_back({"rgb " + awkward, "", {"R", "G", "<B>"}, std::vector<std::uint8_t>(6, 7)});
    field.cell_arrays.push_back({"cell " + awkward, "", {"\""}, std::vector<std::int32_t>{4, 5}});
    field.active_colours = "rgb " + awkward;
    field.notes = {{"text " + awkward, awkward}, {"numbers " + awkward, std::vector<double>{1.0}}};
    write_field(field, scratch / "out.vtp");

    const auto cloud = read(scratch / "out.vtp");
    vtkDataArray* array = cloud->GetPointData()->GetArray(awkward.c_str());
    ASSERT_NE(array, nullptr);
    EXPECT_STREQ(array->GetComponentName(0), "R & B");
    EXPECT_STREQ(array->GetComponentName(1), "<\"G\">");
    EXPECT_STREQ(array->GetInformation()->Get(vtkDataArray::UNITS_LABEL()), "<&\">");
    ASSERT_NE(cloud->GetPointData()->GetScalars(), nullptr);
    EXPECT_EQ(cloud->GetPointData()->GetScalars()->GetName(), "rgb " + awkward);
    EXPECT_NE(cloud->GetCellData()->GetArray(("cell " + awkward).c_str()), nullptr);
    auto* text = vtkStringArray::SafeDownCast(cloud->GetFieldData()->GetAbstractArray(("text " + awkward).c_str()));
    ASSERT_NE(text, nullptr);
    EXPECT_EQ(text->GetValue(0), awkward);
    EXPECT_NE(cloud->GetFieldData()->GetArray(("numbers " + awkward).c_str()), nullptr);

    const FieldFile back = read_field(scratch / "out.vtp");
    ASSERT_EQ(back.point_arrays.size(), 2u);
    EXPECT_EQ(back.point_arrays[0].name, awkward);
    EXPECT_EQ(back.point_arrays[0].unit, "<&\">");
    EXPECT_EQ(back.point_arrays[0].components, field.point_arrays[0].components);
    EXPECT_EQ(back.active_colours, field.active_colours);
}

TEST(VtpWriter, WhatXmlCannotHoldBecomesAnUnderscore) {
    const ScratchDirectory scratch;
    FieldFile field;
    field.points = {{0, 0, 0}};
    // A control character, half a character, one in too long a form, a surrogate, U+FFFE, beyond Unicode.
    field.point_arrays.push_back(
        {"a\x01\x7f|\xc3|\xc0\xaf|\xed\xa0\x80|\xef\xbf\xbe|\xf4\x90\x80\x80|z", "", {}, std::vector<std::int32_t>{1}});
    write_field(field, scratch / "out.vtp");
    EXPECT_STREQ(read(scratch / "out.vtp")->GetPointData()->GetArray(0)->GetName(), "a_\x7f|_|__|___|___|____|z");
}

TEST(VtpWriter, PointCloudHasAVertexForEachPoint) {
    const ScratchDirectory scratch;
    FieldFile field;
    field.points = {{0, 0, 0}, {1, 2, 3}, {-1, 1e-300, 1e100}};
    field.point_arrays.push_back({"radius", "m", {}, Values(Values::Constant(3, 1, 0.1))});
    field.cell_arrays.push_back({"region", "", {}, std::vector<std::int32_t>{4, 5, 6}});
    write_field(field, scratch / "sites.vtp");
    const auto cloud = read(scratch / "sites.vtp");
    EXPECT_EQ(cloud->GetNumberOfPoints(), 3);
    EXPECT_EQ(cloud->GetNumberOfVerts(), 3);
    EXPECT_EQ(cloud->GetNumberOfCells(), 3);
    vtkNew<vtkIdList> corner;
    for (vtkIdType i = 0; i < 3; ++i) {
        cloud->GetVerts()->GetCellAtId(i, corner);
        ASSERT_EQ(corner->GetNumberOfIds(), 1);
        EXPECT_EQ(corner->GetId(0), i);
    }
    expect_values<vtkIntArray>(cloud->GetCellData()->GetArray("region"), std::vector<std::int32_t>{4, 5, 6});
}

TEST(VtpWriter, NothingAtAllIsAFileToo) {
    const ScratchDirectory scratch;
    write_field({}, scratch / "empty.vtp");
    EXPECT_EQ(read(scratch / "empty.vtp")->GetNumberOfPoints(), 0);
}

TEST(VtpWriter, DataStandInlineAsTextCompressed) {
    const ScratchDirectory scratch;
    write_field(example(), scratch / "out.vtp");
    const std::string text = test::read_file(scratch / "out.vtp");
    EXPECT_THAT(text, HasSubstr("vtkZLibDataCompressor"));
    EXPECT_THAT(text, Not(HasSubstr("AppendedData")));
    EXPECT_THAT(text, Not(HasSubstr("format=\"ascii\"")));
}

TEST(VtpWriter, FullDiskIsAnErrorWhereverItStrikes) {
    const ScratchDirectory scratch;
    write_field(example(), scratch / "whole.vtp");
    const auto size = static_cast<rlim_t>(std::filesystem::file_size(scratch / "whole.vtp"));
    write_whole_file(scratch / "out.vtp", "old");
    for (const rlim_t limit :
         {rlim_t{0}, rlim_t{1}, rlim_t{100}, size / 4, size / 2, size - 5000, size - 20, size - 1}) {
        testing::internal::CaptureStderr();
        {
            const FileSizeLimit full(limit);
            EXPECT_THAT([&] { write_field(example(), scratch / "out.vtp"); },
                        ThrowsMessage<ResourceError>(HasSubstr((scratch / "out.vtp").string())))
                << limit << " of " << size;
        }
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
        EXPECT_EQ(test::read_file(scratch / "out.vtp"), "old");
        EXPECT_EQ(scratch.names(), (Names{"out.vtp", "whole.vtp"}));
    }
}

TEST(WriteField, RefusesArraysThatDoNotFit) {
    const ScratchDirectory scratch;
    const auto refused = [&](auto spoil) {
        FieldFile field = example();
        spoil(field);
        EXPECT_THROW(write_field(field, scratch / "out.vtp"), InternalError);
    };
    refused([](FieldFile& f) { f.normals.pop_back(); });
    refused([](FieldFile& f) { f.triangles[5][1] = static_cast<Index>(f.points.size()); });
    refused([](FieldFile& f) { f.point_arrays[0].components.pop_back(); });
    refused([](FieldFile& f) { f.point_arrays[1].data = awkward_values(7, 1); });
    refused([](FieldFile& f) { std::get<std::vector<std::int32_t>>(f.cell_arrays[0].data).pop_back(); });
    refused([](FieldFile& f) { f.active_colours = "radiosity"; });
    refused([](FieldFile& f) { f.quality = "radiosity"; });
    refused([](FieldFile& f) { f.quality = "missing"; });
    EXPECT_TRUE(scratch.names().empty());
}

} // namespace
} // namespace difusa::vtp_writer_test
