// What holds for a whole bake, from file to fields: the same bits for any number of threads and in any power-of-two
// unit of length, and refusals instead of wrong answers.
#include "support/sanitized.h"

#include <difusa/bake.h>
#include <difusa/core/error.h>

#include <scratch_directory.h>
#include <support/lit_scenes.h>
#include <support/plugins.h>
#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace difusa::bake_invariants_test {
namespace {

using test::ScratchDirectory;

/// Writes an OBJ; faces whose centroid `lit` holds emit.
std::filesystem::path write(const ScratchDirectory& directory, const std::string& name, const Mesh& mesh,
                            const std::function<bool(const SurfacePoint&)>& lit) {
    std::ofstream(directory / (name + ".mtl"))
        << "newmtl wall\nKd 0.7 0.5 0.3\nnewmtl lamp\nKd 0.2 0.2 0.2\nKe 4 3 2\n";
    std::ofstream file(directory / (name + ".obj"));
    file.precision(17);
    file << "mtllib " << name << ".mtl\n";
    for (const Vec3& p : mesh.points) {
        file << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    }
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        file << "usemtl " << (lit(mesh.at(t, 1.0 / 3, 1.0 / 3)) ? "lamp" : "wall") << "\nf";
        for (const Index corner : mesh.triangles[t]) {
            file << ' ' << corner + 1;
        }
        file << '\n';
    }
    return directory / (name + ".obj");
}

bool is_ceiling(const SurfacePoint& x) {
    return x.normal.z() < -0.5;
}

double largest_row_sum(const BakeResult& result) {
    return result.system->transport().largest_row_sum(Execution{});
}

/// All numbers of a result that a user can see.
std::vector<double> numbers(const BakeResult& result) {
    std::vector<double> all;
    const auto add = [&](const Values& values) { all.insert(all.end(), values.data(), values.data() + values.size()); };
    for (const Values* values :
         {&result.solution.irradiance, &result.solution.direct, &result.solution.h, &result.field().parts().smooth,
          &result.solution.light.reflectance, &result.solution.light.all_emission, &result.output.B, &result.output.H,
          &result.output.H_direct, &result.output.H_indirect, &result.output.rho, &result.output.E}) {
        add(*values);
    }
    for (const SurfacePoint& x : result.sites->points) {
        all.insert(all.end(), {x.position.x(), x.position.y(), x.position.z(), x.normal.x(), x.u, x.v});
    }
    all.insert(all.end(), result.sites->radius.begin(), result.sites->radius.end());
    all.insert(all.end(), result.sites->area.begin(), result.sites->area.end());
    for (const SurfacePoint& x : result.mesh.vertices) {
        all.insert(all.end(), {x.position.x(), x.position.y(), x.position.z(), x.normal.x(), x.normal.y()});
    }
    all.insert(all.end(), {result.solution.energy.absorbed[0], result.solution.spectral_radius, largest_row_sum(result),
                           result.mean_back, static_cast<double>(result.system->transport().bytes),
                           static_cast<double>(result.journal.count_of("rays")),
                           static_cast<double>(result.journal.count_of("segments")), result.solution.solve.residual});
    for (const auto& history : result.solution.solve.residual_history) {
        all.insert(all.end(), history.begin(), history.end());
    }
    return all;
}

BakeOptions small_bake(double spacing) {
    BakeOptions options;
    options.spacing = spacing;
    options.rays = 48;
    return options;
}

BakeResult baked(const std::filesystem::path& file, const BakeOptions& options, unsigned threads = 1) {
    return bake(test::registry(), file, options, Execution{threads, nullptr});
}

Scene lit_room() {
    Scene scene = test::uniform_scene(test::room_with_block(), 0.5, 0.0);
    scene.point_lights = {{Vec3(0.1, 0.2, 0.3), Rgb::Ones()}};
    return scene;
}

TEST(Bake, WritesIntoTheJournalOfItsCaller) {
    Journal journal;
    journal.note("before");
    const Execution execution{1, nullptr, &journal};
    const BakeResult result = bake(test::registry(), lit_room(), "room", small_bake(0.3), execution);
    EXPECT_EQ(journal.seconds().size(), result.journal.seconds().size());
    EXPECT_EQ(journal.notes().size(), result.journal.notes().size() + 1);
    EXPECT_EQ(journal.count_of("rays"), result.journal.count_of("rays"));
    BakeOptions endless = small_bake(0.3);
    endless.solve.max_iterations = 0;
    EXPECT_THROW(bake(test::registry(), lit_room(), "room", endless, execution), NotConverged);
    EXPECT_GT(journal.seconds().size(), result.journal.seconds().size());
}

