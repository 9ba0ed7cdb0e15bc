#include <difusa/bake.h>
#include <difusa/bake/sensor_lift.h>

#include <meshes.h>
#include <support/sited.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace difusa::sensor_lift_test {
namespace {

Sensor planar(const Vec3& position, const Vec3& axis) {
    return {position, axis.normalized(), SensorKind::planar};
}

Vec3 moved(const SensorLift& lift, const Sensor& sensor) {
    return lift(sensor, sensor.axis, SensorLift::Back::in_plane).position;
}

/// The least height over all faces of a room.
double least_height(const Mesh& mesh, const Vec3& p) {
    double least = 1e300;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        least = std::min(least, mesh.normals[t].dot(p - mesh.corner(t, 0)));
    }
    return least;
}

/// On walls, edges and corners of a room, however it is turned, whatever the axis is to within rounding: in front of
/// all faces, by as much as is said, and no farther off than the sharpest corner asks for.
TEST(SensorLift, StaysInTheRoom) {
    for (const double degrees : {0.0, 10.0, 30.0, 45.0, 70.0}) {
        const Eigen::Matrix3d turn =
            Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Vec3(1, 2, 3).normalized()).toRotationMatrix();
        Mesh mesh = test::box(Vec3(4, 3, 2.5), 1, true);
        for (Vec3& point : mesh.points) {
            point = turn * point;
        }
        mesh = test::make_mesh(mesh.points, {mesh.triangles.begin(), mesh.triangles.end()});
        const SensorLift lift(mesh);
        const double least = 2.0 * SensorLift::touching * mesh.diameter();
        for (const Vec3& at : {Vec3(0, 1, 1), Vec3(4, 1.5, 0), Vec3(4, 3, 0), Vec3(0, 0, 1.2), Vec3(0, 0, 0)}) {
            for (const Vec3& axis :
                 {Vec3(0, 0, 1), Vec3(0, 1, 0), Vec3(-1e-17, 0, 1), Vec3(1e-17, 1, 0), Vec3(0, -1e-17, 1)}) {
                if (at.y() == 3.0 && axis.y() > 0.5) {
                    continue; // it faces away from the room
                }
                const Vec3 p = turn * at, q = moved(lift, planar(p, turn * axis));
                EXPECT_GE(least_height(mesh, q), 0.499999 * least) << at.transpose() << ", " << axis.transpose();
                EXPECT_LE((q - p).norm(), 1.000001 * std::sqrt(3.0) * least);
            }
        }
        const Vec3 inside = turn * Vec3(1, 1, 1);
        EXPECT_EQ(moved(lift, planar(inside, Vec3::UnitZ())), inside);
    }
}

/// A narrow wedge: above both of its sides, off which it no longer lies.
TEST(SensorLift, InANarrowWedge) {
    const double angle = 0.3;
    const Mesh mesh =
        test::make_mesh({Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(1, 1, 0),
                         Vec3(std::cos(angle), 0, std::sin(angle)), Vec3(std::cos(angle), 1, std::sin(angle))},
                        {{0, 2, 1}, {2, 3, 1}, {0, 1, 4}, {4, 1, 5}});
    const double least = 2.0 * SensorLift::touching * mesh.diameter();
    EXPECT_GE(least_height(mesh, moved(SensorLift(mesh), planar(Vec3(0, 0.5, 0), Vec3(1, 0, 0)))), 0.499999 * least);
}

/// A sheet with two sides: the sensor measures on the side that it faces away from, and in front of a face that it
/// looks at unless it is in its plane.
TEST(SensorLift, OnSheets) {
    const Mesh one = test::grid(1, 1, 1.0, 1.0); // facing up
    Mesh both = one;
    for (const auto& [a, b, c] : one.triangles) {
        both.triangles.push_back({a, c, b});
    }
    both = test::make_mesh(both.points, {both.triangles.begin(), both.triangles.end()});
    const double least = 2.0 * SensorLift::touching * one.diameter();
    Mesh underside_first = both;
    std::rotate(underside_first.triangles.begin(), underside_first.triangles.begin() + 2,
                underside_first.triangles.end());
    underside_first.derive();
    for (const Mesh& mesh : {one, both, underside_first}) {
        const SensorLift lift(mesh);
        const Vec3 p(0.3, 0.2, 0.0);
        EXPECT_DOUBLE_EQ(moved(lift, planar(p, Vec3::UnitZ())).z(), least);
        EXPECT_DOUBLE_EQ(moved(lift, planar(p, -Vec3::UnitZ())).z(), -least);
        EXPECT_DOUBLE_EQ(moved(lift, {p, Vec3::UnitZ(), SensorKind::spherical}).z(), least);
    }
    const Vec3 just_above(0.3, 0.2, 1e-8);
    EXPECT_DOUBLE_EQ(moved(SensorLift(one), planar(just_above, -Vec3::UnitZ())).z(), least);
    EXPECT_DOUBLE_EQ(moved(SensorLift(both), planar(just_above, -Vec3::UnitZ())).z(),
                     -least); // its own is the lower side
}

