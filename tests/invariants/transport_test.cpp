// What holds for every transport matrix: closure of the gather, reciprocity of pairs, no light through walls, memory.
#include <difusa/discretisation/element_integrals.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>
#include <difusa/transport/gather.h>
#include <difusa/transport/kernel.h>
#include <difusa/transport/pairwise.h>

#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace difusa {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

Transport gathered(const Scene& scene, const SiteSet& sites, const Basis& basis, const std::string& engine,
                   std::size_t rays, std::uint64_t seed = 1) {
    const auto visibility = test::plugin<Visibility>(engine);
    visibility->build(scene.mesh);
    return gather(scene, sites.points, basis, *visibility, *test::plugin<Directions>("low-discrepancy"), rays, seed,
                  Execution{});
}

Transport paired(const Scene& scene, const SiteSet& sites, const ElementIntegrals& integrals, const std::string& engine,
                 const std::string& kernel, unsigned threads = 1) {
    const auto visibility = test::plugin<Visibility>(engine);
    visibility->build(scene.mesh);
    return pairwise(scene, sites, integrals, *visibility, *test::plugin<Kernel>(kernel), Execution{threads, nullptr});
}

TEST(Gather, EveryRayIsAccountedFor) {
    // Open, closed, one-sided and two-sided: row sum + sky + back = 1 for a partition of unity, each part in [0,1].
    for (const Mesh& mesh : {test::box(1.0, 1, true), test::box(1.0), test::l_room(), test::room_with_block(),
                             test::mobius(60), test::book(5), test::shelf_over_table(0.1), test::needles(100)}) {
        const Scene scene = test::uniform_scene(mesh, 0.5, 1.0);
        const SiteSet sites = test::poisson_sites(scene.mesh, 0.2);
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& name : test::plugin_names<Basis>()) {
                const auto basis = test::plugin<Basis>(name);
                basis->bind(scene.mesh, sites);
                const Transport transport = gathered(scene, sites, *basis, engine, 100);
                EXPECT_EQ(transport.rays, 100 * sites.size());
                EXPECT_EQ(transport.segments, 0U);
                for (std::size_t j = 0; j < sites.size(); ++j) {
                    EXPECT_GE(transport.sky[j], 0.0);
                    EXPECT_GE(transport.back[j], 0.0);
                    // Direct light sees the same fronts: all of them emit.
                    EXPECT_NEAR(transport.L.row_sum(j) + transport.sky[j] + transport.back[j], 1.0, 1e-12) << name;
                    if (basis->partition_of_unity()) {
                        EXPECT_NEAR(transport.S.row_sum(j) + transport.sky[j] + transport.back[j], 1.0, 1e-12) << name;
                        EXPECT_LE(transport.S.row_sum(j), 1.0 + 1e-12);
                        EXPECT_TRUE(std::all_of(transport.S.row(j).value.begin(), transport.S.row(j).value.end(),
                                                [](double s) { return s >= 0.0; }));
                    }
                    const std::vector<Index>& column = transport.S.row(j).column;
                    EXPECT_TRUE(std::is_sorted(column.begin(), column.end()));
                }
            }
        }
    }
}

TEST(Gather, TheSkyOverAPlaneIsAllOfIt) {
    const Scene scene = test::uniform_scene(test::grid(1, 1), 0.5, 0.0);
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.2);
    const auto basis = test::plugin<Basis>("shepard");
    basis->bind(scene.mesh, sites);
    for (const std::string& engine : test::plugin_names<Visibility>()) {
        const Transport transport = gathered(scene, sites, *basis, engine, 64);
        EXPECT_EQ(transport.S.nonzeros(), 0U);
        for (const double sky : transport.sky) {
            EXPECT_NEAR(sky, 1.0, 1e-14);
        }
        Transport alone;
        const auto visibility = test::plugin<Visibility>(engine);
        visibility->build(scene.mesh);
        gather_sky(scene, sites.points, *visibility, *test::plugin<Directions>("low-discrepancy"), 64, 1, Execution{},
                   alone);
        EXPECT_EQ(alone.sky, transport.sky);
        EXPECT_EQ(alone.back, transport.back);
    }
}