/// Every wall is met, whichever way it faces, also those that lie along a diagonal.
TEST(Bake, AListedPointWithoutANormalIsOnTheNearestSurface) {
    const Vec3 along = Vec3(0.36, 0.48, 0.8).normalized();
    for (const Vec3& n : {Vec3(0.8, -0.6, 0.0), along, Vec3(0, 0, 1)}) {
        const Vec3 a = n.unitOrthogonal(), b = n.cross(a);
        Scene scene = lit_room();
        scene.mesh = test::together(scene.mesh, test::make_mesh({5 * n, 5 * n + a, 5 * n + b}, {{0, 1, 2}}));
        scene.sky = Rgb::Ones();
        BakeOptions options = small_bake(0.3);
        options.at = {{5 * n + 0.25 * (a + b) + 0.01 * n, std::nullopt},
                      {5 * n + 0.25 * (a + b) - 0.01 * n, std::nullopt}};
        const BakeResult result = bake(test::registry(), scene, "room", options, Execution{});
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(result.listed[i].face, scene.mesh.triangles.size() - 1);
            EXPECT_NEAR(result.listed_distance[i], 0.01, 1e-12);
        }
    }
}

TEST(Bake, RefusesVertexColoursThatAreNoReflectances) {
    Scene scene = lit_room();
    scene.materials[0].vertex_colours = true;
    scene.mesh.corner_reflectance.assign(scene.mesh.triangles.size(), {Rgb::Ones(), Rgb::Ones(), Rgb::Ones()});
    scene.mesh.corner_reflectance[7][1][2] = 1.5;
    EXPECT_THROW(bake(test::registry(), scene, "room", small_bake(0.3), Execution{}), InputError);
}

/// What geometry alone decides is refused before rays are cast.
TEST(Bake, RefusesTooFineAnOutputFirst) {
    BakeOptions options = small_bake(0.3);
    options.output_spacing = 1e-9;
    Journal journal;
    EXPECT_THROW(bake(test::registry(), lit_room(), "room", options, Execution{1, nullptr, &journal}), ResourceError);
    EXPECT_EQ(journal.count_of("rays"), 0U);
}

const std::vector<unsigned> thread_counts =
    test::sanitized() ? std::vector<unsigned>{3} : std::vector<unsigned>{2, 3, 8};

TEST(Bake, HasTheSameBitsForAnyNumberOfThreads) {
    const ScratchDirectory directory;
    const auto file = write(directory, "room", test::l_room(), is_ceiling);
    for (const char* transport : {"gather", "pairwise", "pairwise:areas=neighbours"}) {
        for (const std::string& solver : test::plugin_names<Solver>()) {
            for (const std::string& basis : test::plugin_names<Basis>()) {
                for (const std::string& engine : test::plugin_names<Visibility>()) {
                    // All of one kind with the defaults of the others, not all combinations.
                    if ((solver != "krylov") + (basis != "normalized-radial") + (engine != "cgal") > 1) {
                        continue;
                    }
                    SCOPED_TRACE(std::string(transport) + ", " + solver + ", " + basis + ", " + engine);
                    BakeOptions options = small_bake(0.25);
                    options.transport = transport;
                    options.solver = solver;
                    options.basis = basis;
                    options.visibility = engine;
                    options.sky = Rgb(0.1, 0.2, 0.3);
                    std::vector<double> one;
                    try {
                        one = numbers(baked(file, options));
                    } catch (const NotConverged&) {
                        continue; // refused: that is another test's matter
                    }
                    for (const unsigned threads : thread_counts) {
                        EXPECT_EQ(numbers(baked(file, options, threads)), one) << threads << " threads";
                    }
                }
            }
        }
    }
}

TEST(Bake, HasTheSameBitsInUnitsOfLengthThatArePowersOfTwo) {
    const ScratchDirectory directory;
    const Mesh room = test::room_with_block();
    const auto file = write(directory, "one", room, is_ceiling);
    for (const double scale : {0x1p-20, 0x1p20}) {
        const auto scaled = write(directory, "scaled", test::moved(room, scale, Vec3::Zero()), is_ceiling);
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& basis : test::plugin_names<Basis>()) {
                BakeOptions options = small_bake(0.125), other = small_bake(0.125 * scale);
                options.visibility = other.visibility = engine;
                options.basis = other.basis = basis;
                const BakeResult a = baked(file, options), b = baked(scaled, other);
                ASSERT_EQ(a.sites->size(), b.sites->size());
                EXPECT_EQ(a.solution.irradiance, b.solution.irradiance) << engine << " " << basis;
                EXPECT_EQ(a.solution.direct, b.solution.direct) << engine << " " << basis;
                EXPECT_EQ(a.output.B, b.output.B);
                EXPECT_EQ(a.solution.solve.residual_history, b.solution.solve.residual_history);
                for (std::size_t j = 0; j < a.sites->size(); ++j) {
                    EXPECT_EQ(scale * a.sites->points[j].position, b.sites->points[j].position);
                    EXPECT_EQ(scale * scale * a.sites->area[j], b.sites->area[j]);
                }
                EXPECT_TRUE((scale * scale * a.solution.energy.absorbed == b.solution.energy.absorbed).all());
            }
        }
    }
}

