#include "support/sanitized.h"

#include <difusa/rays/brute_force.h>
#include <difusa/rays/visibility.h>

#include <support/plugins.h>
#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace difusa::visibility_test {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

std::shared_ptr<Visibility> engine(const std::string& name, const Mesh& mesh) {
    std::shared_ptr<Visibility> visibility =
        name == "brute force" ? std::make_shared<BruteForceVisibility>() : test::plugin<Visibility>(name);
    visibility->build(mesh);
    return visibility;
}

std::vector<std::string> engines() {
    std::vector<std::string> all = test::plugin_names<Visibility>();
    all.emplace_back("brute force");
    return all;
}

Hit first_hit(const Visibility& visibility, const Ray& ray) {
    Hit hit;
    visibility.first_hits({&ray, 1}, {&hit, 1});
    return hit;
}

bool blocked(const Visibility& visibility, const Segment& segment) {
    std::uint8_t result = 2;
    visibility.occluded({&segment, 1}, {&result, 1});
    EXPECT_LE(result, 1);
    return result == 1;
}

/// Random triangles of all sizes in the unit cube: they cross each other.
Mesh soup(std::size_t count, RandomStream random) {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (std::size_t t = 0; t < count; ++t) {
        const Vec3 centre(random.uniform(), random.uniform(), random.uniform());
        const double size = 0.5 * std::pow(random.uniform(), 3.0) + 0.01;
        for (int k = 0; k < 3; ++k) {
            points.emplace_back(centre + size * test::random_direction(random));
        }
        const auto a = static_cast<Index>(3 * t);
        triangles.push_back({a, a + 1, a + 2});
    }
    return test::make_mesh(std::move(points), std::move(triangles));
}

struct Case {
    std::string name;
    Mesh mesh;
};

std::vector<Case> cases() {
    std::vector<Case> all;
    all.push_back({"soup", soup(300, RandomStream(1, "soup"))});
    all.push_back({"room with block", test::room_with_block()});
    all.push_back({"sphere", test::icosphere(2, 1.0, true)});
    all.push_back({"needles", test::needles(200)});
    all.push_back({"Moebius strip", test::mobius(50)});
    all.push_back({"tiny", test::moved(test::l_room(), 1e-6, Vec3::Zero())});
    all.push_back({"large", test::moved(test::l_room(), 1e6, Vec3::Zero())});
    all.push_back({"far away", test::moved(test::l_room(), 1.0, Vec3(1e6, -2e6, 3e6))});
    return all;
}

/// Rays from surface points and from free points around the mesh, in all directions, of lengths around `unit`.
std::vector<Ray> rays_around(const Mesh& mesh, std::size_t count, RandomStream random) {
    std::vector<Ray> rays;
    const std::vector<SurfacePoint> points = test::random_points(mesh, count, random);
    for (const SurfacePoint& x : points) {
        Vec3 direction = test::random_direction(random) * (0.1 + 10.0 * random.uniform());
        if (x.normal.dot(direction) < 0.0) {
            direction = -direction;
        }
        rays.push_back({x.position, direction, x.face});
        const Vec3 free = x.position + (0.3 * mesh.diameter()) * test::random_direction(random);
        rays.push_back({free, test::random_direction(random), none});
    }
    return rays;
}

TEST(Visibility, EnginesAgreeWithAskingEveryTriangle) {
    for (const Case& c : cases()) {
        BruteForceVisibility twin;
        twin.build(c.mesh);
        const std::vector<Ray> rays = rays_around(c.mesh, 1500, RandomStream(2, "rays"));
        std::vector<Hit> expected(rays.size()), hits(rays.size());
        twin.first_hits(rays, expected);
        for (const std::string& name : test::plugin_names<Visibility>()) {
            SCOPED_TRACE(c.name + ", " + name);
            engine(name, c.mesh)->first_hits(rays, hits);
            std::size_t different = 0, met = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const Hit &hit = hits[i], &truth = expected[i];
                different += hit.face != truth.face || hit.front != truth.front || hit.t != truth.t ||
                                     hit.u != truth.u || hit.v != truth.v
                                 ? 1
                                 : 0;
                if (hit.face == none) {
                    EXPECT_EQ(hit.t, std::numeric_limits<double>::infinity());
                    continue;
                }
                ++met;
                const SurfacePoint at = c.mesh.at(hit.face, hit.u, hit.v);
                const double along = (at.position - rays[i].origin).dot(rays[i].direction.normalized());
                EXPECT_NEAR(along, hit.t * rays[i].direction.norm(),
                            1e-9 * c.mesh.diameter() + 64 * eps * c.mesh.magnitude());
            }
            EXPECT_EQ(different, 0U);
            EXPECT_GT(met, rays.size() / 10);
        }
    }
}

