// Daylight coefficients: exact where nothing is in the way, conserving where nothing absorbs, equal to a naive
// computation, and in agreement with a scene under the same sky.
#include <difusa/algebra/dense.h>
#include <difusa/bake/daylight.h>
#include <difusa/bake/relight.h>
#include <difusa/core/error.h>
#include <difusa/import/shapes.h>
#include <difusa/radiosity/daylight.h>
#include <difusa/rays/lambert.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/cie_sky.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered.h>

#include <support/dense_operator.h>
#include <support/discretised.h>
#include <support/lightings.h>
#include <support/saved_bakes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace difusa::daylight_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double pi = std::numbers::pi;

SkyDivision tregenza() {
    return {1, Vec3::UnitZ(), Vec3::UnitY()};
}

BakeOptions quick_options() {
    BakeOptions options = lit::quick(0.3, 64);
    options.every_surface = true;
    options.sky = Rgb::Ones();
    options.solve.tolerance = 1e-12;
    return options;
}

DaylightOptions like(const BakeOptions& bake, std::size_t rays) {
    DaylightOptions options;
    options.site_rays = bake.rays;
    options.rays = rays;
    options.solve = bake.solve;
    return options;
}

DaylightCoefficients coefficients(const BakeResult& result, std::span<const SurfacePoint> x, const SkyDivision& sky,
                                  std::size_t rays, unsigned threads = 2) {
    return daylight_coefficients(*result.system, result.solution.light.reflectance, x, sky, like(result.options, rays),
                                 Execution{threads, nullptr, nullptr});
}

/// A box open above, all its faces inwards.
Mesh pit() {
    Mesh mesh = box(Vec3::Zero(), Vec3::Ones(), 2, Front::inside);
    Mesh open;
    open.points = mesh.points;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& corners = mesh.triangles[t];
        const bool top =
            std::all_of(corners.begin(), corners.end(), [&](Index p) { return mesh.points[p].z() > 1.0 - 1e-12; });
        if (!top) {
            open.triangles.push_back(corners);
        }
    }
    open.material.assign(open.triangles.size(), 0);
    for (Index t = 0; t < open.triangles.size(); ++t) {
        open.original_face.push_back(t);
    }
    open.derive();
    return open;
}

TEST(Daylight, IsExactOnUnobstructedGround) {
    const BakeResult result =
        lit::baked(lit::scene_of(rectangle(Vec3::Zero(), Vec3(2, 0, 0), Vec3(0, 2, 0), 2, 2), 0.5), quick_options());
    for (const int factor : {1, 2}) {
        const SkyDivision sky(factor, Vec3::UnitZ(), Vec3::UnitY());
        const std::vector<SurfacePoint> x{result.scene->mesh.at(0, 0.3, 0.3), result.scene->mesh.at(3, 0.2, 0.5)};
        const DaylightCoefficients C = coefficients(result, x, sky, 600);
        ASSERT_EQ(C.channels, 1);
        for (Eigen::Index i = 0; i < 2; ++i) {
            EXPECT_EQ(C.value(i, 0), 0.0) << "the ground";
            for (Index part = 1; part < sky.count(); ++part) {
                ASSERT_NEAR(C.value(i, part), sky.moment(sky.cell(part)).z(), 1e-14);
            }
            EXPECT_NEAR(C.value.row(i).sum(), pi, 1e-12);
        }
    }
}

