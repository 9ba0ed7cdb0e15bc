// What is left of faces that others cover, and of bodies that touch: areas, closure, and what stays as it is.
#include <difusa/core/random.h>
#include <difusa/form_factors/form_factors.h>
#include <difusa/repair/covered_parts.h>

#include <meshes.h>
#include <support/rooms.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace difusa::covered_parts_test {
namespace {

using test::box;
using test::flat_rectangle;
using test::grid;
using test::moved;
using test::together;
using test::transformed;

/// With the same number for all triangles of each mesh that this one was put together from.
std::vector<double> area_by_mesh(const Mesh& mesh, const std::vector<Index>& sizes) {
    std::vector<double> area(sizes.size(), 0.0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        Index first = 0;
        for (std::size_t m = 0; m < sizes.size(); ++m) {
            if (mesh.original_face[t] >= first && mesh.original_face[t] < first + sizes[m]) {
                area[m] += mesh.areas[t];
            }
            first += sizes[m];
        }
    }
    return area;
}

Index count_of(const Mesh& mesh) {
    return static_cast<Index>(mesh.triangles.size());
}

/// The mesh has faces numbered like its triangles.
void expect_untouched(Mesh mesh) {
    const Mesh before = mesh;
    EXPECT_TRUE(leave_out_covered(mesh).cut.empty());
    EXPECT_EQ(mesh.points, before.points);
    EXPECT_EQ(mesh.triangles, before.triangles);
}

/// Every row sum of the form factors between faces is 1: nothing is open, and no back is seen.
void expect_closed(const Mesh& mesh) {
    const Surfaces surfaces = surfaces_by_face(mesh);
    const double tolerance = 1e-5;
    const FormFactors F = form_factors(mesh, surfaces, {tolerance}, Execution{});
    for (std::size_t i = 0; i < F.size(); ++i) {
        EXPECT_NEAR(F.row_sum(i), 1.0, static_cast<double>(F.size()) * tolerance) << surfaces.name[i];
    }
}

TEST(CoveredParts, LeavesOutWhatLiesUnderAPatch) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    const Mesh room = box(1.0, 1, true);
    for (const bool diagonal : {false, true}) {
        const Mesh patch = flat_rectangle(0.3, 0.3, 0.7, 0.7, true, diagonal);
        for (const auto& [scale, offset] : {std::pair(1.0, Vec3(0, 0, 0)), std::pair(7e-4, Vec3(0.3, -2, 5))}) {
            Mesh mesh = transformed(together(room, patch), turn, scale, offset);
            const CoveredParts covered = leave_out_covered(mesh);
            EXPECT_FALSE(covered.given_up);
            EXPECT_EQ(covered.cut.size(), 2U) << "the triangles of the floor";
            const double rounding = 1e-6 * scale * scale;
            EXPECT_NEAR(covered.area, 0.16 * scale * scale, rounding);
            const std::vector<double> area = area_by_mesh(mesh, {count_of(room), count_of(patch)});
            EXPECT_NEAR(area[0], (6.0 - 0.16) * scale * scale, rounding);
            EXPECT_NEAR(area[1], 0.16 * scale * scale, rounding);
            expect_closed(mesh);
        }
    }
}

TEST(CoveredParts, LeavesOutWhatIsUnderTheSmallestOfThree) {
    const Mesh large = flat_rectangle(0, 0, 4, 4), middle = flat_rectangle(1, 1, 5, 3),
               small = flat_rectangle(1.5, 1.5, 2.5, 2.5);
    for (const auto& meshes : {std::array{large, middle, small}, std::array{small, large, middle}}) {
        std::vector<Index> sizes;
        for (const Mesh& each : meshes) {
            sizes.push_back(count_of(each));
        }
        Mesh mesh = together(together(meshes[0], meshes[1]), meshes[2]);
        leave_out_covered(mesh);
        std::vector<double> area = area_by_mesh(mesh, sizes);
        std::sort(area.begin(), area.end());
        EXPECT_NEAR(area[0], 1.0, 1e-12);       // the small one
        EXPECT_NEAR(area[1], 8.0 - 1.0, 1e-12); // the one in the middle
        EXPECT_NEAR(area[2], 16.0 - 6.0, 1e-12);
    }
}