TEST(Visibility, SegmentsAgreeWithAskingEveryTriangleAndRunBothWays) {
    for (const Case& c : cases()) {
        const std::vector<SurfacePoint> points = test::random_points(c.mesh, 3000, RandomStream(5, "points"));
        std::vector<Segment> there, back;
        for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
            there.push_back({points[i].position, points[i + 1].position, points[i].face, points[i + 1].face});
            back.push_back({points[i + 1].position, points[i].position, points[i + 1].face, points[i].face});
        }
        std::vector<std::uint8_t> expected(there.size()), forward(there.size()), backward(there.size());
        engine("brute force", c.mesh)->occluded(there, expected);
        for (const std::string& name : engines()) {
            SCOPED_TRACE(c.name + ", " + name);
            const auto visibility = engine(name, c.mesh);
            visibility->occluded(there, forward);
            visibility->occluded(back, backward);
            std::size_t different = 0, one_way = 0, free = 0;
            for (std::size_t i = 0; i < there.size(); ++i) {
                different += forward[i] != expected[i] ? 1 : 0;
                one_way += forward[i] != backward[i] ? 1 : 0;
                free += forward[i] == 0 ? 1 : 0;
            }
            EXPECT_EQ(different, 0U);
            EXPECT_EQ(one_way, 0U);
            EXPECT_GT(free, 0U);
        }
    }
}

/// Rays aimed exactly at shared edges and vertices from inside must not escape.
void expect_watertight(const Mesh& mesh, const std::vector<Vec3>& eyes, std::size_t per_edge) {
    RandomStream random(11, "aim");
    std::vector<Ray> rays;
    for (const Vec3& eye : eyes) {
        for (const auto& triangle : mesh.triangles) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 a = mesh.points[triangle[k]], b = mesh.points[triangle[(k + 1) % 3]];
                rays.push_back({eye, a - eye, none});
                rays.push_back({eye, 0.5 * (a + b) - eye, none});
                for (std::size_t i = 0; i < per_edge; ++i) {
                    const Vec3 target = a + random.uniform() * (b - a);
                    rays.push_back({eye, (target - eye) * (i % 2 == 0 ? 1.0 : 0.37), none});
                }
            }
        }
    }
    std::vector<Hit> hits(rays.size());
    for (const std::string& name : engines()) {
        if (name == "brute force" && mesh.triangles.size() * rays.size() > 4'000'000) {
            continue;
        }
        engine(name, mesh)->first_hits(rays, hits);
        std::size_t escaped = 0, back = 0;
        for (const Hit& hit : hits) {
            escaped += hit.face == none ? 1 : 0;
            back += hit.face != none && !hit.front ? 1 : 0;
        }
        EXPECT_EQ(escaped, 0U) << name << ": of " << rays.size() << " rays";
        EXPECT_EQ(back, 0U) << name << ": of " << rays.size() << " rays";
    }
}

// Under the sanitizers the same edges and vertices, seen from fewer points.
const int random_eyes = test::sanitized() ? 1 : 6, rays_per_triangle = test::sanitized() ? 20 : 200;

TEST(Visibility, NothingEscapesThroughEdgesAndVertices) {
    RandomStream random(3, "eyes");
    std::vector<Vec3> eyes{Vec3::Zero()};
    for (int i = 0; i < random_eyes; ++i) {
        eyes.emplace_back(0.5 * random.uniform() * test::random_direction(random));
    }
    const Mesh cube = test::moved(test::box(1.0, 6, true), 2.0, Vec3(-1, -1, -1));
    expect_watertight(cube, eyes, 20);
    expect_watertight(test::icosphere(1, 1.0, true), eyes, 60);
    expect_watertight(test::icosphere(3, 1.0, true), eyes, 6);
    const Eigen::Matrix3d R = test::random_rotation(random);
    expect_watertight(test::transformed(test::box(1.0, 4, true), R, 2.0, -(R * Vec3(1, 1, 1))), eyes, 20);
    for (const auto& [scale, offset] : std::vector<std::pair<double, Vec3>>{
             {1e-6, Vec3(0, 0, 0)}, {1e6, Vec3(0, 0, 0)}, {1.0, Vec3(1e6, 2e6, -3e6)}}) {
        std::vector<Vec3> moved_eyes = eyes;
        for (Vec3& eye : moved_eyes) {
            eye = scale * eye + offset;
        }
        expect_watertight(test::moved(test::icosphere(2, 1.0, true), scale, offset), moved_eyes, 6);
        expect_watertight(test::moved(cube, scale, offset), moved_eyes, 6);
    }
}