/// A vertical plane that looks away from everything: half of it is the ground's, and parts all before it are exact.
TEST(Daylight, IsExactOnUnobstructedPlanesInMidAir) {
    const BakeResult result =
        lit::baked(lit::scene_of(rectangle(Vec3::Zero(), Vec3(2, 0, 0), Vec3(0, 2, 0), 2, 2), 0.5), quick_options());
    const SkyDivision sky = tregenza();
    for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0.6, 0, -0.8)}) {
        const SurfacePoint x{Vec3(3.0, 1.0, -1.0), normal, none, 0.0, 0.0};
        const DaylightCoefficients C = coefficients(result, std::span(&x, 1), sky, 3000);
        EXPECT_NEAR(C.value.sum(), pi, 1e-12);
        std::size_t whole = 0;
        for (Index part = 1; part < sky.count(); ++part) {
            if (sky.is_above(sky.cell(part), normal)) {
                ASSERT_NEAR(C.value(0, part), sky.moment(sky.cell(part)).dot(normal), 1e-14);
                ++whole;
            } else if (sky.is_above(sky.cell(part), -normal)) {
                ASSERT_EQ(C.value(0, part), 0.0);
            }
        }
        EXPECT_GT(whole, 10U);
        // The view factor of the ground, (1 - n.up) / 2: the cells at the edge are drawn, each with about its own size
        // times the cosine there as its error, a few hundred of them with either sign.
        EXPECT_NEAR(C.value(0, 0) / pi, 0.5 * (1.0 - normal.z()), 2e-3);
    }
}

/// Everything is as bright as the sky: nothing absorbs, and the rows of the transport sum to 1.
TEST(Daylight, SumsToPiInAFurnace) {
    for (const bool with_mirror : {false, true}) {
        Scene scene = lit::scene_of(pit(), 1.0);
        if (with_mirror) {
            scene.materials.push_back(scene.materials[0]);
            scene.materials[1].name = "mirror";
            scene.materials[1].reflectance = Rgb::Zero();
            scene.materials[1].mirror = Rgb::Ones();
            for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
                scene.mesh.material[t] = scene.mesh.normals[t].x() > 0.5 ? 1 : 0;
            }
        }
        BakeOptions options = quick_options();
        options.basis = "normalized-radial"; // bounces die out surely
        const BakeResult result = lit::baked(scene, options);
        const SurfacePoint x[] = {result.scene->mesh.at(0, 0.3, 0.3),
                                  {Vec3(0.4, 0.5, 0.6), Vec3(0.1, 0.7, 0.2).normalized(), none, 0.0, 0.0}};
        const DaylightCoefficients C = coefficients(result, x, tregenza(), 500);
        for (Eigen::Index i = 0; i < 2; ++i) {
            EXPECT_NEAR(C.value.row(i).sum(), pi, 1e-9) << with_mirror;
        }
    }
}

