// Faces in one plane: which are set apart, in what order, and what stays where it is.
#include <difusa/bake.h>
#include <difusa/mesh/repetition.h>
#include <difusa/rays/lambert.h>
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
    return moved(test::flat_rectangle(-h, -h, h, h, up, other_diagonal), 1.0, middle);
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

/// A ceiling of loose tiles, with gaps between them, is behind a lamp that is larger than a tile.
TEST(CoplanarFaces, TilesAreOneFloor) {
    Mesh mesh = square(1.6, Vec3(2, 2, 0));
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            mesh = together(mesh, square(0.99, Vec3(0.5 + i, 0.5 + j, 0)));
        }
    }
    std::fill(mesh.material.begin(), mesh.material.begin() + 2, 1);
    const SetApart apart = set_apart(mesh);
    EXPECT_EQ(apart.moved.size(), 2U);
    expect_height(mesh, 0, 2, apart.layer, apart.layer);
    expect_height(mesh, 2, static_cast<Index>(mesh.triangles.size()), 0.0, apart.layer);
}

/// Squares of one size, each of which overlaps the next, take two layers.
TEST(CoplanarFaces, LayersDoNotAddUp) {
    Mesh mesh = square(1.0, Vec3::Zero());
    for (int i = 1; i < 50; ++i) {
        mesh = together(mesh, square(1.0, Vec3(0.6 * i, 0, 0)));
    }
    const SetApart apart = set_apart(mesh);
    EXPECT_EQ(apart.moved.size(), 50U);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        expect_height(mesh, t, t + 1, t / 2 % 2 * apart.layer, apart.layer);
    }
}

/// A floor that is cut along the outline of the block on it, with the same points, and one cut along a side of it.
TEST(CoplanarFaces, DrawsBodiesOffFloorsThatShareTheirPoints) {
    const Mesh block = box(1.0);
    const auto bottom = [&](double x, double y) {
        const auto& points = block.points;
        return static_cast<Index>(std::find(points.begin(), points.end(), Vec3(x, y, 0)) - points.begin());
    };
    const Index a = bottom(0, 0), b = bottom(1, 0), c = bottom(1, 1), d = bottom(0, 1), n = 8; // of its eight points
    const std::vector<std::array<Index, 3>> around{{n, n + 1, b},     {n, b, a},     {n + 1, n + 2, c}, {n + 1, c, b},
                                                   {n + 2, n + 3, d}, {n + 2, d, c}, {n + 3, n, a},     {n + 3, a, d}};
    std::vector<std::array<Index, 3>> cut = around, whole{{n, n + 1, b}, {n, b, a}, {n, a, n + 3}, {n + 3, a, b}};
    cut.push_back({a, b, c});
    cut.push_back({a, c, d});
    whole.push_back({n + 3, b, n + 2});
    whole.push_back({n + 2, b, n + 1});
    for (const auto& floor : {cut, whole}) {
        std::vector<Vec3> points = block.points;
        ASSERT_EQ(points.size(), 8U);
        points.insert(points.end(), {Vec3(-2, -2, 0), Vec3(3, -2, 0), Vec3(3, 3, 0), Vec3(-2, 3, 0)});
        std::vector<std::array<Index, 3>> triangles = block.triangles;
        triangles.insert(triangles.end(), floor.begin(), floor.end());
        Mesh mesh = make_mesh(points, triangles);
        const SetApart apart = set_apart(mesh);
        EXPECT_EQ(apart.moved.size(), 2U);
        const auto of_block = static_cast<Index>(block.triangles.size());
        expect_height(mesh, of_block, static_cast<Index>(mesh.triangles.size()), 0.0, apart.gap);
        for (Index t = 0; t < of_block; ++t) {
            for (int k = 0; k < 3; ++k) {
                const double z = block.corner(t, k).z();
                EXPECT_NEAR(mesh.corner(t, k).z(), z == 0.0 ? apart.gap : z, 1e-3 * apart.gap);
            }
        }
    }
}