TEST(Visibility, NothingEscapesFromSitesBesideEdges) {
    // Surface points close to edges, looking along their wall and at the neighbouring one.
    for (const Mesh& mesh : {test::box(1.0, 2, true), test::icosphere(2, 1.0, true), test::l_room()}) {
        RandomStream random(4, "rays");
        std::vector<Ray> rays;
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            for (int i = 0; i < rays_per_triangle; ++i) {
                // Over the edge the ray is at least 1e-12 above its plane; less is within rounding of the own face.
                const double near = std::pow(10.0, -6.0 * random.uniform());
                const SurfacePoint x = mesh.at(t, near * (1.0 - random.uniform()), (1.0 - near) * random.uniform());
                Vec3 direction = test::random_direction(random);
                direction += (std::pow(10.0, -6.0 * random.uniform()) - x.normal.dot(direction)) * x.normal;
                rays.push_back({x.position, direction, t});
            }
        }
        std::vector<Hit> hits(rays.size());
        for (const std::string& name : engines()) {
            engine(name, mesh)->first_hits(rays, hits);
            std::size_t escaped = 0;
            for (const Hit& hit : hits) {
                escaped += hit.face == none ? 1 : 0;
            }
            EXPECT_EQ(escaped, 0U) << name << ": of " << rays.size() << " rays";
        }
    }
}

TEST(Visibility, FacesAreMetFromBothSidesAndSaySo) {
    const Mesh mesh = test::grid(1, 1);
    for (const std::string& name : engines()) {
        const auto visibility = engine(name, mesh);
        const Hit above = first_hit(*visibility, {Vec3(0.7, 0.2, 2), Vec3(0, 0, -4), none});
        EXPECT_TRUE(above.front) << name;
        EXPECT_EQ(above.face, 0U) << name;
        EXPECT_NEAR(above.t, 0.5, 4 * eps) << name;
        const Hit below = first_hit(*visibility, {Vec3(0.7, 0.2, -2), Vec3(0, 0, 4), none});
        EXPECT_FALSE(below.front) << name;
        EXPECT_EQ(below.face, 0U) << name;
        EXPECT_EQ(first_hit(*visibility, {Vec3(0.7, 0.2, 2), Vec3(0, 0, 4), none}).face, none) << name;
        EXPECT_EQ(first_hit(*visibility, {Vec3(2, 2, 2), Vec3(0, 0, -4), none}).face, none) << name;
    }
}

TEST(Visibility, ARayDoesNotMeetThePlaneItLeaves) {
    // A wall of many triangles, another sheet in the same plane turned over, and walls at growing heights above.
    for (const double height : {1e-9, 1e-6, 1e-3, 0.5}) {
        for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(3, -2, 0)}) {
            const Mesh mesh =
                test::moved(test::together(test::together(test::grid(4, 4), test::grid(3, 3, 1.0, 1.0, true)),
                                           test::moved(test::grid(1, 1, 1.0, 1.0, true), 1.0, Vec3(0, 0, height))),
                            1.0, offset);
            for (const std::string& name : engines()) {
                const auto visibility = engine(name, mesh);
                RandomStream random(6, "rays");
                std::size_t wrong = 0;
                for (int i = 0; i < 300; ++i) {
                    // Up from the lower wall; the upper one covers what lies above it exactly.
                    const SurfacePoint x = test::random_point(mesh, static_cast<Index>(i % 32), random);
                    const Hit hit = first_hit(*visibility, {x.position, Vec3(0, 0, 2.0), x.face});
                    wrong +=
                        hit.face >= 50 && hit.face != none && hit.front && std::abs(2.0 * hit.t - height) <= 8 * eps
                            ? 0
                            : 1;
                    // Sideways within the plane there is nothing.
                    const Hit along = first_hit(*visibility, {x.position, Vec3(1, 0.3, 0), x.face});
                    wrong += along.face == none ? 0 : 1;
                    // From the wall above down: back to the lower one, whose front is up.
                    const SurfacePoint y = test::random_point(mesh, static_cast<Index>(50 + i % 2), random);
                    const Hit down = first_hit(*visibility, {y.position, Vec3(0, 0, -1), y.face});
                    wrong += down.face < 50 ? 0 : 1;
                    const Segment between{x.position, y.position, x.face, y.face};
                    wrong += blocked(*visibility, between) ? 1 : 0;
                }
                EXPECT_EQ(wrong, 0U) << name << ", height " << height << ", x " << offset.x();
            }
        }
    }
}