/// Dense matrices, and each ray by itself.
TEST(Daylight, IsWhatANaiveComputationGives) {
    const Scene scene = [] {
        Scene all = test::bare_room();
        all.materials[0].reflectance = Rgb(0.7, 0.5, 0.2);
        return all;
    }();
    const BakeOptions options = quick_options();
    const BakeResult result = lit::baked(scene, options);
    const RadiositySystem& system = *result.system;
    const Discretisation& d = system.discretisation();
    const Surfels& surfels = *d.surfels;
    const SkyDivision sky = tregenza();
    const std::vector<SurfacePoint> x{scene.mesh.at(0, 0.3, 0.3),
                                      {Vec3(0.5, 1.2, 0.7), Vec3(0, 0.6, 0.8), none, 0.0, 0.0}};
    const DaylightCoefficients C = coefficients(result, x, sky, 600);
    ASSERT_EQ(C.channels, 3);

    const LightTransport sites =
        gathered(system.tracer(), d.points, surfels, {sky.count(), [&](const Vec3& w) { return sky.at(w); }},
                 *system.parts().directions, options.rays, system.parts().seed, Execution{});
    const auto m = static_cast<Eigen::Index>(surfels.size()), n = static_cast<Eigen::Index>(d.points.size());
    const Eigen::MatrixXd W = test::dense(*sites.W);
    const Eigen::MatrixXd P = test::dense(*d.averages);
    const Eigen::MatrixXd Pi = d.projection->coefficients(Values::Identity(n, n));
    const Eigen::MatrixXd Pi_field = d.evaluation->coefficients(Values::Identity(n, n));
    const std::vector<SkyCell> cells = sky.cells(600 / 145);
    for (int c = 0; c < 3; ++c) {
        const Eigen::VectorXd rho = result.solution.light.reflectance.col(c);
        const Eigen::MatrixXd T = W.leftCols(m) * rho.asDiagonal() * P * Pi;
        const Eigen::MatrixXd h =
            solve_dense(Eigen::MatrixXd::Identity(n, n) - T, pi * W.rightCols(static_cast<Eigen::Index>(sky.count())));
        const Eigen::MatrixXd b = rho.asDiagonal() * P * Pi_field * h;
        for (std::size_t i = 0; i < x.size(); ++i) {
            RandomStream stream(1, "daylight", i);
            std::vector<double> weight;
            std::vector<Vec3> towards;
            std::vector<char> whole;
            for (const SkyCell& cell : cells) {
                const double u = stream.uniform(), v = stream.uniform();
                const Vec3 w = sky.direction(cell, u, v);
                whole.push_back(sky.is_above(cell, x[i].normal) ? 1 : 0);
                towards.push_back(w);
                weight.push_back(whole.back() != 0 ? sky.moment(cell).dot(x[i].normal)
                                                   : cell.solid_angle() * std::max(0.0, x[i].normal.dot(w)));
            }
            double sum_whole = 0.0, sum_cut = 0.0;
            for (std::size_t k = 0; k < weight.size(); ++k) {
                (whole[k] != 0 ? sum_whole : sum_cut) += weight[k];
            }
            Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(sky.count()));
            for (std::size_t k = 0; k < weight.size(); ++k) {
                if (weight[k] <= 0.0) {
                    continue;
                }
                const double share = weight[k] * (whole[k] != 0 ? 1.0 : (pi - sum_whole) / sum_cut);
                const Ray ray{inset(scene.mesh, x[i]).position, towards[k], x[i].face};
                Hit hit;
                system.tracer().first_hits(std::span(&ray, 1), std::span(&hit, 1));
                if (hit.face == none) {
                    row[static_cast<Eigen::Index>(sky.at(towards[k]))] += share;
                } else if (hit.front) {
                    row += share / pi * b.row(static_cast<Eigen::Index>(surfels.at(hit.face, hit.u, hit.v)));
                }
            }
            for (Eigen::Index part = 0; part < row.size(); ++part) {
                ASSERT_NEAR(C.value(static_cast<Eigen::Index>(i), 3 * part + c), row[part], 1e-10) << part;
            }
        }
    }
}

/// The rays from the sites are those of the bake: sorted otherwise, their sums are the same.
TEST(Daylight, ItsPartsAddUpToTheSkyOfTheTransport) {
    const BakeOptions options = quick_options();
    const BakeResult result = lit::baked(test::bare_room(), options);
    const RadiositySystem& system = *result.system;
    const SkyDivision sky = tregenza();
    const LightTransport sites =
        gathered(system.tracer(), system.discretisation().points, *system.discretisation().surfels,
                 {sky.count(), [&](const Vec3& w) { return sky.at(w); }}, *system.parts().directions, options.rays,
                 system.parts().seed, Execution{});
    EXPECT_EQ(sites.sky, system.transport().sky);
    const Values none_emits = Values::Zero(static_cast<Eigen::Index>(sites.surfels), 1);
    Values sorted, stored;
    // Level ground divides both kinds of parts: two radiances, one above and one below, are the same sky in both.
    Values two_sorted = Values::Constant(static_cast<Eigen::Index>(sky.count()), 1, 3.0),
           two_stored(SkyParts::count, 1);
    two_sorted(0, 0) = 0.7;
    for (Index part = 0; part < SkyParts::count; ++part) {
        two_stored(part, 0) = part < SkyParts::count / 2 ? 0.7 : 3.0;
    }
    sites.gather(none_emits, two_sorted, sorted, Execution{});
    system.transport().gather(none_emits, two_stored, stored, Execution{});
    EXPECT_LE((sorted - stored).cwiseAbs().maxCoeff(), 1e-14);
}

