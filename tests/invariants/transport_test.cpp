// What holds for every transport matrix: closure of the gather, reciprocity of pairs, no light through walls, memory.
#include <difusa/algebra/hit_lists.h>
#include <difusa/algebra/sparse_rows.h>

#include <support/discretised.h>
#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace difusa::transport_test {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

using test::Discretised;

TEST(Gather, EveryRayIsAccountedFor) {
    // Open, closed, one-sided and two-sided: row sum + sky + back = 1, each part in [0,1], and so with the basis
    // between if it is a partition of unity.
    for (const Mesh& mesh : {test::box(1.0, 1, true), test::box(1.0), test::l_room(), test::room_with_block(),
                             test::mobius(60), test::book(5), test::shelf_over_table(0.1), test::needles(100)}) {
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& name : test::plugin_names<Basis>()) {
                const Discretised scene(test::uniform_scene(mesh, 0.5, 1.0), 0.2, engine, name);
                const LightTransport transport = scene.gathered(100);
                EXPECT_EQ(transport.rays, 100 * scene.sites().size());
                EXPECT_EQ(transport.segments, 0U);
                const Values sums = scene.row_sums(transport), black = scene.on_surfels(1.0);
                Values with_basis;
                ReflectedTransport(scene.discretisation, transport, black)
                    .apply(Values::Ones(sums.rows(), 1), with_basis, Execution{});
                EXPECT_LE(transport.largest_row_sum(Execution{}), 1.0 + 1e-12);
                const auto* const lists = dynamic_cast<const HitLists*>(transport.W.get());
                ASSERT_NE(lists, nullptr) << "all directions weigh the same";
                std::vector<Index> bins;
                for (std::size_t j = 0; j < scene.sites().size(); ++j) {
                    const auto row = static_cast<Eigen::Index>(j);
                    EXPECT_GE(transport.sky[j], 0.0);
                    EXPECT_GE(transport.back[j], 0.0);
                    EXPECT_GE(sums(row, 0), 0.0);
                    EXPECT_NEAR(sums(row, 0) + transport.sky[j] + transport.back[j], 1.0, 1e-12) << name;
                    if (scene.discretisation.basis->partition_of_unity()) {
                        EXPECT_NEAR(with_basis(row, 0), sums(row, 0), 1e-12) << name;
                    }
                    lists->row(j, bins);
                    EXPECT_TRUE(std::is_sorted(bins.begin(), bins.end()));
                    EXPECT_NEAR(static_cast<double>(bins.size()), 100.0 * (1.0 - transport.back[j]), 1e-9);
                }
            }
        }
    }
}

TEST(Gather, TheSkyOverAPlaneIsAllOfIt) {
    for (const std::string& engine : test::plugin_names<Visibility>()) {
        const Discretised scene(test::uniform_scene(test::grid(1, 1), 0.5, 0.0), 0.2, engine, "shepard");
        const LightTransport transport = scene.gathered(64);
        EXPECT_EQ(scene.row_sums(transport).maxCoeff(), 0.0);
        for (const double sky : transport.sky) {
            EXPECT_NEAR(sky, 1.0, 1e-14);
        }
    }
}

