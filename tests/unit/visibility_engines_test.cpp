// All visibility engines give the answers of asking every triangle, to the last bit: in the committed scenes, on meshes
// made to be hard, at any size. Of hits in one place `comes_before` decides, in every engine. Only where a face is so
// narrow that rounding moves a hit along it (see `tie`) may the order of the search decide.
#include <difusa/core/error.h>
#include <difusa/import/scene_file.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>
#include <difusa/rays/visibility_choice.h>
#include <difusa/rays/watertight.h>
#include <difusa/repair/diagnosis.h>

#include <support/plugins.h>
#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace difusa::visibility_engines_test {
namespace {

std::shared_ptr<Visibility> engine(const std::string& name, const Mesh& mesh) {
    auto visibility = test::plugin<Visibility>(name);
    visibility->build(mesh);
    return visibility;
}

struct Queries {
    std::vector<Ray> rays;
    std::vector<Segment> segments;
};

/// Rays as `gather` casts them, rays from free points inside and far outside, rays exactly at corners and at middles of
/// edges; segments between surface points.
Queries queries(const Mesh& mesh, std::size_t count) {
    Queries all;
    RandomStream random(1, "queries");
    const std::vector<SurfacePoint> points = test::random_points(mesh, count, RandomStream(2, "points"));
    const DirectionPool pool(*test::plugin<Directions>("low-discrepancy"), 16, 1);
    std::vector<Ray> batch(pool.count());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SurfacePoint &x = points[i], &y = points[(i + 1) % points.size()];
        pool.rays(x, i, batch);
        all.rays.insert(all.rays.end(), batch.begin(), batch.end());
        const Vec3 free = x.position + 0.3 * mesh.diameter() * test::random_direction(random);
        all.rays.push_back({free, test::random_direction(random) * std::pow(10.0, 6.0 * random.uniform() - 3.0), none});
        const Vec3 outside = x.position + std::pow(10.0, 4.0 * random.uniform()) * mesh.diameter() * x.normal;
        all.rays.push_back({outside, (y.position - outside) / mesh.diameter(), none});
        for (int k = 0; k < 3; ++k) {
            const Vec3 a = mesh.corner(y.face, k), b = mesh.corner(y.face, (k + 1) % 3);
            all.rays.push_back({x.position, (a - x.position) / mesh.diameter(), x.face});
            all.rays.push_back({free, (0.5 * a + 0.5 * b - free) / mesh.diameter(), none});
        }
        all.segments.push_back({x.position, y.position, x.face, y.face});
        all.segments.push_back({free, y.position, none, y.face});
        all.segments.push_back({x.position, x.position, x.face, x.face}); // of no length
    }
    all.rays.push_back({points[0].position, Vec3::Zero(), points[0].face});
    return all;
}

/// A triangle test is off by `rounding` across the ray at most: on a face of least height h the place along its longest
/// side is known to rounding / h of its length.
double uncertainty(const Mesh& mesh, Index face, double rounding) {
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
        longest = std::max(longest, (mesh.corner(face, k) - mesh.corner(face, (k + 1) % 3)).norm());
    }
    return rounding / (2.0 * mesh.areas[face] / longest) * longest;
}

/// Two hits of a ray in one place, as far as that is known.
bool tie(const Mesh& mesh, const Ray& ray, const Hit& a, const Hit& b) {
    if (a.face == none || b.face == none) {
        return false;
    }
    const double rounding = WatertightRay::rounding(ray.origin, mesh.low, mesh.high);
    return std::abs(a.t - b.t) * ray.direction.norm() <=
           uncertainty(mesh, a.face, rounding) + uncertainty(mesh, b.face, rounding);
}