TEST(Gather, RowsAgreeWithKnownFormFactors) {
    // From a site on the floor of the unit cube the ceiling has a form factor in closed form; gathered, it is the mean
    // of N stratified samples of 0 and 1, with a variance of at most p(1-p)/N times e (Owen 1997): six deviations.
    Scene scene = test::uniform_scene(test::box(1.0, 1, true), 0.5, 0.0);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].emission = Rgb::Ones();
    for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
        scene.mesh.material[t] = scene.mesh.normals[t].z() < -0.5 ? 1 : 0;
    }
    const auto corner = [](double a, double b) { // parallel rectangle a × b over its corner, at distance 1
        const double x = std::sqrt(1 + a * a), y = std::sqrt(1 + b * b);
        return (a / x * std::atan(b / x) + b / y * std::atan(a / y)) / (2 * std::numbers::pi);
    };
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.2);
    const auto basis = test::plugin<Basis>("shepard");
    basis->bind(scene.mesh, sites);
    constexpr double N = 256;
    RandomStream random(3, "motions");
    for (const bool turned : {false, true}) {
        Scene other = scene;
        const Eigen::Matrix3d R = turned ? test::random_rotation(random) : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
        other.mesh = test::transformed(scene.mesh, R, turned ? 1e-3 : 1.0, turned ? Vec3(0.1, -5, 3) : Vec3(0, 0, 0));
        SiteSet moved = sites;
        for (SurfacePoint& x : moved.points) {
            x = other.mesh.at(x.face, x.u, x.v);
        }
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            const auto bound = test::plugin<Basis>("shepard");
            bound->bind(other.mesh, moved);
            const Transport transport = gathered(other, moved, *bound, engine, static_cast<std::size_t>(N));
            double sum = 0.0, exact_sum = 0.0;
            std::size_t floor = 0;
            for (std::size_t j = 0; j < sites.size(); ++j) {
                const Vec3 p = sites.points[j].position;
                if (sites.points[j].normal.z() < 0.5) {
                    continue;
                }
                const double F = corner(p.x(), p.y()) + corner(1 - p.x(), p.y()) + corner(p.x(), 1 - p.y()) +
                                 corner(1 - p.x(), 1 - p.y());
                EXPECT_NEAR(transport.L.row_sum(j), F, 6.0 * std::sqrt(std::numbers::e * F * (1 - F) / N)) << engine;
                sum += transport.L.row_sum(j);
                exact_sum += F;
                ++floor;
            }
            // Sets are drawn from a pool of 32 and turned at random: the mean errs as 32 sets or better.
            EXPECT_NEAR(sum, exact_sum,
                        6.0 * static_cast<double>(floor) * std::sqrt(std::numbers::e * 0.25 / (32 * N)));
        }
    }
}