TEST(Bake, DependsNeitherOnUnitNorOnPlaceNorOnTurn) {
    // Sites differ, so answers agree to what the discretisation is good for. The mean irradiance over the room is
    // measured with n N = 500 · 48 rays of values between 0 and 4 / (1 - 0.7): relative noise below 1 %; and the sites'
    // weights, which differ too: 3 % in all.
    const ScratchDirectory directory;
    const auto mean_irradiance = [](const BakeResult& result) {
        double sum = 0.0, area = 0.0;
        for (std::size_t j = 0; j < result.sites->size(); ++j) {
            sum += result.sites->area[j] * result.solution.irradiance(static_cast<Eigen::Index>(j), 0);
            area += result.sites->area[j];
        }
        return sum / area;
    };
    const Mesh room = test::l_room();
    const double reference = mean_irradiance(baked(write(directory, "one", room, is_ceiling), small_bake(0.18)));
    RandomStream random(4, "motions");
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const double far : {0.0, 1e3}) {
            const Eigen::Matrix3d R = test::random_rotation(random);
            const Mesh moved = test::transformed(room, R, scale, scale * far * Vec3(1, -2, 3));
            const auto file = write(directory, "moved", moved,
                                    [&](const SurfacePoint& x) { return (R.transpose() * x.normal).z() < -0.5; });
            for (const std::string& engine : test::plugin_names<Visibility>()) {
                BakeOptions options = small_bake(0.18 * scale);
                options.visibility = engine;
                const BakeResult result = baked(file, options);
                EXPECT_NEAR(mean_irradiance(result), reference, 0.03 * reference)
                    << engine << " " << scale << " " << far;
                EXPECT_EQ(result.mean_back, 0.0);
                EXPECT_LT(largest_row_sum(result), 1.0 + 1e-12);
            }
        }
    }
}

TEST(Bake, SaysThatThePointKernelDivergesAtHighReflectance) {
    const ScratchDirectory directory;
    std::ofstream(directory / "bright.mtl") << "newmtl m\nKd 0.9 0.9 0.9\nKe 1 1 1\n";
    std::ofstream file(directory / "bright.obj");
    file << "mtllib bright.mtl\nusemtl m\n";
    const Mesh cube = test::box(1.0, 1, true);
    for (const Vec3& p : cube.points) {
        file << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    }
    for (const auto& t : cube.triangles) {
        file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    }
    file.close();
    BakeOptions options = small_bake(0.1);
    options.transport = "pairwise:areas=neighbours";
    options.kernel = "point";
    for (const std::string& solver : test::plugin_names<Solver>()) {
        options.solver = solver;
        try {
            baked(directory / "bright.obj", options);
            ADD_FAILURE() << "an equation without a trustworthy solution was solved";
        } catch (const NotConverged& error) {
            EXPECT_EQ(error.code(), ExitCode::not_converged);
            const std::string what = error.what();
            const std::size_t at = what.find("spectral radius is ");
            ASSERT_NE(at, std::string::npos) << what;
            EXPECT_GT(std::stod(what.substr(at + 19)), 1.0) << what;
            EXPECT_THAT(what, testing::HasSubstr("--transport gather"));
        }
    }
}

TEST(Bake, RefusesDarkScenes) {
    const ScratchDirectory directory;
    const auto nothing = [](const SurfacePoint&) { return false; };
    const auto closed = write(directory, "closed", test::box(1.0, 1, true), nothing);
    BakeOptions as_it_is = small_bake(0.2);
    as_it_is.flip = "none";
    EXPECT_THROW(baked(closed, as_it_is), InputError) << "the sky cannot enter";
    const auto open = write(directory, "open", test::grid(2, 2), nothing);
    BakeOptions dark = small_bake(0.2);
    dark.sky = Rgb::Zero();
    EXPECT_THROW(baked(open, dark), InputError);
    EXPECT_NO_THROW(baked(open, small_bake(0.2))) << "a sky is assumed";
}

TEST(Bake, WideRadialElementsAreRefusedOrSolvedHonestly) {
    const ScratchDirectory directory;
    const auto file = write(directory, "room", test::box(1.0, 1, true), is_ceiling);
    for (const char* basis : {"radial", "radial:width=1", "radial:width=2", "radial:profile=cubic"}) {
        BakeOptions options = small_bake(0.12);
        options.basis = basis;
        try {
            const BakeResult result = baked(file, options);
            EXPECT_LE(result.system->discretisation().projection->condition(), 1e12);
            EXPECT_LT(result.solution.spectral_radius, 1.0);
            EXPECT_LE(result.solution.solve.residual, options.solve.tolerance);
        } catch (const NotConverged& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr("width")) << basis;
        }
    }
}

} // namespace
} // namespace difusa::bake_invariants_test
