#include <difusa/core/parallel.h>
#include <difusa/lighting/lambert.h>
#include <difusa/lighting/lamps.h>
#include <difusa/sites/site_set.h>
#include <difusa/transport/transport.h>
#include <difusa/visibility/brute_force.h>

#include <gtest/gtest.h>

#include <meshes.h>

#include <cmath>
#include <numeric>

namespace difusa {
namespace {

constexpr std::size_t samples = 64;

/// A flat rectangle at height z with the normal ±z.
Mesh rectangle(double x0, double x1, double y0, double y1, double z, bool down = false) {
    return test::moved(test::grid(1, 1, x1 - x0, y1 - y0, down), 1.0, Vec3(x0, y0, z));
}

/// The triangles of `lamp` have the material 1, which emits; the others do not.
Scene scene_of(Mesh mesh, const std::vector<Index>& lamp) {
    Scene scene;
    scene.mesh = std::move(mesh);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb(1, 2, 3);
    for (const Index t : lamp) {
        scene.mesh.material[t] = 1;
    }
    return scene;
}

SiteSet sites_at(std::vector<SurfacePoint> points) {
    SiteSet sites;
    sites.points = std::move(points);
    return sites;
}

Transport light(const Scene& scene, const std::vector<Index>& lamps, const SiteSet& sites, std::uint64_t seed = 1,
                unsigned threads = 1) {
    BruteForceVisibility visibility;
    visibility.build(scene.mesh);
    const Lamps light(scene, lamps, visibility);
    Transport transport;
    transport.L = SparseRows(sites.size(), scene.materials.size());
    std::vector<std::size_t> cast(threads, 0);
    parallel_for(
        sites.size(), 16, Execution{threads, nullptr}, [&](std::size_t begin, std::size_t end, unsigned number) {
            Lamps::Worker worker;
            for (std::size_t j = begin; j < end; ++j) {
                RandomStream stream(seed, "lamps", j);
                for (const Lamps::Group& group : light.groups()) {
                    const double F = light.visible_form_factor(sites.points[j], group, samples, stream, worker);
                    if (F > 0.0) {
                        transport.L.row(j).column.push_back(group.material);
                        transport.L.row(j).value.push_back(F);
                    }
                }
            }
            cast[number] += worker.cast;
        });
    transport.segments = std::accumulate(cast.begin(), cast.end(), std::size_t{0});
    return transport;
}

/// What the site sees of the lamps with nothing in between.
double unblocked(const Mesh& mesh, const std::vector<Index>& lamps, const SurfacePoint& x) {
    double F = 0.0;
    for (const Index t : lamps) {
        F += lambert_form_factor(x.position, x.normal, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    }
    return F;
}

/// n × n places over the two triangles of a rectangle of width w and depth d at height 0, in the middles of cells.
std::vector<SurfacePoint> places(const Mesh& mesh, int n, double w, double d) {
    std::vector<SurfacePoint> points;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            SurfacePoint x;
            const double s = (i + 0.5) / n, t = (j + 0.5) / n;
            x.position = Vec3(s * w, t * d, 0.0);
            x.face = s > t ? 0 : 1; // below the diagonal, or above
            x.normal = mesh.normals[x.face];
            points.push_back(x);
        }
    }
    return points;
}

TEST(Lamps, UnblockedLightIsExact) {
    const Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.2, 0.7, 0.1, 0.3, 0.4, true));
    const std::vector<Index> lamps{2, 3};
    const Scene scene = scene_of(mesh, lamps);
    const SiteSet sites = sites_at(places(mesh, 20, 1, 1));
    const Transport transport = light(scene, lamps, sites);
    ASSERT_EQ(transport.L.rows(), sites.size());
    ASSERT_EQ(transport.L.columns(), scene.materials.size());
    for (std::size_t j = 0; j < sites.size(); ++j) {
        const SparseRows::Row& row = transport.L.row(j);
        ASSERT_EQ(row.column, std::vector<Index>{1});
        EXPECT_DOUBLE_EQ(row.value[0], unblocked(mesh, lamps, sites.points[j]));
    }
    EXPECT_EQ(transport.segments, sites.size() * samples); // every sample sees the lamp's front
    EXPECT_EQ(transport.rays, 0U);
}

