// Faces in one plane: which are set apart, in what order, and what stays where it is.
#include <difusa/bake.h>
#include <difusa/repair/coplanar_faces.h>

#include <support/lit_scenes.h>
#include <support/rooms.h>

#include <meshes.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace difusa::coplanar_faces_test {
namespace {

using test::box;
using test::grid;
using test::make_mesh;
using test::moved;
using test::together;
using test::transformed;

/// A square of this width around (x, y, z) that faces up, or down, cut along one diagonal or the other.
Mesh square(double width, const Vec3& middle, bool up = true, bool other_diagonal = false) {
    const double h = 0.5 * width;
    std::vector<Vec3> points{middle + Vec3(-h, -h, 0), middle + Vec3(h, -h, 0), middle + Vec3(h, h, 0),
                             middle + Vec3(-h, h, 0)};
    std::vector<std::array<Index, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
    if (other_diagonal) {
        triangles = {{0, 1, 3}, {1, 2, 3}};
    }
    return make_mesh(std::move(points), std::move(triangles), !up);
}

/// All corners of these triangles lie on z, to within a small part of the distance between layers.
void expect_height(const Mesh& mesh, Index first, Index last, double z, double layer) {
    for (Index t = first; t < last; ++t) {
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(mesh.corner(t, k).z(), z, 1e-3 * layer) << "triangle " << t;
        }
    }
}

void expect_untouched(Mesh mesh) {
    const Mesh before = mesh;
    EXPECT_TRUE(set_apart(mesh).moved.empty());
    EXPECT_EQ(mesh.points, before.points);
    EXPECT_EQ(mesh.triangles, before.triangles);
}

TEST(CoplanarFaces, LeavesSidesOfSheetsTogether) {
    expect_untouched(box(1.0, 3));
    expect_untouched(grid(5, 7));
    expect_untouched(together(square(1.0, Vec3::Zero()), square(1.0, Vec3::Zero(), false)));
    expect_untouched(together(square(1.0, Vec3::Zero()), square(1.0, Vec3::Zero(), false, true)));
    // Two rooms on both sides of a wall, one of them lower; two bodies on each other.
    const Mesh room = box(Vec3(4, 3, 2.5), 1, true), lower = moved(box(Vec3(2, 3, 2), 1, true), 1.0, Vec3(4, 0, 0));
    expect_untouched(together(room, lower));
    expect_untouched(together(box(2.0), moved(box(1.0), 1.0, Vec3(0.5, 0.5, 2.0))));
    // Tiles side by side, with corners on edges of others.
    expect_untouched(together(
        together(moved(grid(1, 1), 1.0, Vec3(-1, 0.5, 0)), moved(grid(1, 1), 1.0, Vec3(-1, -0.5, 0))), grid(1, 1)));
    // A sheet upside down on a body that goes on beyond it.
    expect_untouched(together(box(2.0), square(1.0, Vec3(1, 1, 2), false)));
}

/// In any position: a block on a floor is drawn off it, and nothing else changes.
TEST(CoplanarFaces, DrawsBodiesOffSheets) {
    const Mesh floor = moved(grid(2, 2), 4.0, Vec3(-1.5, -1.5, 0));
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(4e5, -5e6, 300)}) {
        const Mesh before = transformed(together(floor, box(1.0)), turn, 1.0, offset);
        Mesh mesh = before;
        const SetApart apart = set_apart(mesh);
        ASSERT_FALSE(apart.moved.empty());
        const Vec3 up = turn.col(2);
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            for (int k = 0; k < 3; ++k) {
                const Vec3 way = mesh.corner(t, k) - before.corner(t, k);
                const bool drawn = t >= floor.triangles.size() && std::abs(up.dot(before.corner(t, k) - offset)) < 0.5;
                const double rounding = 4.0 * before.magnitude() * 0x1p-52;
                EXPECT_NEAR(way.dot(up), drawn ? apart.gap : 0.0, 0.1 * apart.gap + rounding);
                EXPECT_NEAR((way - way.dot(up) * up).norm(), 0.0, 0.1 * apart.gap + rounding);
            }
        }
        Mesh again = mesh;
        EXPECT_TRUE(set_apart(again).moved.empty());
    }
}

/// A cabinet in the corner of a room, some of whose points are those of the room: off the floor and both walls.
TEST(CoplanarFaces, DrawsBodiesOutOfCorners) {
    Mesh room = box(Vec3(4, 3, 2.5), 1, true);
    Mesh cabinet = box(Vec3(1, 1, 2));
    const auto points = static_cast<Index>(room.points.size());
    Mesh mesh = together(room, cabinet);
    const auto corner = static_cast<Index>(
        std::find_if(mesh.points.begin(), mesh.points.end(), [](const Vec3& p) { return p.isZero(); }) -
        mesh.points.begin());
    ASSERT_LT(corner, points);
    for (Index t = static_cast<Index>(room.triangles.size()); t < mesh.triangles.size(); ++t) {
        for (Index& p : mesh.triangles[t]) {
            p = mesh.points[p].isZero() ? corner : p;
        }
    }
    mesh.derive();
    const SetApart apart = set_apart(mesh);
    EXPECT_EQ(apart.moved.size(), 6U) << "two triangles, each a face of its own, on three sides";
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const Vec3& p = mesh.corner(t, k);
            if (t < room.triangles.size()) {
                EXPECT_EQ(p, room.corner(t, k));
            } else {
                const Vec3 own = cabinet.corner(t - static_cast<Index>(room.triangles.size()), k);
                for (int axis = 0; axis < 3; ++axis) {
                    EXPECT_NEAR(p[axis] - own[axis], own[axis] == 0.0 ? apart.gap : 0.0, 1e-3 * apart.gap);
                }
            }
        }
    }
}