TEST(Gather, RowsAgreeWithKnownFormFactors) {
    // From a site on the floor of the unit cube the ceiling has a form factor in closed form; gathered, it is the mean
    // of N stratified samples of 0 and 1, with a variance of at most p(1-p)/N times e (Owen 1997): six deviations.
    const Mesh cube = test::box(1.0, 1, true);
    const auto corner = [](double a, double b) { // parallel rectangle a × b over its corner, at distance 1
        const double x = std::sqrt(1 + a * a), y = std::sqrt(1 + b * b);
        return (a / x * std::atan(b / x) + b / y * std::atan(a / y)) / (2 * std::numbers::pi);
    };
    const SiteSet sites = test::poisson_sites(cube, 0.2);
    constexpr double N = 256;
    RandomStream random(3, "motions");
    for (const bool turned : {false, true}) {
        const Eigen::Matrix3d R = turned ? test::random_rotation(random) : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
        const double scale = turned ? 1e-3 : 1.0;
        const Mesh mesh = test::transformed(cube, R, scale, turned ? Vec3(0.1, -5, 3) : Vec3(0, 0, 0));
        SiteSet moved = sites;
        moved.spacing *= scale;
        for (SurfacePoint& x : moved.points) {
            x = mesh.at(x.face, x.u, x.v);
        }
        for (double& radius : moved.radius) {
            radius *= scale;
        }
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            const Discretised scene(test::uniform_scene(mesh, 0.5, 0.0), moved, engine, "shepard");
            Values ceiling = scene.on_surfels(0.0);
            std::vector<Surfels::Piece> scratch;
            for (Index s = 0; s < scene.discretisation.surfels->size(); ++s) {
                const Index face = scene.discretisation.surfels->centre(s, scratch).face;
                ceiling(s, 0) = cube.normals[face].z() < -0.5 ? 1.0 : 0.0;
            }
            const Values F_gathered = Discretised::gather(scene.gathered(static_cast<std::size_t>(N)), ceiling);
            double sum = 0.0, exact_sum = 0.0;
            std::size_t floor = 0;
            for (std::size_t j = 0; j < sites.size(); ++j) {
                const Vec3 p = sites.points[j].position;
                if (sites.points[j].normal.z() < 0.5) {
                    continue;
                }
                const double F = corner(p.x(), p.y()) + corner(1 - p.x(), p.y()) + corner(p.x(), 1 - p.y()) +
                                 corner(1 - p.x(), 1 - p.y());
                const double found = F_gathered(static_cast<Eigen::Index>(j), 0);
                EXPECT_NEAR(found, F, 6.0 * std::sqrt(std::numbers::e * F * (1 - F) / N)) << engine;
                sum += found;
                exact_sum += F;
                ++floor;
            }
            // Sets are drawn from a pool of 32 and turned at random: the mean errs as 32 sets or better.
            EXPECT_NEAR(sum, exact_sum,
                        6.0 * static_cast<double>(floor) * std::sqrt(std::numbers::e * 0.25 / (32 * N)));
        }
    }
}

/// With D = S M, S_jk = G_jk A_k and M = A⁻¹ Pᵀ A_surfels, reciprocity, G = Gᵀ, shows as symmetry of the exchange
/// between surfels: P D A_surfels⁻¹ = P G Pᵀ.
TEST(Pairwise, IsReciprocalWithThePointKernel) {
    for (const Mesh& mesh : {test::l_room(), test::room_with_block(), test::icosphere(2, 1.0, true)}) {
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            const Discretised scene(test::uniform_scene(mesh, 0.5, 1.0), 0.4, engine, "normalized-radial");
            const Surfels& surfels = *scene.discretisation.surfels;
            for (const std::string& kernel : test::plugin_names<Kernel>()) {
                const LightTransport transport = scene.paired(kernel);
                const auto m = static_cast<Eigen::Index>(surfels.size());
                const Values W = test::dense_with_sky_summed(transport), D = W.leftCols(m);
                EXPECT_GE(D.minCoeff(), 0.0);
                Values exchange;
                scene.discretisation.averages->apply(D, exchange, Execution{});
                for (Index s = 0; s < surfels.size(); ++s) {
                    exchange.col(s) /= surfels.area(s);
                }
                // A pair exchanges light in both directions or not at all.
                EXPECT_TRUE((exchange.array() > 0.0).matrix() == (exchange.transpose().array() > 0.0).matrix())
                    << "seen one way only";
                if (kernel == "point") {
                    // Sums of some tens of terms, in other orders.
                    EXPECT_LE((exchange - exchange.transpose()).cwiseAbs().maxCoeff(), 256 * eps * exchange.maxCoeff());
                }
                for (const unsigned threads : {2U, 5U}) {
                    EXPECT_EQ(Values(test::dense_with_sky_summed(scene.paired(kernel, threads))), W);
                }
            }
        }
    }
}