TEST(Lamps, EachMaterialHasItsOwnColumn) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.1, 0.3, 0.1, 0.3, 0.4, true));
    mesh = test::together(mesh, rectangle(0.6, 0.9, 0.6, 0.9, 0.2, true));
    Scene scene = scene_of(mesh, {2, 3, 4, 5});
    scene.materials.resize(4); // 2 does not emit
    scene.materials[3].emission = Rgb::Ones();
    scene.mesh.material[4] = scene.mesh.material[5] = 3;
    const SiteSet sites = sites_at(places(mesh, 3, 1, 1));
    const Transport transport = light(scene, {2, 3, 4, 5}, sites);
    for (std::size_t j = 0; j < sites.size(); ++j) {
        const SparseRows::Row& row = transport.L.row(j);
        ASSERT_EQ(row.column, (std::vector<Index>{1, 3}));
        // The lower one hides a part of the upper one from some sites, and nothing hides the lower one.
        const double lower = unblocked(mesh, {4, 5}, sites.points[j]);
        EXPECT_DOUBLE_EQ(row.value[1], lower);
        EXPECT_LE(row.value[0], unblocked(mesh, {2, 3}, sites.points[j]) * (1.0 + 1e-15));
    }
}

TEST(Lamps, ALampLightsNeitherItselfNorWhatIsBehindIt) {
    // A lamp facing up at height 0, a wall above it facing down, and one below it facing up.
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 0.5, true));
    mesh = test::together(mesh, rectangle(0, 1, 0, 1, -0.5));
    const Scene scene = scene_of(mesh, {0, 1});
    const SiteSet sites = sites_at({mesh.at(0, 0.3, 0.3), mesh.at(2, 0.3, 0.3), mesh.at(4, 0.3, 0.3)});
    const Transport transport = light(scene, {0, 1}, sites);
    EXPECT_TRUE(transport.L.row(0).column.empty());
    EXPECT_DOUBLE_EQ(transport.L.row_sum(1), unblocked(mesh, {0, 1}, sites.points[1]));
    EXPECT_TRUE(transport.L.row(2).column.empty());
}

TEST(Lamps, ASiteOnALampIsLitByTheOthersOfItsMaterial) {
    // Two lamps of one material that face each other.
    const Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    const std::vector<Index> lamps{0, 1, 2, 3};
    const SiteSet sites = sites_at({mesh.at(0, 0.2, 0.2)});
    EXPECT_DOUBLE_EQ(light(scene_of(mesh, lamps), lamps, sites).L.row_sum(0), unblocked(mesh, {2, 3}, sites.points[0]));
}

TEST(Lamps, AScreenThatHidesAllLeavesNothing) {
    for (const bool down : {false, true}) { // backs block as fronts do
        Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.2, 0.7, 0.1, 0.3, 0.4, true));
        mesh = test::together(mesh, rectangle(-1, 2, -1, 2, 0.2, down));
        const Transport transport = light(scene_of(mesh, {2, 3}), {2, 3}, sites_at(places(mesh, 8, 1, 1)));
        EXPECT_EQ(transport.L.nonzeros(), 0U);
        EXPECT_EQ(transport.segments, 64 * samples);
    }
}