TEST(CoplanarFaces, PutsTheSmallerInFront) {
    for (const bool up : {true, false}) {
        const double side = up ? 1.0 : -1.0;
        const Mesh large = square(4.0, Vec3::Zero(), up), small = square(1.0, Vec3(0.3, 0, 0), up),
                   smallest = square(0.2, Vec3(0.7, 0, 0), up);
        Mesh mesh = together(together(smallest, large), small); // the smallest is on the edge of the small one
        const SetApart apart = set_apart(mesh);
        EXPECT_EQ(apart.moved.size(), 4U);
        expect_height(mesh, 2, 4, 0.0, apart.layer);
        expect_height(mesh, 4, 6, side * apart.layer, apart.layer);
        expect_height(mesh, 0, 2, side * 2.0 * apart.layer, apart.layer);
    }
    // Of equal ones, cut along different diagonals, the later; the corners are those of both.
    Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}});
    const SetApart apart = set_apart(mesh);
    EXPECT_EQ(apart.moved.size(), 2U);
    expect_height(mesh, 0, 2, 0.0, apart.layer);
    expect_height(mesh, 2, 4, apart.layer, apart.layer);
}

/// A block on a rug of two sides, on a floor: each on what is below it.
TEST(CoplanarFaces, StacksLayers) {
    Mesh rug = square(1.0, Vec3::Zero());
    for (const Index t : {Index{0}, Index{1}}) {
        auto back = rug.triangles[t];
        std::swap(back[1], back[2]);
        rug.triangles.push_back(back);
    }
    rug.original_face.resize(4, 1);
    rug.material.resize(4, 0);
    rug.derive();
    Mesh mesh = together(together(square(4.0, Vec3::Zero()), rug), moved(box(0.5), 1.0, Vec3(0.25, 0.25, 0)));
    const SetApart apart = set_apart(mesh);
    expect_height(mesh, 0, 2, 0.0, apart.layer);
    expect_height(mesh, 2, 6, apart.layer, apart.layer);
    double lowest = 1.0;
    for (Index t = 6; t < mesh.triangles.size(); ++t) {
        lowest = std::min(lowest, mesh.corner(t, 0).z());
    }
    EXPECT_NEAR(lowest, apart.layer + apart.gap, 1e-3 * apart.gap);
}

/// A lamp in the plane of the ceiling shines as one just below it: the errors of both bakes are independent.
TEST(CoplanarFaces, LampsInCeilingsShineAsIfBelowThem) {
    const auto room_with_lamp = [](double below) {
        Mesh mesh = lit::plain_box(Vec3::Zero(), Vec3(4, 3, 2.5), 1, Front::inside);
        mesh = together(mesh, square(1.0, Vec3(2, 1.5, 2.5 - below), false));
        mesh.material.assign(mesh.triangles.size(), 0);
        set_apart(mesh);
        Scene scene = lit::scene_of(mesh, 0.5);
        scene.materials.push_back(scene.materials[0]);
        scene.materials[1].emission = Rgb::Constant(20.0);
        scene.materials[1].reflectance = Rgb::Zero();
        for (std::size_t t = mesh.triangles.size() - 2; t < mesh.triangles.size(); ++t) {
            scene.mesh.material[t] = 1;
        }
        return scene;
    };
    BakeOptions options = lit::quick(0.25, 256);
    options.adaptive = false;
    const BakeResult flush = lit::baked(room_with_lamp(0.0), options),
                     below = lit::baked(room_with_lamp(1e-6), options);
    // All of the light arrives: what the discretisation creates or loses is the same, to the digits that a millionth of
    // the height makes.
    const EnergyBalance &a = flush.solution.energy, &b = below.solution.energy;
    EXPECT_NEAR(a.emitted[0], 20.0, 1e-9);
    EXPECT_NEAR(a.absorbed[0], b.absorbed[0], 1e-3 * b.absorbed[0]);
    EXPECT_NEAR(a.absorbed[0], a.emitted[0], 0.01 * a.emitted[0]);
}

/// What stands on a floor without thickness does not see the sky below it.
TEST(CoplanarFaces, BodiesOnFloorsDoNotSeeBelow) {
    Mesh mesh = together(moved(grid(1, 1), 10.0, Vec3(-4.5, -4.5, 0)), box(1.0));
    mesh.material.assign(mesh.triangles.size(), 0);
    set_apart(mesh);
    Scene scene = lit::scene_of(mesh, 0.5);
    scene.sky = Rgb::Ones();
    BakeOptions options = lit::quick(0.2, 64);
    options.adaptive = false;
    const BakeResult result = lit::baked(scene, options);
    std::size_t below = 0;
    for (std::size_t i = 0; i < result.sites->size(); ++i) {
        const SurfacePoint& site = result.sites->points[i];
        if (site.normal.z() < -0.5) {
            ++below;
            // The residual of the equation is below 1e-6 of the light, and is carried on by a factor of 2 at most.
            EXPECT_NEAR(result.solution.irradiance(static_cast<Eigen::Index>(i), 0), 0.0, 2e-6);
        }
    }
    EXPECT_GT(below, 5U);
}

} // namespace
} // namespace difusa::coplanar_faces_test