/// Every engine against asking every triangle or, where that takes long, against the reference `cgal`. Returns how many
/// rays ended in ties that were decided otherwise.
std::size_t expect_same(const Mesh& mesh, std::size_t count) {
    const Queries all = queries(mesh, count);
    std::shared_ptr<Visibility> truth = std::make_shared<BruteForceVisibility>();
    if (static_cast<double>(mesh.triangles.size()) * static_cast<double>(all.rays.size()) < 1e7) {
        truth->build(mesh);
    } else {
        truth = engine("cgal", mesh);
    }
    std::vector<Hit> expected(all.rays.size()), hits(all.rays.size());
    std::vector<std::uint8_t> expected_blocked(all.segments.size()), blocked(all.segments.size());
    truth->first_hits(all.rays, expected);
    truth->occluded(all.segments, expected_blocked);
    std::size_t ties = 0;
    for (const std::string& name : test::plugin_names<Visibility>()) {
        SCOPED_TRACE(name);
        const auto visibility = engine(name, mesh);
        visibility->first_hits(all.rays, hits);
        visibility->occluded(all.segments, blocked);
        std::size_t different = 0, met = 0;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const Hit &a = hits[i], &b = expected[i];
            met += b.face != none ? 1 : 0;
            if (a.face != b.face || a.front != b.front || a.t != b.t || a.u != b.u || a.v != b.v) {
                const bool tied = tie(mesh, all.rays[i], a, b);
                ties += tied ? 1 : 0;
                different += tied ? 0 : 1;
            }
        }
        EXPECT_EQ(different, 0U) << "of " << hits.size() << " rays";
        EXPECT_EQ(blocked, expected_blocked);
        EXPECT_GT(met, hits.size() / 20);
    }
    return ties;
}

TEST(VisibilityEngines, GiveTheSameAnswersInTheCommittedScenes) {
    std::size_t scenes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(DIFUSA_TEST_DATA)) {
        const std::string type = entry.path().extension().string();
        if (type == ".off" || type == ".obj" || type == ".ply" || type == ".json") {
            SCOPED_TRACE(entry.path().filename().string());
            EXPECT_EQ(expect_same(diagnose(read_scene(test::registry(), entry.path())).mesh, 500), 0U);
            ++scenes;
        }
    }
    EXPECT_GE(scenes, 15U);
}

TEST(VisibilityEngines, GiveTheSameAnswersOnHardMeshes) {
    const Mesh room = test::l_room(), box = test::box(1.0, 2, true);
    RandomStream random(3, "motions");
    std::vector<Mesh> meshes{test::needles(1000),
                             test::mobius(60),
                             test::together(box, box),
                             test::huge_among_tiny(20, 1e-6),
                             test::icosphere(4, 1.0, true),
                             test::together(test::grid(3, 3), test::grid(3, 3, 1.0, 1.0, true)),
                             test::together(test::grid(2, 2), test::moved(test::grid(3, 3), 1.0, Vec3(0.5, 0, 0)))};
    for (const double gap : {0.0, 1e-12, 1e-9, 1e-6, 1e-3}) {
        meshes.push_back(test::together(box, test::moved(box, 1.0, Vec3(1.0 + gap, 0, 0))));
        meshes.push_back(test::shelf_over_table(gap));
        if (gap > 0.0) {
            meshes.push_back(test::thin_wall(gap));
        }
    }
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const double far : {0.0, 1e3, 1e6, 1e9}) {
            meshes.push_back(
                test::transformed(room, test::random_rotation(random), scale, scale * far * Vec3(1, -0.7, 0.4)));
        }
    }
    std::size_t ties = 0;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        SCOPED_TRACE("mesh " + std::to_string(i));
        ties += expect_same(meshes[i], 300);
    }
    EXPECT_LE(ties, 5U); // rays exactly at edges of faces 1e-12 wide, all others not even these
}