TEST(Pairwise, IsReciprocalWithThePointKernel) {
    for (const Mesh& mesh : {test::l_room(), test::room_with_block(), test::icosphere(2, 1.0, true)}) {
        const Scene scene = test::uniform_scene(mesh, 0.5, 1.0);
        SiteSet sites = test::poisson_sites(scene.mesh, 0.3);
        const auto basis = test::plugin<Basis>("normalized-radial");
        basis->bind(scene.mesh, sites);
        const ElementIntegrals integrals = element_integrals(scene, *basis, 0.3, Execution{});
        sites.area = integrals.area;
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& kernel : test::plugin_names<Kernel>()) {
                const Transport transport = paired(scene, sites, integrals, engine, kernel);
                const auto n = static_cast<Eigen::Index>(sites.size());
                Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
                for (std::size_t j = 0; j < sites.size(); ++j) {
                    const SparseRows::Row& row = transport.S.row(j);
                    EXPECT_TRUE(std::is_sorted(row.column.begin(), row.column.end()));
                    for (std::size_t k = 0; k < row.column.size(); ++k) {
                        S(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(row.column[k])) = row.value[k];
                    }
                }
                EXPECT_GE(S.minCoeff(), 0.0);
                EXPECT_EQ(S.diagonal().cwiseAbs().maxCoeff(), 0.0);
                EXPECT_TRUE((S.array() > 0.0).matrix() == (S.transpose().array() > 0.0).matrix())
                    << "seen one way only";
                if (kernel == "point") {
                    Eigen::MatrixXd flow = S;
                    for (Eigen::Index j = 0; j < n; ++j) {
                        flow.row(j) *= sites.area[static_cast<std::size_t>(j)];
                    }
                    EXPECT_LE((flow - flow.transpose()).cwiseAbs().maxCoeff(), 16 * eps * flow.maxCoeff());
                }
                for (const unsigned threads : {2U, 5U}) {
                    const Transport again = paired(scene, sites, integrals, engine, kernel, threads);
                    for (std::size_t j = 0; j < sites.size(); ++j) {
                        ASSERT_EQ(again.S.row(j).column, transport.S.row(j).column);
                        ASSERT_EQ(again.S.row(j).value, transport.S.row(j).value);
                    }
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
        const Scene scene = lit_and_dark(thickness);
        SiteSet sites = test::poisson_sites(scene.mesh, 0.2);
        for (const std::string& engine : test::plugin_names<Visibility>()) {
            for (const std::string& name : test::plugin_names<Basis>()) {
                SCOPED_TRACE(engine + ", " + name + ", thickness " + std::to_string(thickness));
                const auto basis = test::plugin<Basis>(name);
                basis->bind(scene.mesh, sites);
                const auto is_dark = [&](std::size_t i) { return scene.mesh.material[sites.points[i].face] == 0; };
                const ElementIntegrals integrals = element_integrals(scene, *basis, 0.2, Execution{});
                sites.area = integrals.area;
                for (const Transport& transport :
                     {gathered(scene, sites, *basis, engine, 64), paired(scene, sites, integrals, engine, "disc")}) {
                    const Values direct = direct_irradiance(scene, all_lights(scene), transport, 1, Execution{});
                    for (std::size_t j = 0; j < sites.size(); ++j) {
                        if (is_dark(j)) {
                            EXPECT_EQ(direct(static_cast<Eigen::Index>(j), 0), 0.0);
                        } else if (!transport.sky.empty()) {
                            EXPECT_NEAR(direct(static_cast<Eigen::Index>(j), 0), 1.0, 1e-12) << "the furnace next door";
                        }
                        for (const Index k : transport.S.row(j).column) {
                            EXPECT_EQ(is_dark(j), is_dark(k)) << "exchange through the wall";
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
        const Scene scene = test::uniform_scene(test::shelf_over_table(gap), 0.5, 1.0);
        const SiteSet sites = test::poisson_sites(scene.mesh, 0.08);
        for (const std::string& name : test::plugin_names<Basis>()) {
            const auto basis = test::plugin<Basis>(name);
            basis->bind(scene.mesh, sites);
            for (const std::string& engine : test::plugin_names<Visibility>()) {
                const Transport transport = gathered(scene, sites, *basis, engine, 64);
                EXPECT_EQ(transport.S.nonzeros(), 0U) << name << " " << engine << " gap " << gap;
                EXPECT_EQ(transport.L.nonzeros(), 0U) << name << " " << engine << " gap " << gap;
            }
        }
    }
}

TEST(Gather, MemoryGrowsWithTheSites) {
    // Once every ray meets elements of its own a row has as many entries as its rays meet elements, however many sites
    // there are: rays times the overlap is far below n.
    std::vector<double> entries, sites_count;
    for (const double spacing : {0.06, 0.06 / std::sqrt(2.0)}) {
        const Scene scene = test::uniform_scene(test::box(1.0, 1, true), 0.5, 0.0);
        const SiteSet sites = test::poisson_sites(scene.mesh, spacing);
        const auto basis = test::plugin<Basis>("normalized-radial");
        basis->bind(scene.mesh, sites);
        const Transport transport = gathered(scene, sites, *basis, test::plugin_names<Visibility>().back(), 8);
        entries.push_back(static_cast<double>(transport.S.nonzeros()));
        sites_count.push_back(static_cast<double>(sites.size()));
    }
    EXPECT_NEAR(entries[1] / entries[0], sites_count[1] / sites_count[0], 0.05 * sites_count[1] / sites_count[0]);
    EXPECT_GT(sites_count[1] / sites_count[0], 1.8);
}

} // namespace
} // namespace difusa