/// One place under a lamp, a big screen with a straight border over it. Each site there draws samples of its own: their
/// mean comes near the form factor of the lamp's part that the border leaves.
TEST(Lamps, AScreenThatHidesAPart) {
    const double border = -0.1; // of the screen at half the lamp's height: it hides the lamp where x < 2 border
    Mesh mesh = test::together(rectangle(-2, 2, -2, 2, 0), rectangle(-0.5, 0.5, -0.5, 0.5, 1, true));
    mesh = test::together(mesh, rectangle(-10, border, -10, 10, 0.5));
    SurfacePoint x;
    x.face = 0;
    const std::size_t count = 4096;
    const Transport transport = light(scene_of(mesh, {2, 3}), {2, 3}, sites_at(std::vector(count, x)));

    const Mesh seen = rectangle(2 * border, 0.5, -0.5, 0.5, 1, true);
    const double all = unblocked(mesh, {2, 3}, x), part = unblocked(seen, {0, 1}, x) / all;
    EXPECT_GT(part, 0.6);
    double mean = 0.0, largest = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
        const double error = transport.L.row_sum(j) / all - part;
        mean += error / static_cast<double>(count);
        largest = std::max(largest, std::abs(error));
    }
    // Even independent samples would stray by sqrt(part (1-part) / 64) <= 1/16 a site, 4.5 standard deviations of the
    // mean of 4096 are 0.0044. The ratio of sums is biased by less than the squared variation of the integrand over
    // the lamp (below 0.04) over 64 samples: 0.0006.
    EXPECT_NEAR(mean, 0.0, 0.005);
    EXPECT_LT(largest, 4.5 / 16);
    EXPECT_GT(largest, 0.0);
}

/// Unit squares at z = 0 and 1 with a blocker [0,1/2]² at z = 1/2: the form factor is known.
TEST(Lamps, BlockedSquares) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    mesh = test::together(mesh, rectangle(0, 0.5, 0, 0.5, 0.5));
    const int n = 64;
    const Transport transport = light(scene_of(mesh, {2, 3}), {2, 3}, sites_at(places(mesh, n, 1, 1)));
    double mean = 0.0;
    for (std::size_t j = 0; j < transport.L.rows(); ++j) {
        mean += transport.L.row_sum(j) / (n * n);
    }
    // A site strays by at most F/16 <= 0.016 (see above), 4.5 standard deviations of the mean are 0.0011; the rule of
    // middles adds less than 1/n² = 0.0003 of an irradiance that has no jump.
    EXPECT_NEAR(mean, 0.1498686718, 0.0014);
}

TEST(Lamps, SameBitsForAnyNumberOfThreads) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    mesh = test::together(mesh, rectangle(0, 0.5, 0, 0.5, 0.5));
    const Scene scene = scene_of(mesh, {2, 3});
    const SiteSet sites = sites_at(places(mesh, 16, 1, 1));
    const Transport one = light(scene, {2, 3}, sites, 7, 1), other_seed = light(scene, {2, 3}, sites, 8, 1);
    bool seed_matters = false;
    for (const unsigned threads : {2U, 5U}) {
        const Transport many = light(scene, {2, 3}, sites, 7, threads);
        EXPECT_EQ(many.segments, one.segments);
        for (std::size_t j = 0; j < sites.size(); ++j) {
            EXPECT_EQ(many.L.row(j).column, one.L.row(j).column);
            EXPECT_EQ(many.L.row(j).value, one.L.row(j).value);
            seed_matters = seed_matters || other_seed.L.row(j).value != one.L.row(j).value;
        }
    }
    EXPECT_TRUE(seed_matters);
}

TEST(Lamps, TheSizeOfTheSceneDoesNotMatter) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    mesh = test::together(mesh, rectangle(0, 0.5, 0, 0.5, 0.5));
    const std::vector<SurfacePoint> points = places(mesh, 8, 1, 1);
    const Transport one = light(scene_of(mesh, {2, 3}), {2, 3}, sites_at(points));
    for (const double scale : {0x1p-20, 0x1p20}) {
        std::vector<SurfacePoint> scaled = points;
        for (SurfacePoint& x : scaled) {
            x.position *= scale;
        }
        const Scene scene = scene_of(test::moved(mesh, scale, Vec3::Zero()), {2, 3});
        const Transport other = light(scene, {2, 3}, sites_at(scaled));
        for (std::size_t j = 0; j < points.size(); ++j) {
            EXPECT_NEAR(other.L.row_sum(j), one.L.row_sum(j), 1e-14) << scale;
        }
    }
}