/// A furnished furnace: every sensor reads E / (1 - rho) = 2 on walls, edges and corners, and a grid in the plane of a
/// desk does over all of the room.
TEST(SensorLift, AllSensorsInAFurnaceReadTheSame) {
    const Mesh desk = test::moved(test::box(Vec3(2, 1, 0.05), 1, false), 1.0, Vec3(1, 1, 0.7));
    const Mesh shelf =
        test::moved(test::box(Vec3(0.4, 1, 0.75), 1, false), 1.0, Vec3(0, 0.5, 0)); // flush with the wall
    for (const int furniture : {0, 1, 2}) { // none; behind the room in the list of faces; before it
        const bool furnished = furniture > 0;
        const Mesh room = test::box(Vec3(4, 3, 2.5), 1, true), pieces = test::together(desk, shelf);
        const Scene scene = test::uniform_scene(furniture == 0   ? room
                                                : furniture == 1 ? test::together(room, pieces)
                                                                 : test::together(pieces, room),
                                                0.5, 1.0);
        BakeOptions options;
        options.sites = 300;
        options.adaptive = false;
        options.error_points = 0;
        options.output_spacing = 10.0;
        for (const auto& [at, axis] : {std::pair(Vec3(0, 0, 1.2), Vec3(0, 0, 1)),
                                       {Vec3(0, 0, 1.2), Vec3(1, 1, 0)},
                                       {Vec3(4, 1.5, 0), Vec3(-1, 0, 1)},
                                       {Vec3(4, 3, 0), Vec3(-1, -1, 1)},
                                       {Vec3(4, 3, 0), Vec3(0, 0, 1)},
                                       {Vec3(0, 1, 1), Vec3(0, 1, 0)},
                                       {Vec3(0, 1, 1), Vec3(-1e-17, 1, 0)},
                                       {Vec3(0, 1, 1), Vec3(1e-17, 0, -1)},
                                       {Vec3(1, 1.5, 0.75), Vec3(-1, 0, 1)},
                                       {Vec3(1, 1.2, 0.72), Vec3(0, 0, 1)}}) {
            options.at.push_back({at, Vec3(axis.normalized())});
        }
        const Mesh& all = scene.mesh;
        for (Index t = 0; t < all.triangles.size(); ++t) {
            if (all.normals[t].z() > 0.5 && all.corner(t, 0).z() == 0.0) { // the floor
                for (const double height : {0.7, 0.75, 2.5}) { // of the desk's underside and top, and of the ceiling
                    options.grids.push_back({std::to_string(t), height, 0.25, 0.0});
                }
            }
        }
        for (const char* kind : {"planar", "spherical", "cylindrical", "horizontal"}) {
            options.sensor = kind;
            const BakeResult result = bake(test::registry(), scene, "furnace", options, Execution{2});
            ASSERT_GT(result.readings.H.rows(), 300) << kind; // of 3 times 12 by 16, some on diagonals
            for (Eigen::Index i = 0; i < result.readings.H.rows(); ++i) {
                const Vec3& p = result.sensors[static_cast<std::size_t>(i)].sensor.position;
                if (furnished && p.x() < 0.4 && p.y() > 0.5 && p.y() < 1.5 && p.z() < 0.75) {
                    continue; // in the shelf
                }
                EXPECT_NEAR(result.readings.H(i, 0), 2.0, 1e-9) << kind << " at " << p.transpose();
            }
        }
    }
}

} // namespace
} // namespace difusa::sensor_lift_test
