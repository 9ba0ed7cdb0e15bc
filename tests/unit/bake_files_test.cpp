#include <difusa/bake/sensing.h>
#include <difusa/core/colour.h>
#include <difusa/output/bake_files.h>

#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/output/point_table.h>
#include <difusa/version.h>

#include <file_size_limit.h>
#include <meshes.h>
#include <scratch_directory.h>
#include <support/plugins.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <numeric>

namespace difusa::bake_files_test {
namespace {

using nlohmann::json;
using test::ScratchDirectory;
using testing::ElementsAre;
using testing::HasSubstr;
using Names = std::set<std::string>;

/// The Cornell box, small: three channels, a lamp, polygons, several materials.
const BakeResult& coloured() {
    static const BakeResult result = [] {
        BakeOptions options;
        options.sites = 150;
        options.rays = 32;
        options.seed = 0xfedcba9876543210; // no double holds it
        options.basis = "radial";
        return bake(Registry::load(), DIFUSA_TEST_DATA "/cornell_box.obj", options, Execution{});
    }();
    return result;
}

/// A grey bowl under the sky that is assumed.
const BakeResult& grey() {
    static const BakeResult result = [] {
        BakeOptions options;
        options.sites = 100;
        options.rays = 16;
        return bake(Registry::load(), DIFUSA_TEST_DATA "/bowl.ply", options, Execution{});
    }();
    return result;
}

vtkSmartPointer<vtkPolyData> read(const std::filesystem::path& file) {
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName(file.c_str());
    reader->Update();
    return reader->GetOutput();
}

std::vector<std::string> components(vtkDataArray* array) {
    std::vector<std::string> names;
    for (vtkIdType c = 0; array->HasAComponentName() && c < array->GetNumberOfComponents(); ++c) {
        names.emplace_back(array->GetComponentName(c));
    }
    return names;
}

std::string unit(vtkDataArray* array) {
    const char* text = array->GetInformation()->Get(vtkDataArray::UNITS_LABEL());
    return text == nullptr ? "" : text;
}

/// A double array of the name with these values, in W/m² where `flux`.
void expect_values(vtkFieldData* data, const char* name, const Values& values, bool flux = true) {
    SCOPED_TRACE(name);
    auto* array = vtkDoubleArray::SafeDownCast(data->GetArray(name));
    ASSERT_NE(array, nullptr);
    ASSERT_EQ(array->GetNumberOfTuples(), values.rows());
    ASSERT_EQ(array->GetNumberOfComponents(), values.cols());
    EXPECT_EQ(unit(array), flux ? "W/m^2" : "");
    if (values.cols() == 3) {
        EXPECT_THAT(components(array), ElementsAre("R", "G", "B"));
    }
    for (Eigen::Index i = 0; i < values.size(); ++i) {
        ASSERT_EQ(array->GetValue(i), values.data()[i]);
    }
}

std::string text_note(vtkPolyData* mesh, const char* name) {
    auto* array = vtkStringArray::SafeDownCast(mesh->GetFieldData()->GetAbstractArray(name));
    EXPECT_NE(array, nullptr) << name;
    return array == nullptr || array->GetNumberOfValues() != 1 ? "" : std::string(array->GetValue(0));
}

std::vector<double> number_note(vtkPolyData* mesh, const char* name) {
    auto* array = vtkDoubleArray::SafeDownCast(mesh->GetFieldData()->GetArray(name));
    EXPECT_NE(array, nullptr) << name;
    return array == nullptr ? std::vector<double>{}
                            : std::vector<double>(array->GetPointer(0), array->GetPointer(array->GetNumberOfValues()));
}

TEST(BakeFiles, APhotometricFieldHoldsLuxAndCandelas) {
    // Under a sky of 1 W/m^2 in each channel, a square receives 683 lux; what reflects half of it has 683 / (2 pi)
    // cd/m^2.
    Scene scene;
    scene.mesh = test::grid(2, 2);
    scene.materials.emplace_back();
    scene.sky = Rgb::Ones();
    BakeOptions options;
    options.sites = 50;
    options.units = "photometric";
    options.face_centres = true;
    options.at = {{Vec3(0.3, 0.4, 0.0), {}}, {Vec3(0.3, 0.4, 1.0), Vec3::UnitZ()}};
    options.grids = {{"0", 0.5, 0.2, 0.0}};
    const BakeResult result = bake(test::registry(), scene, "square", options, Execution{});
    const FieldFile field = field_of(result);
    EXPECT_EQ(field.quality, "luminance");
    const auto check = [](const std::vector<FieldArray>& arrays, const std::string& name, const std::string& unit,
                          double value) {
        const auto array =
            std::find_if(arrays.begin(), arrays.end(), [&](const FieldArray& a) { return a.name == name; });
        ASSERT_NE(array, arrays.end()) << name;
        EXPECT_EQ(array->unit, unit);
        EXPECT_LT((std::get<Values>(array->data).array() - value).abs().maxCoeff(), 1e-9) << name;
    };
    for (const std::vector<FieldArray>* arrays : {&field.point_arrays, &field.cell_arrays}) {
        check(*arrays, "illuminance", "lx", 683.0);
        check(*arrays, "illuminance_direct", "lx", 683.0);
        check(*arrays, "illuminance_indirect", "lx", 0.0);
        check(*arrays, "luminance", "cd/m^2", 683.0 / (2.0 * std::numbers::pi));
    }
    const GridSummary grid = summary_of_grid(result, 0);
    EXPECT_NEAR(grid.mean, 683.0, 1e-9);
    EXPECT_NEAR(grid.uniformity, 1.0, 1e-12);
    EXPECT_THAT(summary_of(result), HasSubstr("illuminance (lx) minimum 683, mean 683, maximum 683, uniformity"));
    EXPECT_THAT(point_table(result), HasSubstr(",luminance,illuminance,illuminance_direct,illuminance_indirect,"
                                               "error_estimate,irradiance_error,illuminance_error\n"));
    options.light_groups = true;
    const BakeResult in_groups = bake(test::registry(), scene, "square", options, Execution{});
    const FieldFile by_group = field_of(in_groups);
    for (const std::vector<FieldArray>* arrays : {&by_group.point_arrays, &by_group.cell_arrays}) {
        check(*arrays, "illuminance_of_sky", "lx", 683.0);
    }
    EXPECT_THAT(point_table(in_groups), HasSubstr(",illuminance_indirect,illuminance_of_sky,error_estimate,"));
    EXPECT_THAT(summary_of(result), HasSubstr("luminous flux (lm): emitted 0, from suns and point lights 0, from the "
                                              "sky 683, absorbed 341.5, "));
    const auto report = nlohmann::json::parse(report_of(result));
    EXPECT_EQ(report["options"]["units"], "photometric");
    EXPECT_EQ(report["grids"][0]["unit"], "lx");
}

TEST(BakeFiles, FieldHoldsTheBake) {
    const ScratchDirectory scratch;
    const BakeResult& result = coloured();
    write_field(field_of(result), scratch / "out.vtp");
    const auto mesh = read(scratch / "out.vtp");
    const auto vertices = static_cast<vtkIdType>(result.mesh.vertices.size());
    const auto triangles = static_cast<vtkIdType>(result.mesh.triangles.size());
    EXPECT_EQ(mesh->GetNumberOfPoints(), vertices);
    EXPECT_EQ(mesh->GetNumberOfPolys(), triangles);
    EXPECT_EQ(mesh->GetNumberOfCells(), triangles);

    vtkPointData* points = mesh->GetPointData();
    EXPECT_EQ(points->GetNumberOfArrays(), 14);
    expect_values(points, "radiosity", result.output.B);
    expect_values(points, "irradiance", result.output.H);
    expect_values(points, "irradiance_direct", result.output.H_direct);
    expect_values(points, "irradiance_indirect", result.output.H_indirect);
    expect_values(points, "emission", result.output.E);
    expect_values(points, "reflectance", result.output.rho, false);
    const Eigen::Vector3d weights(0.2126, 0.7152, 0.0722);
    expect_values(points, "radiosity_weighted", result.output.B * weights);
    expect_values(points, "irradiance_weighted", result.output.H * weights);
    expect_values(points, "error_estimate", result.errors->error);
    expect_values(points, "irradiance_error", result.errors->irradiance);
    expect_values(points, "error_noise", result.errors->noise);
    expect_values(points, "error_discretisation", result.errors->discretisation);
    EXPECT_TRUE(result.output.B.allFinite());
    EXPECT_TRUE((result.errors->error.array() >= result.errors->noise.array()).all());
    EXPECT_TRUE((result.errors->error.array() >= result.errors->discretisation.array()).all());

    auto* display = vtkUnsignedCharArray::SafeDownCast(points->GetScalars());
    ASSERT_NE(display, nullptr);
    EXPECT_STREQ(display->GetName(), "display_rgb");
    EXPECT_EQ(display->GetNumberOfTuples(), vertices);
    EXPECT_THAT(components(display), ElementsAre("R", "G", "B"));
    const std::vector<double> exposure = number_note(mesh, "display_exposure");
    ASSERT_THAT(exposure, ElementsAre(display_exposure(result)));
    for (vtkIdType i = 0; i < display->GetNumberOfValues(); ++i) {
        ASSERT_EQ(display->GetValue(i), std::lround(255.0 * srgb(exposure[0] * result.output.B.data()[i])));
    }
    ASSERT_NE(points->GetNormals(), nullptr);
    EXPECT_STREQ(points->GetNormals()->GetName(), "Normals");
    for (vtkIdType v = 0; v < vertices; ++v) {
        ASSERT_NEAR(Vec3(points->GetNormals()->GetTuple3(v)).norm(), 1.0, 1e-14);
    }

    vtkCellData* cells = mesh->GetCellData();
    EXPECT_EQ(cells->GetNumberOfArrays(), 2);
    auto* face = vtkIntArray::SafeDownCast(cells->GetArray("original_face_id"));
    auto* material = vtkIntArray::SafeDownCast(cells->GetArray("material_id"));
    ASSERT_NE(face, nullptr);
    ASSERT_NE(material, nullptr);
    std::set<int> faces, materials;
    for (vtkIdType t = 0; t < triangles; ++t) {
        faces.insert(face->GetValue(t));
        materials.insert(material->GetValue(t));
    }
    EXPECT_EQ(faces.size(), result.diagnosis.file_faces); // every face of the file, from 0
    EXPECT_EQ(*faces.begin(), 0);
    EXPECT_EQ(*faces.rbegin(), static_cast<int>(result.diagnosis.file_faces) - 1);
    EXPECT_EQ(materials.size(), result.scene->materials.size());
}

/// The arrays of light groups have their own names, whatever lights are called.
TEST(BakeFiles, GroupsOverwriteNothing) {
    const ScratchDirectory scratch;
    const std::vector<std::string> names{"direct", "indirect", "Lamp & \"shade\" <1>"};
    BakeOptions options;
    options.sites = 60;
    options.rays = 16;
    options.light_groups = options.face_centres = true;
    for (const std::string& name : names) {
        PointLight light{Vec3(0.0, 0.0, 1.0 + static_cast<double>(name.size())), Rgb::Ones()};
        light.name = name;
        options.point_lights.push_back(light);
    }
    options.at.push_back({Vec3::Zero(), {}});
    const BakeResult result = bake(Registry::load(), DIFUSA_TEST_DATA "/bowl.ply", options, Execution{});
    write_field(field_of(result), scratch / "out.vtp");
    const auto mesh = read(scratch / "out.vtp");
    ASSERT_EQ(result.output.groups.size(), names.size());
    for (std::size_t g = 0; g < names.size(); ++g) {
        ASSERT_EQ(result.output.groups[g].name, names[g]);
        expect_values(mesh->GetPointData(), ("radiosity_of_" + names[g]).c_str(), result.output.groups[g].B);
        expect_values(mesh->GetPointData(), ("irradiance_of_" + names[g]).c_str(), result.output.groups[g].H);
        expect_values(mesh->GetCellData(), ("irradiance_of_" + names[g]).c_str(), result.centres->groups[g].H);
    }
    expect_values(mesh->GetPointData(), "irradiance_direct", result.output.H_direct);
    expect_values(mesh->GetPointData(), "irradiance_indirect", result.output.H_indirect);
    const std::string table = point_table(result);
    EXPECT_THAT(table.substr(0, table.find('\n')),
                AllOf(HasSubstr(",irradiance_direct_R,"), HasSubstr(",irradiance_of_direct_R,"),
                      HasSubstr(",\"radiosity_of_Lamp & \"\"shade\"\" <1>_B\",")));
}

TEST(BakeFiles, FieldDataTellHowItWasMade) {
    const ScratchDirectory scratch;
    const BakeResult& result = coloured();
    write_field(field_of(result), scratch / "out.vtp");
    const auto mesh = read(scratch / "out.vtp");
    EXPECT_EQ(text_note(mesh, "difusa_version"), version());
    for (const auto& [name, number] : library_versions()) {
        EXPECT_THAT(text_note(mesh, "library_versions"), HasSubstr(name + " " + number));
    }
    EXPECT_EQ(text_note(mesh, "input"), DIFUSA_TEST_DATA "/cornell_box.obj");
    EXPECT_EQ(text_note(mesh, "transport"), "gather");
    EXPECT_THAT(text_note(mesh, "basis"), testing::StartsWith("radial:width="));
    for (const char* kind : {"sampler", "visibility", "directions", "solver"}) {
        EXPECT_NE(text_note(mesh, kind), "") << kind;
    }
    EXPECT_EQ(text_note(mesh, "seed"), "18364758544493064720");
    EXPECT_THAT(number_note(mesh, "sites"), ElementsAre(static_cast<double>(result.sites->size())));
    EXPECT_THAT(number_note(mesh, "spacing"), ElementsAre(result.sites->spacing));
    EXPECT_THAT(number_note(mesh, "rays_per_site"), ElementsAre(32.0));
    EXPECT_THAT(number_note(mesh, "iterations"), ElementsAre(result.solution.solve.iterations));
    EXPECT_THAT(number_note(mesh, "residual"), ElementsAre(result.solution.solve.residual));
    EXPECT_THAT(number_note(mesh, "spectral_radius"), ElementsAre(result.solution.spectral_radius));
    EXPECT_THAT(number_note(mesh, "sky"), ElementsAre(0.0, 0.0, 0.0));
    EXPECT_EQ(number_note(mesh, "phase_seconds").size(), result.journal.seconds().size());
    EXPECT_THAT(text_note(mesh, "phases"), HasSubstr("transport, "));
    EXPECT_EQ(text_note(mesh, "material_names"), "white\nred\ngreen\nlamp");
}

TEST(BakeFiles, AllNotesSurvive) {
    const ScratchDirectory scratch;
    BakeResult result = grey();
    ASSERT_THAT(result.journal.notes(), testing::Contains(HasSubstr("a uniform sky of irradiance 1 W/m^2 is assumed")));
    result.journal = {};
    result.journal.note("the first");
    result.journal.note("the second");
    write_field(field_of(result), scratch / "out.vtp");
    EXPECT_EQ(text_note(read(scratch / "out.vtp"), "notes"), "the first\nthe second");
}

TEST(BakeFiles, SitesAreAPointCloud) {
    const ScratchDirectory scratch;
    const BakeResult& result = coloured();
    write_field(sites_of(result), scratch / "sites.vtp");
    const auto cloud = read(scratch / "sites.vtp");
    const auto count = static_cast<vtkIdType>(result.sites->size());
    EXPECT_EQ(cloud->GetNumberOfPoints(), count);
    EXPECT_EQ(cloud->GetNumberOfVerts(), count);
    EXPECT_EQ(cloud->GetNumberOfCells(), count);
    vtkPointData* points = cloud->GetPointData();
    EXPECT_EQ(points->GetNumberOfArrays(), 13);
    const auto column = [](const std::vector<double>& values) {
        return Values(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
    };
    expect_values(points, "radius", column(result.sites->radius), false);
    expect_values(points, "area", column(result.sites->area), false);
    expect_values(points, "coefficient", result.field().parts().smooth);
    expect_values(points, "irradiance", result.solution.irradiance);
    Values E(count, 3), rho(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const SurfacePoint& site = result.sites->points[static_cast<std::size_t>(i)];
        E.row(i) = result.scene->emission(site).matrix().transpose();
        rho.row(i) = result.scene->reflectance(site).matrix().transpose();
    }
    expect_values(points, "emission", E);
    expect_values(points, "reflectance", rho, false);
    expect_values(points, "radiosity", E + rho.cwiseProduct(result.solution.irradiance));
    ASSERT_NE(points->GetNormals(), nullptr);
    EXPECT_NE(vtkIntArray::SafeDownCast(points->GetArray("original_face_id")), nullptr);
    EXPECT_NE(vtkIntArray::SafeDownCast(points->GetArray("region")), nullptr);
    EXPECT_NE(vtkUnsignedCharArray::SafeDownCast(points->GetArray("display_rgb")), nullptr);
}

/// The field takes the values at the sites that were solved for, in each of the channels.
TEST(BakeFiles, CoefficientsInterpolateTheSites) {
    const BakeResult& result = coloured();
    ASSERT_EQ(result.channels, 3);
    // The shadow rays of lamps at the sites are those of the bake.
    const Irradiance light =
        result.field().evaluate(result.sites->points, result.options.seed, "direct light", Execution{});
    const Values H = light.direct + light.indirect;
    EXPECT_LE((light.direct - result.solution.direct).cwiseAbs().maxCoeff(),
              1e-12 * result.field().parts().smooth.cwiseAbs().maxCoeff());
    // A backward stable solve: residuals of rounding times the size of the coefficients and the elements at a place.
    const double size = result.field().parts().smooth.cwiseAbs().maxCoeff();
    EXPECT_LE((H - result.solution.irradiance).cwiseAbs().maxCoeff(), 1e-12 * size);
    EXPECT_LT(size, 1e3 * result.solution.irradiance.maxCoeff());
}

TEST(BakeFiles, AGreySceneIsWrittenInThreeEqualChannels) {
    const ScratchDirectory scratch;
    const BakeResult& result = grey();
    EXPECT_EQ(result.channels, 1);
    EXPECT_EQ(result.solution.irradiance.cols(), 1);
    write_field(sites_of(result), scratch / "sites.vtp");
    write_field(field_of(result), scratch / "out.vtp");
    for (const char* file : {"sites.vtp", "out.vtp"}) {
        const auto mesh = read(scratch / file);
        vtkDataArray* radiosity = mesh->GetPointData()->GetArray("radiosity");
        ASSERT_EQ(radiosity->GetNumberOfComponents(), 3);
        for (vtkIdType i = 0; i < radiosity->GetNumberOfTuples(); ++i) {
            const double* tuple = radiosity->GetTuple3(i);
            ASSERT_EQ(tuple[0], tuple[1]);
            ASSERT_EQ(tuple[0], tuple[2]);
            ASSERT_GT(tuple[0], 0.0);
        }
    }
}

TEST(BakeFiles, PlyIsForMeshLab) {
    const ScratchDirectory scratch;
    for (const FieldFile& field : {field_of(coloured()), sites_of(coloured())}) {
        write_field(field, scratch / "out.ply");
        const std::string text = test::read_file(scratch / "out.ply");
        const std::string header = text.substr(0, text.find("end_header\n"));
        EXPECT_THAT(header, testing::StartsWith("ply\nformat binary_little_endian 1.0\n"));
        EXPECT_THAT(header, HasSubstr("element vertex " + std::to_string(field.points.size()) + "\n"));
        for (const char* property : {"uchar red", "uchar green", "uchar blue", "float quality", "float nx", "float ny",
                                     "float nz", "double x", "double y", "double z"}) {
            EXPECT_THAT(header, HasSubstr(std::string("\nproperty ") + property + "\n"));
        }
        EXPECT_THAT(header, HasSubstr("\ncomment seed: 18364758544493064720\n"));
        EXPECT_THAT(header, testing::Not(HasSubstr("flags")));
        if (!field.triangles.empty()) {
            EXPECT_THAT(header, HasSubstr("element face " + std::to_string(field.triangles.size()) +
                                          "\nproperty list uchar int vertex_indices\n"));
        }
    }
}

TEST(BakeFiles, ReportIsJson) {
    const BakeResult& result = coloured();
    const json report = json::parse(report_of(result));
    EXPECT_EQ(report["schema"], "difusa-bake-report");
    EXPECT_EQ(report["schema_version"], 4);
    EXPECT_EQ(report["difusa_version"], version());
    EXPECT_EQ(report["library_versions"].size(), library_versions().size());
    EXPECT_EQ(report["dry_run"], false);

    EXPECT_EQ(report["input"]["file"], DIFUSA_TEST_DATA "/cornell_box.obj");
    EXPECT_EQ(report["input"]["faces"], result.diagnosis.file_faces);
    EXPECT_EQ(report["input"]["points"], result.diagnosis.file_points);
    ASSERT_EQ(report["input"]["findings"].size(), result.diagnosis.findings.size());
    ASSERT_FALSE(result.diagnosis.findings.empty());
    const json& finding = report["input"]["findings"][0];
    EXPECT_EQ(finding["code"], result.diagnosis.findings[0].code);
    EXPECT_EQ(finding["count"], result.diagnosis.findings[0].count);
    EXPECT_TRUE(finding["repaired"].is_boolean());
    EXPECT_TRUE(finding["remedy"].is_string());
    EXPECT_EQ(finding["places"].size(), result.diagnosis.findings[0].places.size());
    EXPECT_EQ(report["mesh"]["area"], result.scene->mesh.area);
    EXPECT_EQ(report["mesh"]["triangles"], result.scene->mesh.triangles.size());

    EXPECT_EQ(report["options"]["seed"], 0xfedcba9876543210);
    EXPECT_EQ(report["options"]["rays"], 32);
    EXPECT_EQ(report["options"]["sites"], 150);
    EXPECT_EQ(report["sites"]["count"], result.sites->size());
    EXPECT_EQ(report["sites"]["spacing"], result.sites->spacing);
    EXPECT_EQ(report["transport"]["rays"], 32 * result.sites->size());
    EXPECT_EQ(report["transport"]["estimated_rays"], report["transport"]["rays"]);
    EXPECT_LE(report["transport"]["segments"], report["transport"]["estimated_segments"]);
    EXPECT_EQ(report["transport"]["bytes"], result.system->transport().bytes);
    EXPECT_LE(report["transport"]["bytes"], report["transport"]["estimated_bytes"]);
    EXPECT_LE(report["transport"]["largest_row_sum"], 1.0);
    EXPECT_EQ(report["transport"]["surfels"], result.system->discretisation().surfels->size());
    EXPECT_EQ(report["transport"]["area_light_triangles"], 2);
    EXPECT_EQ(report["transport"]["channels"], 3);

    EXPECT_EQ(report["solve"]["reason"], "converged");
    EXPECT_EQ(report["solve"]["iterations"], result.solution.solve.iterations);
    ASSERT_EQ(report["solve"]["residual_history"].size(), 3U);
    double last = 0.0;
    for (const json& history : report["solve"]["residual_history"]) {
        last = std::max(last, history.back().get<double>());
    }
    EXPECT_EQ(report["solve"]["residual"], last);
    EXPECT_LE(last, result.options.solve.tolerance);

    const json& energy = report["energy"];
    for (std::size_t c = 0; c < 3; ++c) {
        const double in = energy["emitted"][c].get<double>() + energy["from_sky"][c].get<double>();
        const double out = energy["absorbed"][c].get<double>() + energy["escaped"][c].get<double>() +
                           energy["ended_on_backs"][c].get<double>();
        EXPECT_NEAR(energy["imbalance"][c].get<double>(), (in - out) / in, 1e-14);
    }
    EXPECT_EQ(report["output"]["vertices"], result.mesh.vertices.size());
    EXPECT_EQ(report["output"]["display_exposure"], display_exposure(result));
    ASSERT_EQ(report["seconds"].size(), result.journal.seconds().size());
    EXPECT_EQ(report["seconds"][0]["phase"], "read");
    EXPECT_GT(report["peak_memory_bytes"], 1 << 20);
}

TEST(BakeFiles, ReportOfADryRun) {
    BakeOptions options;
    options.sites = 150;
    options.rays = 32;
    const BakeResult result = dry_run(Registry::load(), DIFUSA_TEST_DATA "/cornell_box.obj", options, Execution{});
    const json report = json::parse(report_of(result));
    EXPECT_EQ(report["dry_run"], true);
    EXPECT_EQ(report["transport"]["estimated_rays"], 32 * result.sites->size());
    // Those of a bake, but for what that does beside.
    std::vector<std::string> phases;
    for (const json& phase : report["estimated_seconds"]) {
        phases.push_back(phase["phase"]);
        EXPECT_GE(phase["seconds"], 0.0);
    }
    std::vector<std::string> real;
    const BakeResult baked = bake(Registry::load(), DIFUSA_TEST_DATA "/cornell_box.obj", options, Execution{});
    for (const auto& [phase, seconds] : baked.journal.seconds()) {
        real.push_back(phase);
    }
    EXPECT_THAT(phases, testing::UnorderedElementsAreArray(real));
    EXPECT_FALSE(report.contains("solve"));
    EXPECT_FALSE(report.contains("energy"));
    EXPECT_FALSE(report.contains("output"));
    EXPECT_THAT(summary_of(result), HasSubstr("memory for transport: at most "));
    EXPECT_THAT(summary_of(result), HasSubstr("time: about "));
}

/// A trial that fails is no reason to refuse the rest.
TEST(BakeFiles, ReportOfADryRunWhoseTrialFails) {
    BakeOptions options;
    options.sites = 4000;
    options.rays = 32;
    options.solve.max_iterations = 1;
    options.solve.tolerance = 1e-14;
    const BakeResult result = dry_run(Registry::load(), DIFUSA_TEST_DATA "/cornell_box.obj", options, Execution{});
    EXPECT_TRUE(result.estimate.phases.empty());
    EXPECT_THAT(result.journal.notes(), testing::Contains(HasSubstr("the time cannot be predicted")));
    EXPECT_THAT(summary_of(result), HasSubstr("time: unknown"));
}

/// A square whose red is x at its corners: interpolated, it is x everywhere.
TEST(BakeFiles, VertexColoursOfAFileReachTheField) {
    const ScratchDirectory scratch;
    const auto file = scratch.path() / "square.off";
    std::ofstream(file) << "COFF\n4 2 0\n0 0 0 0.0 0.5 0.25 1\n1 0 0 1.0 0.5 0.25 1\n1 1 0 1.0 0.5 0.25 1\n"
                           "0 1 0 0.0 0.5 0.25 1\n3 0 1 2\n3 0 2 3\n";
    BakeOptions options;
    options.sites = 60;
    options.rays = 16;
    const BakeResult result = bake(Registry::load(), file, options, Execution{});
    EXPECT_EQ(result.channels, 3);
    for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
        const auto row = static_cast<Eigen::Index>(v);
        EXPECT_NEAR(result.output.rho(row, 0), result.mesh.vertices[v].position[0], 1e-15);
        EXPECT_NEAR(result.output.rho(row, 1), 0.5, 1e-15);
        EXPECT_NEAR(result.output.rho(row, 2), 0.25, 1e-15);
    }
}

/// What escapes is measured by rays here too, so that the balance is whole: what is neither absorbed nor escapes is
/// what pairs of few sites miss or invent.
TEST(BakeFiles, ReportOfAPairwiseBake) {
    BakeOptions options;
    options.sites = 150;
    options.transport = "pairwise";
    const BakeResult result = bake(Registry::load(), DIFUSA_TEST_DATA "/cornell_box.obj", options, Execution{});
    const json report = json::parse(report_of(result));
    EXPECT_EQ(report["options"]["transport"], "pairwise:areas=integral,mirrors=gathered,granularity=1,adaptive=yes");
    EXPECT_EQ(report["options"]["kernel"], "disc");
    EXPECT_EQ(report["transport"]["rays"], result.sites->size() * options.rays);
    for (std::size_t c = 0; c < 3; ++c) {
        const json& energy = report["energy"];
        const double in = energy["emitted"][c].get<double>() + energy["from_sky"][c].get<double>();
        const double out = energy["absorbed"][c].get<double>() + energy["escaped"][c].get<double>() +
                           energy["ended_on_backs"][c].get<double>();
        EXPECT_GT(energy["escaped"][c], 0.0); // the box is open
        EXPECT_NEAR(energy["imbalance"][c], (in - out) / in, 1e-12);
    }
}

TEST(BakeFiles, SummarySaysWhatWasFoundOnce) {
    const std::string summary = summary_of(grey());
    for (const char* words :
         {"bowl.ply: ", "note: nothing emits light", "sites: ", "solve: converged after", "energy (W", "peak memory"}) {
        EXPECT_THAT(summary, HasSubstr(words));
        EXPECT_EQ(summary.find(words), summary.rfind(words)) << words;
    }
}

TEST(BakeFiles, AllFilesOrNone) {
    const ScratchDirectory scratch;
    const BakeFiles files{scratch / "out.ply", scratch / "sites.ply", scratch / "report.json"};
    write_bake(coloured(), files, Execution{});
    EXPECT_EQ(scratch.names(), (Names{"out.ply", "report.json", "sites.ply"}));
    const auto size = std::filesystem::file_size(files.sites);
    ASSERT_GT(std::filesystem::file_size(files.field), size);
    for (const auto& name : scratch.names()) {
        write_whole_file(scratch / name, "old");
    }
    {
        const test::FileSizeLimit full(static_cast<rlim_t>(size - 1)); // the last two fit, or only the last
        EXPECT_THROW(write_bake(coloured(), files, Execution{}), ResourceError);
        EXPECT_THROW(write_bake(coloured(), {{}, files.sites, files.report}, Execution{}), ResourceError);
        EXPECT_THROW(write_bake(coloured(), {files.sites, files.field, files.report}, Execution{}), ResourceError);
    }
    struct Cancelled : Progress {
        bool cancelled() const override { return asked_++ > 1; } // when a file has been written
        mutable int asked_ = 0;
    } progress;
    EXPECT_THROW(write_bake(coloured(), files, Execution{1, &progress}), Interrupted);
    for (const auto& name : scratch.names()) {
        EXPECT_EQ(test::read_file(scratch / name), "old") << name;
    }
    EXPECT_EQ(scratch.names(), (Names{"out.ply", "report.json", "sites.ply"}));
    write_bake(coloured(), {{}, {}, files.report}, Execution{});
    EXPECT_EQ(test::read_file(files.field), "old");
    EXPECT_NE(test::read_file(files.report), "old");
}

TEST(BakeFiles, TransferFunctionOfSrgb) {
    EXPECT_EQ(srgb(-1.0), 0.0);
    EXPECT_EQ(srgb(0.0), 0.0);
    EXPECT_DOUBLE_EQ(srgb(1.0), 1.0);
    EXPECT_DOUBLE_EQ(srgb(7.0), 1.0);
    EXPECT_NEAR(srgb(0.0031308), 0.04045, 1e-6); // where the line meets the curve
    EXPECT_NEAR(srgb(0.0031308 + 1e-12), srgb(0.0031308), 1e-7);
    EXPECT_NEAR(srgb(0.214041140482232), 0.5, 1e-12);
}

TEST(BakeFiles, TimesForAPerson) {
    EXPECT_EQ(format_seconds(0.0312), "0.03 s");
    EXPECT_EQ(format_seconds(4.21), "4.2 s");
    EXPECT_EQ(format_seconds(75.2), "75 s");
    EXPECT_EQ(format_seconds(720.0), "12 min");
    EXPECT_EQ(format_seconds(11160.0), "3.1 h");
}

} // namespace
} // namespace difusa::bake_files_test