/// Two closed rooms with a wall of `thickness` between; the left one's faces have material 1, which emits.
Scene lit_and_dark(double thickness) {
    const Mesh left = test::box(1.0, 2, true);
    Scene scene =
        test::uniform_scene(test::together(left, test::moved(left, 1.0, Vec3(1.0 + thickness, 0, 0))), 0.5, 0.0);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].emission = Rgb::Ones();
    std::fill_n(scene.mesh.material.begin(), left.triangles.size(), Index{1});
    return scene;
}

TEST(LightLeak, NoneGetsThroughTheThinnestWall) {
    for (const double thickness : {1e-3, 1e-6, 1e-9}) {
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& name : test::plugin_names<Basis>()) {
                SCOPED_TRACE(engine + ", " + name + ", thickness " + std::to_string(thickness));
                const Discretised scene(lit_and_dark(thickness), 0.2, engine, name);
                const Surfels& surfels = *scene.discretisation.surfels;
                const std::vector<Index>& material = scene.scene.mesh.material;
                std::vector<Surfels::Piece> pieces;
                Values lit = scene.on_surfels(0.0);
                for (Index s = 0; s < surfels.size(); ++s) {
                    surfels.pieces(s, pieces);
                    lit(s, 0) = material[pieces.front().triangle];
                    for (const Surfels::Piece& piece : pieces) {
                        EXPECT_EQ(lit(s, 0), material[piece.triangle]) << "a surfel of both rooms";
                    }
                }
                for (const LightTransport& transport : {scene.gathered(64), scene.paired("disc")}) {
                    const Values from_lit = Discretised::gather(transport, lit),
                                 from_dark = Discretised::gather(transport, scene.on_surfels(1.0) - lit);
                    const bool is_gathered = transport.segments == 0;
                    for (std::size_t j = 0; j < scene.sites().size(); ++j) {
                        const bool dark = material[scene.sites().points[j].face] == 0;
                        const auto row = static_cast<Eigen::Index>(j);
                        EXPECT_EQ((dark ? from_lit : from_dark)(row, 0), 0.0) << "exchange through the wall";
                        if (is_gathered) {
                            EXPECT_NEAR((dark ? from_dark : from_lit)(row, 0), 1.0, 1e-12) << "a closed room";
                        }
                    }
                }
            }
        }
    }
}

TEST(LightLeak, AShelfLightsItsTableNotThroughItself) {
    // Both face up: neither sees the other's front, whatever the gap.
    for (const double gap : {1e-2, 1e-6, 1e-9}) {
        for (const std::string& name : test::plugin_names<Basis>()) {
            for (const std::string& engine : test::plugin_names<Visibility>()) {
                const Discretised scene(test::uniform_scene(test::shelf_over_table(gap), 0.5, 1.0), 0.08, engine, name);
                EXPECT_EQ(scene.row_sums(scene.gathered(64)).maxCoeff(), 0.0) << name << " " << engine << " " << gap;
            }
        }
    }
}

TEST(Gather, MemoryGrowsWithTheRays) {
    // Lists of hits take a byte or two a ray: as much as there are sites, whatever the surfels.
    std::vector<double> bytes, sites_count;
    for (const double spacing : {0.06, 0.06 / std::sqrt(2.0)}) {
        const Discretised scene(test::uniform_scene(test::box(1.0, 1, true), 0.5, 0.0), spacing,
                                test::plugin_names<Visibility>().back(), "normalized-radial");
        const LightTransport transport = scene.gathered(64);
        EXPECT_LT(static_cast<double>(transport.bytes), 2.5 * static_cast<double>(transport.rays));
        bytes.push_back(static_cast<double>(transport.bytes));
        sites_count.push_back(static_cast<double>(scene.sites().size()));
    }
    // Twice the surfels are a bit more for each ray, of ten or so.
    EXPECT_NEAR(bytes[1] / bytes[0], sites_count[1] / sites_count[0], 0.15 * sites_count[1] / sites_count[0]);
    EXPECT_GT(sites_count[1] / sites_count[0], 1.8);
}

} // namespace
} // namespace difusa::transport_test
