// Where a camera looks, how pixels are sampled, and which camera a scene gets.
#include <difusa/core/error.h>
#include <difusa/mesh/floor_share.h>
#include <difusa/rays/brute_force.h>
#include <difusa/render/camera_rays.h>
#include <difusa/render/place_camera.h>

#include <meshes.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace difusa::camera_rays_test {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

Camera some_camera() {
    return {Vec3(1.0, -2.0, 0.5), Vec3(1.0, 2.0, -0.3).normalized(), Vec3(0.1, 0.0, 1.0).normalized(), 0.8};
}

TEST(CameraRays, TheMiddleIsTowardsAndTheEdgesAreAtTheirAngles) {
    const Camera camera = some_camera();
    constexpr std::size_t width = 64, height = 40;
    const CameraRays view(camera, width, height);
    EXPECT_NEAR((view.direction(32.0, 20.0) - camera.towards).norm(), 0.0, 8.0 * eps);
    // The upper and lower edges are half of the angle away; a corner has the tangents of both halves.
    const double half = std::tan(0.4), aspect = 1.6;
    EXPECT_NEAR(std::acos(view.direction(32.0, 0.0).dot(view.direction(32.0, 40.0))), 0.8, 1e-14);
    for (const double column : {0.0, 64.0}) {
        for (const double row : {0.0, 40.0}) {
            EXPECT_NEAR(view.direction(column, row).dot(camera.towards),
                        1.0 / std::sqrt(1.0 + half * half * (1.0 + aspect * aspect)), 8.0 * eps);
        }
    }
    // Up is up, right is right, and nothing is mirrored.
    EXPECT_GT(view.direction(32.0, 0.0).dot(camera.up), view.direction(32.0, 40.0).dot(camera.up));
    EXPECT_GT(view.direction(64.0, 20.0).dot(camera.towards.cross(camera.up)), 0.0);
    EXPECT_NEAR(view.direction(64.0, 20.0).dot(camera.up), view.direction(0.0, 20.0).dot(camera.up), 8.0 * eps);
}

TEST(CameraRays, PointsAreSeenWhereTheirRaysGoThrough) {
    const CameraRays view(some_camera(), 33, 77);
    for (const auto& [column, row] : {std::pair(0.0, 0.0), {12.3, 70.1}, {33.0, 5.5}}) {
        for (const double distance : {1e-6, 1.0, 1e6}) {
            const auto place = view.place_of(view.eye() + distance * view.direction(column, row));
            ASSERT_TRUE(place);
            EXPECT_NEAR((*place)[0], column, 1e-6);
            EXPECT_NEAR((*place)[1], row, 1e-6);
        }
    }
    EXPECT_FALSE(view.place_of(view.eye() - view.direction(3.0, 4.0)));
}

TEST(CameraRays, ACameraThatCannotBeIsRefused) {
    Camera camera = some_camera();
    camera.up = camera.towards;
    EXPECT_THROW(CameraRays(camera, 4, 4), std::invalid_argument);
    camera = some_camera();
    camera.view_angle = 3.2;
    EXPECT_THROW(CameraRays(camera, 4, 4), std::invalid_argument);
}

TEST(JitteredPlaces, OneInEachCellEachColumnAndEachRow) {
    for (const std::size_t k : {1U, 2U, 3U, 4U, 7U}) {
        for (std::uint64_t index = 0; index < 20; ++index) {
            RandomStream stream(5, "jitter", index);
            std::set<std::size_t> cells, columns, rows;
            const auto n = static_cast<double>(k);
            for (const auto& [x, y] : jittered_places(k, stream)) {
                cells.insert(static_cast<std::size_t>(x * n) * k + static_cast<std::size_t>(y * n));
                columns.insert(static_cast<std::size_t>(x * n * n));
                rows.insert(static_cast<std::size_t>(y * n * n));
            }
            EXPECT_EQ(cells.size(), k * k);
            EXPECT_EQ(columns.size(), k * k);
            EXPECT_EQ(rows.size(), k * k);
        }
    }
}