/// Sizes at which the products of three lengths that a triangle test takes stay within double precision.
TEST(VisibilityEngines, GiveTheSameAnswersAtAnySize) {
    const Mesh room = test::room_with_block();
    for (const double scale : {1e-100, 1e-30, 1e-20, 1e20, 1e30, 1e100}) {
        SCOPED_TRACE(scale);
        EXPECT_EQ(expect_same(test::moved(room, scale, Vec3::Zero()), 300), 0U);
    }
    // Powers of two change no digit: the hits are those of the room, t apart.
    const Queries all = queries(room, 300);
    for (const double scale : {0x1p-300, 0x1p-100, 0x1p100, 0x1p300}) {
        const Mesh other = test::moved(room, scale, Vec3::Zero());
        std::vector<Ray> rays = all.rays;
        for (Ray& ray : rays) {
            ray.origin *= scale;
        }
        for (const std::string& name : test::plugin_names<Visibility>()) {
            SCOPED_TRACE(name);
            std::vector<Hit> before(rays.size()), after(rays.size());
            engine(name, room)->first_hits(all.rays, before);
            engine(name, other)->first_hits(rays, after);
            std::size_t different = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                different += before[i].face != after[i].face || before[i].u != after[i].u ||
                                     before[i].v != after[i].v || before[i].t * scale != after[i].t
                                 ? 1
                                 : 0;
            }
            EXPECT_EQ(different, 0U) << scale;
        }
    }
}

/// A mistake elsewhere may ask for such a ray: it does not end the process, and one from nowhere hits nothing.
TEST(VisibilityEngines, SurviveNumbersThatAreNotFinite) {
    const Mesh room = test::l_room();
    const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Ray> rays;
    std::vector<Segment> segments;
    for (const double bad : {inf, -inf, nan}) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 wrong(0.3, 0.4, 0.5);
            wrong[axis] = bad;
            rays.push_back({wrong, Vec3::UnitX(), none});
            rays.push_back({Vec3(0.3, 0.4, 0.5), wrong, none});
            segments.push_back({wrong, Vec3(0.5, 0.5, 0.5), none, none});
            segments.push_back({Vec3(0.5, 0.5, 0.5), wrong, none, none});
        }
    }
    rays.push_back({Vec3::Constant(nan), Vec3::UnitX(), 0});
    std::vector<Hit> hits(rays.size());
    std::vector<std::uint8_t> blocked(segments.size());
    for (const std::string& name : test::plugin_names<Visibility>()) {
        SCOPED_TRACE(name);
        const auto visibility = engine(name, room);
        visibility->first_hits(rays, hits);
        visibility->occluded(segments, blocked);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const bool nowhere = (rays[i].origin + rays[i].direction).hasNaN();
            EXPECT_TRUE(!nowhere || hits[i].face == none) << i;
        }
    }
}

TEST(VisibilityEngines, AutoIsTheFirstThatIsThere) {
    std::vector<std::string> notes;
    const bool fast = test::registry().find("visibility", "embree") != nullptr;
    EXPECT_EQ(choose_visibility(test::registry(), "auto", notes), fast ? "embree" : "cgal");
    EXPECT_EQ(choose_visibility(test::registry(), "cgal", notes), "cgal");
    EXPECT_THROW(choose_visibility(test::registry(), "embre", notes), UsageError);
    EXPECT_THROW(choose_visibility(test::registry(), "cgal:x=1", notes), UsageError);
    EXPECT_THROW(choose_visibility(Registry(), "auto", notes), UsageError);
    EXPECT_TRUE(notes.empty());
    Registry one;
    ASSERT_TRUE(one.add(test::registry().find("visibility", "cgal")->file));
    EXPECT_EQ(choose_visibility(one, "auto", notes), "cgal");
    EXPECT_TRUE(notes.empty());
}

TEST(VisibilityEngines, AutoPassesOverAnEngineThatCannotBeStarted) {
    Registry registry;
    ASSERT_TRUE(registry.add(test::test_module("idle_embree")));
    ASSERT_TRUE(registry.add(test::registry().find("visibility", "cgal")->file));
    std::vector<std::string> notes;
    EXPECT_EQ(choose_visibility(registry, "auto", notes), "cgal");
    ASSERT_EQ(notes.size(), 1U);
    EXPECT_EQ(notes[0], "visibility cgal is used instead of embree: it cannot be started");
    // Asked for by name it is a failure.
    EXPECT_THROW(registry.create<Visibility>("embree"), ResourceError);
    Registry alone;
    ASSERT_TRUE(alone.add(test::test_module("idle_embree")));
    EXPECT_THROW(choose_visibility(alone, "auto", notes), ResourceError);
}

} // namespace
} // namespace difusa::visibility_engines_test
