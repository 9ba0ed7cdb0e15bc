// What a bake writes has a finite number everywhere: nothing else is written, and choices of all kinds on small scenes
// give nothing else.
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/output/bake_files.h>

#include <support/lit_scenes.h>
#include <support/plugins.h>

#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>

namespace difusa::finite_fields_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

FieldFile triangle() {
    FieldFile field;
    field.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    field.normals.assign(3, Vec3::UnitZ());
    field.triangles = {{0, 1, 2}};
    field.point_arrays = {{"light", "W/m^2", {"R", "G", "B"}, Values(Values::Ones(3, 3))}};
    field.cell_arrays = {{"mean", "W/m^2", {}, Values(Values::Ones(1, 1))}};
    return field;
}

TEST(FiniteFields, NameTheArrayAndTheVertex) {
    EXPECT_NO_THROW(require_finite(triangle()));
    const auto refused = [](const char* array, const char* place, auto spoil) {
        for (const double bad : {nan, inf, -inf}) {
            FieldFile field = triangle();
            spoil(field, bad);
            EXPECT_THAT([&] { require_finite(field); },
                        ThrowsMessage<InternalError>(AllOf(HasSubstr(array), HasSubstr(place))));
        }
    };
    refused("`position`", "vertex 1", [](FieldFile& f, double bad) { f.points[1].z() = bad; });
    refused("`normal`", "vertex 0", [](FieldFile& f, double bad) { f.normals[0].x() = bad; });
    refused("`light`", "vertex 2",
            [](FieldFile& f, double bad) { std::get<Values>(f.point_arrays[0].data)(2, 1) = bad; });
    refused("`mean`", "cell 0", [](FieldFile& f, double bad) { std::get<Values>(f.cell_arrays[0].data)(0, 0) = bad; });
}

Scene lamp_over_floor() {
    Scene scene = lit::scene_of(rectangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0.5);
    scene.sky = Rgb::Ones();
    return scene;
}

TEST(FiniteFields, NothingElseIsWritten) {
    BakeOptions options = lit::quick(0.3, 4);
    options.at = {{Vec3(0.5, 0.5, 0.1), {}}};
    BakeResult good = lit::baked(lamp_over_floor(), options);
    const test::ScratchDirectory scratch;
    const BakeFiles files{scratch / "out.vtp", scratch / "sites.vtp", scratch / "report.json", scratch / "at.csv"};
    for (int kind = 0; kind < 3; ++kind) {
        BakeResult bad = good;
        (kind == 0   ? bad.output.B(1, 0)
         : kind == 1 ? bad.solution.irradiance(0, 0)
                     : bad.listed_values.H_direct(0, 2)) = kind == 1 ? inf : nan;
        EXPECT_THROW(write_bake(bad, files, Execution{}), InternalError) << kind;
        EXPECT_TRUE(scratch.names().empty());
    }
    write_bake(good, files, Execution{});
    EXPECT_EQ(scratch.names().size(), 4U);
}

/// The error has no bound where some surface absorbs nothing: that number is left out, its estimate is not.
TEST(FiniteFields, WithoutABoundThereIsStillAnEstimate) {
    for (const double rho : {0.5, 1.0}) {
        Scene scene = lamp_over_floor();
        scene.materials[0].reflectance = Rgb::Constant(rho);
        BakeOptions options = lit::quick(0.3, 4);
        options.error_points = 16;
        const BakeResult result = lit::baked(scene, options);
        const FieldFile field = field_of(result);
        EXPECT_NO_THROW(require_finite(field));
        const bool estimated = std::any_of(field.point_arrays.begin(), field.point_arrays.end(),
                                           [](const FieldArray& array) { return array.name == "error_estimate"; });
        const bool bounded = std::any_of(field.notes.begin(), field.notes.end(),
                                         [](const FieldNote& note) { return note.name == "error_bound"; });
        EXPECT_TRUE(estimated);
        EXPECT_EQ(bounded, rho < 1.0);
    }
}

double pick(RandomStream& random, std::initializer_list<double> of) {
    return of.begin()[random.below(of.size())];
}

template <class T> T pick(RandomStream& random, const std::vector<T>& of) {
    return of[random.below(of.size())];
}

/// A few rectangles, needles and boxes of random materials, of any size.
Scene random_scene(RandomStream& random, double size) {
    const auto point = [&] {
        const double x = random.uniform(), y = random.uniform(), z = random.uniform();
        return Vec3(size * Vec3(x, y, z));
    };
    Mesh mesh = box(Vec3::Zero(), Vec3::Constant(size), 1, Front::inside);
    for (auto part = random.below(4); part-- > 0;) {
        const Vec3 corner = point(), a = point();
        const double width = pick(random, {1.0, 1e-3, 1e-9});
        add(mesh, rectangle(corner, a, Vec3(width * a.cross(point()) / size)), 0);
    }
    Scene scene = lit::scene_of(std::move(mesh), 0.5);
    scene.materials.resize(3);
    for (Material& material : scene.materials) {
        material.reflectance = Rgb::Constant(pick(random, {0.0, 0.3, 0.9, 1.0}));
        material.emission = Rgb::Constant(pick(random, {0.0, 0.0, 1.0, 1e-30, 1e30}));
    }
    for (Index& material : scene.mesh.material) {
        material = static_cast<Index>(random.below(3));
    }
    PointLight light;
    light.position = point();
    light.intensity = Rgb::Constant(size * size * pick(random, {0.0, 1.0, 1e-20, 1e20}));
    scene.point_lights = {light};
    scene.sky = Rgb::Constant(pick(random, {0.0, 1.0}));
    return scene;
}

TEST(FiniteFields, ComeFromAllChoicesOnSmallScenes) {
    std::size_t done = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        RandomStream random(seed, "scenes");
        const double size = pick(random, {1.0, 1.0, 1e-50, 1e-30, 1e30, 1e50});
        const Scene scene = random_scene(random, size);
        BakeOptions options = lit::quick(0.3 * size, 8);
        options.basis = pick<std::string>(random, test::plugin_names<Basis>());
        options.solver = pick<std::string>(random, test::plugin_names<Solver>());
        options.directions = pick<std::string>(random, test::plugin_names<Directions>());
        options.visibility = pick<std::string>(random, test::plugin_names<Visibility>());
        options.transport = pick<std::string>(random, {"gather", "gather", "pairwise"});
        options.projection = pick<std::string>(random, {"", "natural", "galerkin", "interpolation", "least-squares"});
        options.direct = pick<std::string>(random, {"exact", "interpolated"});
        options.neighbours = static_cast<int>(pick(random, {1, 4, 10, 30}));
        options.error_points = 16 * random.below(2);
        options.final_gather = random.below(3);
        options.light_groups = random.below(2) == 0;
        options.face_centres = random.below(2) == 0;
        const auto begin = std::chrono::steady_clock::now();
        try {
            const BakeResult result = lit::baked(scene, options);
            EXPECT_NO_THROW(require_finite(field_of(result)));
            EXPECT_NO_THROW(require_finite(sites_of(result)));
            ++done;
        } catch (const InternalError& error) {
            ADD_FAILURE() << error.what();
        } catch (const Error&) { // refused, with a message
        }
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        EXPECT_LT(took.count(), 10.0);
    }
    EXPECT_GT(done, 20U);
}

} // namespace
} // namespace difusa::finite_fields_test