/// A box on the floor of a room has no bottom, and the floor a hole that its walls rise from: the surface is closed.
TEST(CoveredParts, LeavesOutWhereABodyStands) {
    const Mesh room = box(Vec3(1, 1, 1), 2, true), body = moved(box(0.4), 1.0, Vec3(0.3, 0.3, 0));
    Mesh mesh = together(room, body);
    leave_out_covered(mesh);
    const std::vector<double> area = area_by_mesh(mesh, {count_of(room), count_of(body)});
    EXPECT_NEAR(area[0], 6.0 - 0.16, 1e-12);
    EXPECT_NEAR(area[1], 5.0 * 0.16, 1e-12);
    expect_closed(mesh);
    // Another body on it, askew, and one in the corner.
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
    const Mesh askew = transformed(box(0.2), turn, 1.0, Vec3(0.45, 0.35, 0.4)), corner = box(0.25);
    mesh = together(together(together(room, body), askew), corner);
    leave_out_covered(mesh);
    const std::vector<double> areas =
        area_by_mesh(mesh, {count_of(room), count_of(body), count_of(askew), count_of(corner)});
    EXPECT_NEAR(areas[0], 6.0 - 0.16 - 3.0 * 0.0625, 1e-12);
    EXPECT_NEAR(areas[1], 5.0 * 0.16 - 0.04, 1e-12);
    EXPECT_NEAR(areas[2], 5.0 * 0.04, 1e-12);
    EXPECT_NEAR(areas[3], 3.0 * 0.0625, 1e-12);
    expect_closed(mesh);
}

TEST(CoveredParts, LeavesOutWhereBodiesTouch) {
    for (const double shift : {0.0, 0.5}) { // as large as each other, and partly
        Mesh mesh = together(box(1.0), moved(box(1.0), 1.0, Vec3(shift, 0, 1)));
        leave_out_covered(mesh);
        EXPECT_NEAR(mesh.area, 12.0 - 2.0 * (1.0 - shift), 1e-12);
    }
}

TEST(CoveredParts, LeavesSheetsAndNeighboursAlone) {
    expect_untouched(box(1.0, 3));
    expect_untouched(together(flat_rectangle(0, 0, 1, 1), flat_rectangle(0, 0, 1, 1, false)));
    expect_untouched(together(flat_rectangle(0, 0, 1, 1), flat_rectangle(0, 0, 1, 1, false, true)));
    expect_untouched(together(flat_rectangle(0, 0, 1, 1), flat_rectangle(1, 0.5, 2, 1.5)));
    // Two rooms on both sides of a wall.
    expect_untouched(together(box(Vec3(4, 3, 2.5), 1, true), moved(box(Vec3(2, 3, 2), 1, true), 1.0, Vec3(4, 0, 0))));
}

/// A body on one side of a sheet that is lit from both: only that side loses what it covers.
TEST(CoveredParts, LeavesTheOtherSideOfASheet) {
    const Mesh up = flat_rectangle(-1, -1, 2, 2), down = flat_rectangle(-1, -1, 2, 2, false), body = box(1.0);
    Mesh mesh = together(together(up, down), body);
    leave_out_covered(mesh);
    const std::vector<double> area = area_by_mesh(mesh, {2, 2, count_of(body)});
    EXPECT_NEAR(area[0], 8.0, 1e-12);
    EXPECT_NEAR(area[1], 9.0, 1e-12);
    EXPECT_NEAR(area[2], 5.0, 1e-12);
}

/// A decal on a floor that is curved by little, or rough by the rounding of single precision: triangles in one chain of
/// neighbours, but not in one plane. Nothing goes but what the decal covers; of the rough floor, whose small triangles
/// point in slightly different directions, not all of that is found.
TEST(CoveredParts, LeavesCurvedAndRoughSurfacesWhole) {
    RandomStream random(7, "roughness");
    for (const bool rough : {false, true}) {
        Mesh floor = grid(100, 100);
        for (Vec3& p : floor.points) {
            p.z() = rough ? 6e-8 * (random.uniform() - 0.5) : -0.25e-3 * p.squaredNorm();
        }
        const Index first = count_of(floor);
        Mesh mesh =
            together(floor, rough ? flat_rectangle(0.2, 0.3, 0.5, 0.6) : flat_rectangle(0.001, 0.001, 0.003, 0.003));
        mesh.derive();
        const double decal = mesh.areas[first] + mesh.areas[first + 1], area = mesh.area - decal;
        const CoveredParts covered = leave_out_covered(mesh);
        EXPECT_FALSE(covered.given_up);
        EXPECT_GT(covered.area, 0.0) << rough;
        EXPECT_LE(covered.area, (1.0 + 1e-3) * decal) << rough;
        EXPECT_NEAR(mesh.area + covered.area, area + decal, 1e-12) << rough;
        if (!rough) {
            EXPECT_NEAR(covered.area, decal, 1e-3 * decal);
        }
    }
}