/// One layer is within what a surface may reach beyond a symmetry plane; two are not, and then all stays as it is.
TEST(CoplanarFaces, GivesUpAtSymmetryPlanes) {
    static_assert(0x1p-20 < Repetition::tolerance && 2.0 * 0x1p-20 > Repetition::tolerance);
    for (const int layers : {1, 2}) {
        Mesh mesh = together(square(1.0, Vec3(0, 0, 1)), square(1.0, Vec3::Zero(), false));
        for (int k = 1; k <= layers; ++k) {
            mesh = together(mesh, square(1.0 - 0.2 * k, Vec3::Zero(), false));
        }
        mesh.repetition.planes = {{Vec3::Zero(), Vec3::UnitZ()}};
        settle_repetition(mesh);
        const std::vector<Vec3> before = mesh.points;
        const SetApart apart = set_apart(mesh);
        EXPECT_EQ(apart.given_up, layers == 2);
        EXPECT_EQ(apart.moved.empty(), layers == 2);
        EXPECT_EQ(mesh.points == before, layers == 2);
        EXPECT_EQ(mesh.repetition.walls.size(), 1U);
    }
}

/// A lamp in the plane of the ceiling of a black room: the irradiance of the floor is that of the whole lamp, which is
/// lower by a layer, 2e-6 of the height of the room: to twice that.
TEST(CoplanarFaces, LampsInCeilingsShine) {
    Mesh mesh = together(box(Vec3(4, 3, 2.5), 1, true), square(1.0, Vec3(2, 1.5, 2.5), false));
    const SetApart apart = set_apart(mesh);
    ASSERT_EQ(apart.moved.size(), 2U);
    Scene scene = lit::scene_of(mesh, 0.0);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].emission = Rgb::Constant(20.0);
    std::fill(scene.mesh.material.end() - 2, scene.mesh.material.end(), 1);
    BakeOptions options = lit::quick(0.4, 16);
    options.adaptive = false;
    const BakeResult result = lit::baked(scene, options);
    const Vec3 lamp[] = {Vec3(1.5, 1, 2.5), Vec3(1.5, 2, 2.5), Vec3(2.5, 2, 2.5), Vec3(2.5, 1, 2.5)};
    std::size_t count = 0;
    for (std::size_t i = 0; i < result.sites->size(); ++i) {
        const SurfacePoint& site = result.sites->points[i];
        if (site.normal.z() > 0.5) {
            ++count;
            const double exact = 20.0 * lambert_form_factor(site.position, site.normal, lamp);
            EXPECT_NEAR(result.solution.irradiance(static_cast<Eigen::Index>(i), 0), exact,
                        2.0 * apart.layer / 2.5 * exact);
        }
    }
    EXPECT_GT(count, 20U);
}

/// What stands on a floor without thickness does not see the sky below it.
TEST(CoplanarFaces, BodiesOnFloorsDoNotSeeBelow) {
    Mesh mesh = together(moved(grid(1, 1), 10.0, Vec3(-4.5, -4.5, 0)), box(1.0));
    mesh.material.assign(mesh.triangles.size(), 0);
    const SetApart apart = set_apart(mesh);
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
            // The residual, in the sum of squares over all points, is below 1e-6 of the light, which is at most 1, and
            // bounces double it at most. Through the gap the floor beyond the edge is seen under an angle of gap over
            // distance, squared.
            const Vec3& x = site.position;
            const double edge = std::min({x.x(), 1.0 - x.x(), x.y(), 1.0 - x.y()});
            EXPECT_NEAR(result.solution.irradiance(static_cast<Eigen::Index>(i), 0), 0.0,
                        2e-6 * std::sqrt(static_cast<double>(result.sites->size())) + std::pow(apart.gap / edge, 2));
        }
    }
    EXPECT_GT(below, 5U);
}

} // namespace
} // namespace difusa::coplanar_faces_test