/// A relit scene under the same sky, gathered at the same points with other rays.
TEST(Daylight, TimesASkyIsWhatARelitSceneReceives) {
    Scene bare = test::bare_room();
    bare.sky = Rgb::Ones();
    BakeOptions options = quick_options();
    options.sky.reset();
    options.rays = 256;
    const SavedTransport saved = test::through_file(lit::baked(bare, options));
    RelightOptions how;
    how.bake = relight_defaults(saved);
    how.bake.error_points = 0;
    how.evaluate = false;
    for (int k = 0; k < 8; ++k) {
        how.bake.at.push_back({Vec3(0.2 + 0.2 * k, 0.3 + 0.15 * k, 0.8), Vec3(0, 0.1 * k, 1).normalized()});
    }
    Scene lit = bare;
    CieSky cie(12, Vec3::UnitZ(), Vec3(0.5, 0.3, 0.6).normalized());
    cie.scale_to_irradiance(Rgb(1, 2, 3));
    cie.set_ground(Rgb::Constant(0.2));
    lit.dome = std::make_shared<CieSky>(cie);
    lit.sky = Rgb::Zero();
    BakeResult relit = relight(test::registry(), saved, lit, "scene", how, Execution{2, nullptr, nullptr});
    const DaylightMatrix matrix = daylight_matrix(relit, {2, std::nullopt, 4096}, Execution{2, nullptr, nullptr});
    ASSERT_EQ(matrix.points.size(), 8U);
    const Values product = matrix.coefficients.irradiance(matrix.sky.mean_radiances(*lit.dome));
    std::vector<Sensor> sensors;
    for (const SurfacePoint& point : matrix.points) {
        sensors.push_back({point.position, point.normal, SensorKind::planar});
    }
    const Values H = read_sensors(relit.field(), sensors, 8192, nullptr, 1, Execution{2, nullptr, nullptr}).H;
    for (Eigen::Index i = 0; i < product.rows(); ++i) {
        EXPECT_EQ(matrix.points[static_cast<std::size_t>(i)].position,
                  how.bake.at[static_cast<std::size_t>(i)].position);
        // Either's noise is below 1 %, and the sky is constant over parts of 6 degrees.
        EXPECT_LE((product.row(i) - H.row(i)).norm(), 0.02 * H.row(i).norm()) << i;
    }
}

/// In a black room the coefficients of a point add up to pi times the form factor of its window. Of 512 aimed rays a
/// quarter or more pass the window, because the openings are it and a margin of its own size at most: were they
/// independent, the error would be sqrt(3 / 512) of it. Of the 2048 cells a dozen or so are seen through it.
TEST(Daylight, SeesSmallWindowsFromAfar) {
    const double a = 1.7, b = 2.3, low = 1.0, high = 1.6; // the window: y and z
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(5, 0, 0), Vec3(0, 4, 0));
    const auto wall = [&](const Vec3& corner, const Vec3& u, const Vec3& v) { add(mesh, rectangle(corner, u, v), 0); };
    wall(Vec3(0, 0, 2.5), Vec3(0, 4, 0), Vec3(5, 0, 0));
    wall(Vec3(0, 0, 0), Vec3(0, 0, 2.5), Vec3(5, 0, 0));
    wall(Vec3(0, 4, 0), Vec3(5, 0, 0), Vec3(0, 0, 2.5));
    wall(Vec3(5, 0, 0), Vec3(0, 0, 2.5), Vec3(0, 4, 0));
    wall(Vec3(0, 0, 0), Vec3(0, a, 0), Vec3(0, 0, 2.5));
    wall(Vec3(0, b, 0), Vec3(0, 4 - b, 0), Vec3(0, 0, 2.5));
    wall(Vec3(0, a, 0), Vec3(0, b - a, 0), Vec3(0, 0, low));
    wall(Vec3(0, a, high), Vec3(0, b - a, 0), Vec3(0, 0, 2.5 - high));
    const BakeResult result = lit::baked(lit::scene_of(mesh, 0.0), quick_options());
    ASSERT_NE(result.system->transport().openings, nullptr);
    std::vector<SurfacePoint> x;
    for (int i = 0; i < 10; ++i) {
        for (int j = 0; j < 5; ++j) {
            const Vec3 normal = i % 2 == 0 ? Vec3(0, 0, 1) : Vec3(-1, 0, 0);
            x.push_back({Vec3(3.0 + 0.19 * i, 0.3 + 0.8 * j, 0.8), normal, none, 0.0, 0.0});
        }
    }
    const DaylightCoefficients C = coefficients(result, x, tregenza(), 2048);
    const Vec3 window[] = {Vec3(0, a, low), Vec3(0, b, low), Vec3(0, b, high), Vec3(0, a, high)};
    double squares = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double exact = pi * lambert_form_factor(x[i].position, x[i].normal, window);
        ASSERT_GT(exact, 0.0);
        squares += std::pow(C.value.row(static_cast<Eigen::Index>(i)).sum() / exact - 1.0, 2);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(x.size())), std::sqrt(3.0 / 512.0));
}