TEST(Visibility, AThinWallBlocksBothWays) {
    // Two rooms share a wall of two sheets `gap` apart, each facing its room: a ray meets the sheet of its own room.
    for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12}) {
        const Mesh left = test::box(1.0, 2, true);
        const Mesh mesh = test::together(left, test::moved(left, 1.0, Vec3(1.0 + gap, 0, 0)));
        const auto count = static_cast<Index>(left.triangles.size());
        for (const std::string& name : engines()) {
            const auto visibility = engine(name, mesh);
            std::size_t leaked = 0, behind = 0, seen = 0;
            const std::vector<SurfacePoint> points = test::random_points(mesh, 4000, RandomStream(7, "points"));
            RandomStream random(8, "rays");
            for (std::size_t i = 0; i + 1 < points.size(); ++i) {
                const SurfacePoint &x = points[i], &y = points[i + 1];
                Vec3 direction = test::random_direction(random);
                if (x.normal.dot(direction) < 0.0) {
                    direction = -direction;
                }
                const Hit hit = first_hit(*visibility, {x.position, direction, x.face});
                leaked += hit.face == none || (hit.front && (hit.face < count) != (x.face < count)) ? 1 : 0;
                behind += hit.face != none && !hit.front ? 1 : 0;
                if ((x.face < count) != (y.face < count)) {
                    const Vec3 way = y.position - x.position;
                    seen += x.normal.dot(way) > 0.0 && y.normal.dot(way) < 0.0 &&
                                    !blocked(*visibility, {x.position, y.position, x.face, y.face})
                                ? 1
                                : 0;
                }
            }
            EXPECT_EQ(leaked, 0U) << name << ", gap " << gap;
            EXPECT_EQ(behind, 0U) << name << ", gap " << gap << ": the far sheet hides the near one";
            EXPECT_EQ(seen, 0U) << name << ", gap " << gap;
        }
    }
}

TEST(Visibility, OfTwoSheetsInOnePlaceTheOneThatFacesTheRayIsMet) {
    // The shared wall of two rooms without any thickness, both sheets of the same triangles.
    for (const bool swap : {false, true}) {
        const Mesh up = test::grid(3, 3), down = test::grid(3, 3, 1.0, 1.0, true);
        const Mesh mesh = swap ? test::together(down, up) : test::together(up, down);
        for (const std::string& name : engines()) {
            const auto visibility = engine(name, mesh);
            RandomStream random(9, "rays");
            std::size_t backs = 0, missed = 0;
            for (int i = 0; i < 500; ++i) {
                const Vec3 target(random.uniform(), random.uniform(), 0.0);
                Vec3 direction = test::random_direction(random);
                direction.z() += std::copysign(0.1, direction.z());
                const Vec3 eye = target + direction;
                const Hit hit = first_hit(*visibility, {eye, target - eye, none});
                missed += hit.face == none ? 1 : 0;
                backs += hit.face != none && !hit.front ? 1 : 0;
            }
            EXPECT_EQ(missed, 0U) << name;
            EXPECT_EQ(backs, 0U) << name;
        }
    }
}

TEST(Visibility, FollowsTheSceneWhenItIsTurnedMovedAndScaled) {
    const Mesh mesh = test::room_with_block();
    const std::vector<Ray> rays = rays_around(mesh, 1000, RandomStream(12, "rays"));
    RandomStream random(13, "motions");
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const double far : {0.0, 1e3}) {
            const Eigen::Matrix3d R = test::random_rotation(random);
            const Vec3 offset = far * scale * Vec3(1, -2, 0.5);
            const Mesh other = test::transformed(mesh, R, scale, offset);
            std::vector<Ray> turned;
            for (const Ray& ray : rays) {
                turned.push_back({scale * (R * ray.origin) + offset, R * ray.direction, ray.face});
            }
            for (const std::string& name : engines()) {
                std::vector<Hit> before(rays.size()), after(rays.size());
                engine(name, mesh)->first_hits(rays, before);
                engine(name, other)->first_hits(turned, after);
                std::size_t flips = 0;
                for (std::size_t i = 0; i < rays.size(); ++i) {
                    if (before[i].face != after[i].face) {
                        ++flips;
                        continue;
                    }
                    if (before[i].face != none) {
                        const double precision = 1e-15 * (1.0 + 3.0 * far) * 64;
                        const double incidence = std::abs(mesh.normals[before[i].face].dot(rays[i].direction));
                        EXPECT_NEAR(after[i].t / scale, before[i].t, precision * mesh.diameter() / incidence) << name;
                        EXPECT_EQ(after[i].front, before[i].front);
                    }
                }
                EXPECT_EQ(flips, 0U) << name << " " << scale << " " << far;
            }
        }
    }
}

} // namespace
} // namespace difusa::visibility_test