/// The share of the picture's rays that meet a front, and of those that meet anything.
std::pair<double, double> met(const Visibility& visibility, const Camera& camera) {
    constexpr std::size_t n = 40;
    const CameraRays view(camera, n, n);
    std::size_t fronts = 0, all = 0;
    for (std::size_t i = 0; i < n * n; ++i) {
        const Ray ray{view.eye(), view.direction(static_cast<double>(i % n) + 0.5, static_cast<double>(i / n) + 0.5),
                      none};
        Hit hit;
        visibility.first_hits(std::span(&ray, 1), std::span(&hit, 1));
        fronts += hit.face != none && hit.front ? 1 : 0;
        all += hit.face != none ? 1 : 0;
    }
    return {static_cast<double>(fronts) / (n * n), static_cast<double>(all) / (n * n)};
}

TEST(PlaceCamera, AClosedRoomIsSeenFromInsideAndABodyFromOutsideAsAWhole) {
    for (const double scale : {1e-3, 1.0, 1e5}) {
        for (const bool inward : {false, true}) {
            Mesh mesh = test::box(Vec3(2.0, 3.0, 1.0));
            if (inward) {
                test::flip(mesh);
            }
            mesh = test::moved(mesh, scale, scale * Vec3(5.0, -7.0, 1.0));
            BruteForceVisibility visibility;
            visibility.build(mesh);
            const Camera camera = place_camera({}, std::nullopt, Vec3::UnitZ(), mesh, visibility, 1.0);
            const auto [fronts, all] = met(visibility, camera);
            EXPECT_EQ(fronts, all);
            const bool inside =
                ((camera.eye - mesh.low).array() > 0.0).all() && ((mesh.high - camera.eye).array() > 0.0).all();
            EXPECT_EQ(inside, inward);
            if (inward) {
                EXPECT_EQ(all, 1.0);
                continue;
            }
            EXPECT_GT(all, 0.2);
            const CameraRays view(camera, 1, 1);
            for (const Vec3& point : mesh.points) {
                const auto place = view.place_of(point);
                ASSERT_TRUE(place);
                for (const double coordinate : *place) {
                    EXPECT_GT(coordinate, 0.0);
                    EXPECT_LT(coordinate, 1.0);
                }
            }
        }
    }
}

TEST(PlaceCamera, WishesGoBeforeTheCameraOfTheFile) {
    const Mesh mesh = test::box(1.0);
    BruteForceVisibility visibility;
    visibility.build(mesh);
    const Camera of_file = some_camera();
    const Camera same = place_camera({}, of_file, Vec3::UnitX(), mesh, visibility, 1.0);
    EXPECT_EQ(same.eye, of_file.eye);
    EXPECT_EQ(same.towards, of_file.towards);
    EXPECT_EQ(same.view_angle, of_file.view_angle);
    CameraWishes wishes;
    wishes.look_at = Vec3(1.0, 0.0, 0.5);
    wishes.view_angle = 1.0;
    const Camera other = place_camera(wishes, of_file, Vec3::UnitX(), mesh, visibility, 1.0);
    EXPECT_EQ(other.eye, of_file.eye);
    EXPECT_EQ(other.towards, Vec3::UnitY());
    EXPECT_EQ(other.view_angle, 1.0);
    EXPECT_EQ(same.up, of_file.up); // not that of the scene
    wishes.towards = Vec3::UnitX();
    EXPECT_THROW(place_camera(wishes, of_file, Vec3::UnitX(), mesh, visibility, 1.0), UsageError);
    CameraWishes down;
    down.towards = -Vec3::UnitZ();
    const Camera plan = place_camera(down, std::nullopt, Vec3::UnitZ(), mesh, visibility, 1.0);
    EXPECT_EQ(plan.towards, -Vec3::UnitZ());
    EXPECT_EQ(plan.up, Vec3::UnitY());
    down.up = Vec3::UnitZ();
    EXPECT_THROW(place_camera(down, std::nullopt, Vec3::UnitZ(), mesh, visibility, 1.0), UsageError);
    CameraWishes eye;
    eye.eye = Vec3(0.5, 0.5, 9.0);
    eye.up = Vec3::UnitX();
    EXPECT_EQ(place_camera(eye, std::nullopt, Vec3::UnitZ(), mesh, visibility, 1.0).towards, -Vec3::UnitZ());
}