/// Estimates of one ray, in the mean: whether few lamps are chosen by form factor or many by power, partly hidden or
/// not.
TEST(Lamps, SamplesHaveTheirIrradianceAsMean) {
    for (const int cells : {1, 5}) { // 2 and 50 triangles
        const Mesh lamp = test::moved(test::grid(cells, cells, 1.0, 1.0, true), 1.0, Vec3(-0.5, -0.5, 3.0));
        Mesh mesh = test::together(rectangle(-2, 2, -2, 2, 0), lamp);
        mesh = test::together(mesh, rectangle(-10, 0, -10, 10, 1.5));
        std::vector<Index> lamps;
        for (Index t = 0; t < lamp.triangles.size(); ++t) {
            lamps.push_back(2 + t);
        }
        const Scene scene = scene_of(mesh, lamps);
        BruteForceVisibility visibility;
        visibility.build(scene.mesh);
        const Lamps light(scene, lamps, visibility);
        SurfacePoint x;
        x.position = Vec3(0.1, 0.2, 0.0);
        x.face = 0;
        // The screen at half height hides the lamp where it is left of -0.1 as seen from x.
        const Mesh seen = rectangle(-0.1, 0.5, -0.5, 0.5, 3, true);
        const double F = unblocked(seen, {0, 1}, x);
        Lamps::Worker worker;
        RandomStream stream(1, "samples");
        const int count = 20000;
        double mean = 0.0, squares = 0.0;
        for (int i = 0; i < count; ++i) {
            const Rgb H = light.sample(x, stream, worker);
            EXPECT_DOUBLE_EQ(H[1], 2.0 * H[0]);
            EXPECT_DOUBLE_EQ(H[2], 3.0 * H[0]);
            mean += H[0] / count;
            squares += H[0] * H[0] / count;
        }
        EXPECT_NEAR(mean, F, 4.5 * std::sqrt((squares - mean * mean) / count)) << cells;
        EXPECT_LT(squares, 2.0 * F * F); // the sample varies mostly by being hidden or not (3/5 are seen)
    }
}

/// A row of `cells` unit squares of two triangles each, the first `bright` of them emitting, `materials` in turn.
std::vector<Index> chosen(int cells, int bright, int materials = 1) {
    Scene scene;
    scene.mesh = test::grid(cells, 1, cells, 1.0);
    scene.materials.resize(static_cast<std::size_t>(materials) + 1);
    for (int m = 1; m <= materials; ++m) {
        scene.materials[static_cast<std::size_t>(m)].emission = Rgb(0, 0, 1);
    }
    for (int cell = 0; cell < bright; ++cell) {
        const auto material = static_cast<Index>(1 + cell % materials);
        scene.mesh.material[static_cast<std::size_t>(2 * cell)] = material;
        scene.mesh.material[static_cast<std::size_t>(2 * cell) + 1] = material;
    }
    return lamp_triangles(scene);
}

TEST(Lamps, WhichTrianglesAreLamps) {
    EXPECT_EQ(chosen(100, 2), (std::vector<Index>{0, 1, 2, 3}));
    EXPECT_TRUE(chosen(100, 0).empty());
    EXPECT_EQ(chosen(100, 9).size(), 18U); // at most a tenth of the surface
    EXPECT_TRUE(chosen(100, 11).empty());
    EXPECT_EQ(chosen(24000, 2048).size(), 4096U); // at most 4096 triangles
    EXPECT_TRUE(chosen(24000, 2049).empty());
    EXPECT_EQ(chosen(400, 32, 32).size(), 64U); // at most 32 materials
    EXPECT_TRUE(chosen(400, 33, 33).empty());
}

} // namespace
} // namespace difusa