TEST(Daylight, HasTheSameBitsForAnyThreadsAndMemory) {
    const BakeResult result = lit::baked(test::bare_room(), quick_options());
    const SurfacePoint x[] = {result.scene->mesh.at(0, 0.3, 0.3), result.scene->mesh.at(5, 0.3, 0.3)};
    const DaylightCoefficients one = coefficients(result, x, tregenza(), 300, 1);
    EXPECT_EQ(one.value, coefficients(result, x, tregenza(), 300, 3).value);
    DaylightOptions small = like(result.options, 300);
    small.most_bytes = 40 * sizeof(double) * result.system->discretisation().surfels->size();
    EXPECT_EQ(one.value, daylight_coefficients(*result.system, result.solution.light.reflectance, x, tregenza(), small,
                                               Execution{})
                             .value);
}

/// Of all kinds, level ground receives exactly what was asked for.
TEST(Daylight, SkiesGiveLevelGroundTheirIrradiance) {
    for (const int factor : {1, 2}) {
        const SkyDivision sky(factor, Vec3::UnitZ(), Vec3::UnitY());
        for (int type = 1; type <= 16; ++type) {
            const SkyInParts cie =
                sky_in_parts("cie:type=" + std::to_string(type) + ",elevation=30,azimuth=100,diffuse=50", sky);
            EXPECT_NEAR(sky.level_irradiance(cie.radiance)[1], 50.0, 1e-11);
            EXPECT_NEAR(cie.radiance(0, 0), 0.2 * 50.0 / pi, 1e-12) << "the ground";
        }
        const SkyInParts solar = sky_in_parts("perez:direct=700,diffuse=90,elevation=50,light=solar", sky);
        EXPECT_NEAR(sky.level_irradiance(solar.radiance)[0], 90.0, 1e-11);
        EXPECT_EQ(solar.notes.size(), 1U);
        // A surface that faces the part of the sun receives its light.
        const SkyInParts both = sky_in_parts("perez:direct=700,diffuse=90,elevation=50,light=solar,sun=part", sky);
        Eigen::Index part = 0;
        (both.radiance - solar.radiance).col(0).tail(both.radiance.rows() - 1).maxCoeff(&part);
        const SkyCell& cell = sky.cell(static_cast<Index>(part + 1));
        EXPECT_EQ(cell.part, sky.at(Vec3(0, -std::cos(50 * pi / 180), std::sin(50 * pi / 180)))) << "in the south";
        EXPECT_NEAR((both.radiance - solar.radiance)(part + 1, 0) * sky.moment(cell).norm(), 700.0, 1e-9);
    }
    const SkyDivision sky = tregenza();
    const SkyInParts uniform = sky_in_parts("cie:type=5,illuminance=683", sky);
    EXPECT_NEAR(uniform.radiance(7, 0), 1.0 / pi, 1e-12);
    EXPECT_THROW(sky_in_parts("cie:type=17,diffuse=1", sky), UsageError);
    EXPECT_THROW(sky_in_parts("cie:type=3", sky), UsageError);
    EXPECT_THROW(sky_in_parts("perez:diffuse=3", sky), UsageError);
    EXPECT_THAT([&] { sky_in_parts("peres:direct=1", sky); }, ThrowsMessage<UsageError>(HasSubstr("did you mean")));
}

} // namespace
} // namespace difusa::daylight_test