TEST(PlaceCamera, OneWishReplacesWhatItNames) {
    const Mesh mesh = test::box(Vec3(2.0, 3.0, 1.0), 1, true);
    BruteForceVisibility visibility;
    visibility.build(mesh);
    const auto place = [&](const CameraWishes& wishes) {
        return place_camera(wishes, std::nullopt, Vec3::UnitZ(), mesh, visibility, 1.0);
    };
    const Camera default_view = place({});
    CameraWishes look_at;
    look_at.look_at = Vec3(1.0, 1.5, 0.5);
    EXPECT_EQ(place(look_at).eye, default_view.eye);
    EXPECT_EQ(place(look_at).towards, (*look_at.look_at - default_view.eye).normalized());
    // A direction alone looks across the room, from nine tenths of the way to the wall behind.
    CameraWishes towards;
    towards.towards = Vec3(0.0, 2.0, 0.0);
    EXPECT_EQ(place(towards).towards, Vec3::UnitY());
    EXPECT_LT((place(towards).eye - Vec3(1.0, 0.15, 0.5)).norm(), 1e-12);
}

TEST(PlaceCamera, IsUprightByTheScenesUp) {
    const Mesh mesh = test::box(Vec3(2.0, 3.0, 1.0));
    BruteForceVisibility visibility;
    visibility.build(mesh);
    for (const Vec3& up : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ()), Vec3(-Vec3::UnitY())}) {
        const Camera camera = place_camera({}, std::nullopt, up, mesh, visibility, 1.0);
        EXPECT_EQ(camera.up, up);
        EXPECT_LT(camera.towards.dot(up), -0.1); // from above
        EXPECT_GT(camera.towards.dot(up), -0.9);
    }
}

TEST(PlaceCamera, KnowsWhatAPictureMeets) {
    const Mesh mesh = test::box(1.0);
    BruteForceVisibility visibility;
    visibility.build(mesh);
    const auto coverage = [&](const Vec3& eye, const Vec3& towards) {
        return coverage_of({eye, towards, Vec3::UnitZ(), 0.5}, visibility, 1.0);
    };
    const Coverage nothing = coverage({0.5, -3.0, 0.5}, -Vec3::UnitY());
    EXPECT_EQ(nothing.fronts + nothing.backs, 0.0);
    const Coverage backs = coverage(Vec3::Constant(0.5), Vec3::UnitY());
    EXPECT_EQ(backs.fronts, 0.0);
    EXPECT_EQ(backs.backs, 1.0);
    // The near side fills the square of half width 0.5 / (3 tan 0.25) of the picture's.
    const Coverage fronts = coverage({0.5, -3.0, 0.5}, Vec3::UnitY());
    const double share = std::pow(0.5 / (3.0 * std::tan(0.25)), 2);
    EXPECT_NEAR(fronts.fronts, share, 4.0 * std::sqrt(share) / 96.0); // a row of rays at each edge
    EXPECT_EQ(fronts.backs, 0.0);
}

TEST(FloorShare, TellsWhereAFloorIs) {
    const Mesh room = test::box(Vec3(2.0, 3.0, 1.0), 2, true);
    EXPECT_NEAR(floor_share(room, Vec3::UnitY()), 1.0, 1e-12);
    EXPECT_NEAR(floor_share(room, Vec3::UnitZ()), 1.0, 1e-12);
    EXPECT_EQ(floor_share(test::box(1.0), Vec3::UnitZ()), 0.0); // faces down
    const Mesh ground = test::together(test::grid(4, 4, 2.0, 2.0), test::moved(test::box(1.0), 0.5, Vec3(1, 1, 0.1)));
    EXPECT_NEAR(floor_share(ground, Vec3::UnitZ()), 1.0, 1e-12);
    EXPECT_EQ(floor_share(ground, Vec3::UnitY()), 0.0);
}

} // namespace
} // namespace difusa::camera_rays_test