/// What was linear over a triangle still is; faces and materials stay with their places.
TEST(CoveredParts, KeepsColoursAndTextureCoordinates) {
    Mesh mesh = together(grid(2, 2, 4.0, 4.0), flat_rectangle(0.3, 0.7, 3.1, 2.9));
    const auto coordinates = [](const Vec3& p) { return TextureCoordinates(0.5 * p.x() - p.y(), 2.0 + p.y()); };
    const auto colour = [](const Vec3& p) { return Rgb(0.1 + 0.2 * p.x(), 0.2 * p.y(), 0.5); };
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        mesh.material[t] = t % 3;
        mesh.corner_texture.emplace_back();
        mesh.corner_reflectance.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            mesh.corner_texture.back()[k] = coordinates(mesh.corner(t, static_cast<int>(k)));
            mesh.corner_reflectance.back()[k] = colour(mesh.corner(t, static_cast<int>(k)));
        }
    }
    const Mesh before = mesh;
    leave_out_covered(mesh);
    ASSERT_GT(mesh.triangles.size(), before.triangles.size());
    ASSERT_EQ(mesh.corner_texture.size(), mesh.triangles.size());
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Index parent = mesh.original_face[t];
        EXPECT_EQ(mesh.material[t], before.material[parent]);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& p = mesh.corner(t, static_cast<int>(k));
            EXPECT_LE((mesh.corner_texture[t][k] - coordinates(p)).norm(), 1e-12);
            EXPECT_LE((mesh.corner_reflectance[t][k] - colour(p)).abs().maxCoeff(), 1e-12);
        }
    }
}

/// Rectangles with random corners, of a coarse lattice so that many sides coincide, on a floor: the last of the
/// smallest is seen at each place, as a count over the cells of the lattice says.
TEST(CoveredParts, AgreesWithCounting) {
    RandomStream random(3, "rectangles");
    constexpr int cells = 12;
    const auto whole = [&](int from, int to) { return from + static_cast<int>(random.uniform() * (to - from)); };
    for (int trial = 0; trial < 400; ++trial) {
        Mesh mesh = flat_rectangle(0, 0, cells, cells);
        std::vector<std::array<int, 4>> all{{0, 0, cells, cells}};
        std::set<int> areas{cells * cells};
        while (all.size() < 6) {
            const int x0 = whole(0, cells), y0 = whole(0, cells), x1 = whole(x0 + 1, cells + 1),
                      y1 = whole(y0 + 1, cells + 1);
            if (areas.insert((x1 - x0) * (y1 - y0)).second) { // which of two as large is seen, is tested elsewhere
                all.push_back({x0, y0, x1, y1});
                mesh = together(mesh, flat_rectangle(x0, y0, x1, y1, true, trial % 2 == 0));
            }
        }
        const auto area_of = [&](std::size_t m) { return (all[m][2] - all[m][0]) * (all[m][3] - all[m][1]); };
        std::vector<double> seen(all.size(), 0.0);
        for (int x = 0; x < cells; ++x) {
            for (int y = 0; y < cells; ++y) {
                std::size_t front = 0;
                for (std::size_t m = 1; m < all.size(); ++m) {
                    const auto& [x0, y0, x1, y1] = all[m];
                    front = x0 <= x && x < x1 && y0 <= y && y < y1 && area_of(m) < area_of(front) ? m : front;
                }
                seen[front] += 1.0;
            }
        }
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.1 * trial, Vec3(1, 2, -1).normalized()).toRotationMatrix();
        mesh = transformed(mesh, turn, 1.0, Vec3(3, 4, 5));
        leave_out_covered(mesh);
        const std::vector<double> area = area_by_mesh(mesh, std::vector<Index>(all.size(), 2));
        for (std::size_t m = 0; m < all.size(); ++m) {
            EXPECT_NEAR(area[m], seen[m], 1e-4) << "trial " << trial << ", rectangle " << m; // slivers of 1e-7 by 12
        }
    }
}

} // namespace
} // namespace difusa::covered_parts_test
