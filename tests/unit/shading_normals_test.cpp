// Shading normals: those of the surface that a mesh stands for, also where it ends.
#include "meshes.h"

#include <difusa/core/random.h>
#include <difusa/mesh/shading_normals.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/mesh/unfolding.h>

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace difusa {

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double pi = std::numbers::pi;

/// `rows` rows of `around` rectangles, each cut in two; `place(s, t)` for s and t in [0,1], closed in s.
template <class Place> Mesh rolled(int around, int rows, const Place& place) {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i < around; ++i) {
            points.push_back(place(static_cast<double>(i) / around, static_cast<double>(j) / rows));
        }
    }
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < around; ++i) {
            const auto at = [&](int di, int dj) { return static_cast<Index>((j + dj) * around + (i + di) % around); };
            triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
            triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
        }
    }
    return test::make_mesh(points, triangles);
}

Mesh cylinder(int around, int rows) {
    return rolled(around, rows, [](double s, double t) { return Vec3(std::cos(2 * pi * s), std::sin(2 * pi * s), t); });
}

/// A zone of the unit sphere between two rims.
Mesh zone(int around, int rows) {
    return rolled(around, rows, [](double s, double t) {
        const double b = 0.4 + 1.3 * t;
        return Vec3(std::sin(b) * std::cos(2 * pi * s), -std::sin(b) * std::sin(2 * pi * s), std::cos(b));
    });
}

/// Largest distance between the shading normals at random points and the directions `right` of these.
template <class Right> double largest_error(const Mesh& mesh, const Right& right) {
    double largest = 0.0;
    for (const SurfacePoint& x : even_points(mesh, 4000, RandomStream(1, "points"))) {
        largest = std::max(largest, (x.normal - right(x.position).normalized()).norm());
    }
    return largest;
}

/// A floor to the left of x = 0 and what follows it to the right: strips along y that end at these points (x, z), each
/// of two triangles.
Mesh strips(const std::vector<Eigen::Vector2d>& profile) {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (const Eigen::Vector2d& p : profile) {
        const auto first = static_cast<Index>(points.size());
        points.emplace_back(p[0], 0.0, p[1]);
        points.emplace_back(p[0], 3.0, p[1]);
        if (first > 0) {
            triangles.push_back({first - 2, first, first + 1});
            triangles.push_back({first - 2, first + 1, first - 1});
        }
    }
    return test::make_mesh(points, triangles);
}

/// The part of a mesh in front of planes through the origin, which pass along its sides.
Mesh cut(const Mesh& mesh, const std::vector<Vec3>& normals) {
    std::vector<std::array<Index, 3>> kept;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3 middle = mesh.at(t, 1.0 / 3, 1.0 / 3).position;
        if (std::all_of(normals.begin(), normals.end(), [&](const Vec3& n) { return n.dot(middle) > 0.0; })) {
            kept.push_back(mesh.triangles[t]);
        }
    }
    std::vector<Index> number(mesh.points.size(), none);
    std::vector<Vec3> points;
    for (auto& triangle : kept) {
        for (Index& corner : triangle) {
            if (number[corner] == none) {
                number[corner] = static_cast<Index>(points.size());
                points.push_back(mesh.points[corner]);
            }
            corner = number[corner];
        }
    }
    return test::make_mesh(points, kept);
}

/// A mesh with all of its images, joined where their points are.
Mesh with_images(const Mesh& cell) {
    std::vector<Vec3> points = cell.points;
    std::vector<std::array<Index, 3>> triangles = cell.triangles;
    const std::vector<Repetition::Image> images = cell.repetition.images(1);
    for (std::size_t i = 1; i < images.size(); ++i) {
        std::vector<Index> number;
        for (const Vec3& p : cell.points) {
            const Vec3 place = images[i](p);
            const auto at =
                std::find_if(points.begin(), points.end(), [&](const Vec3& q) { return (q - place).norm() < 1e-9; });
            number.push_back(static_cast<Index>(at - points.begin()));
            if (at == points.end()) {
                points.push_back(place);
            }
        }
        for (const auto& [a, b, c] : cell.triangles) {
            triangles.push_back(images[i].reflects() ? std::array<Index, 3>{number[a], number[c], number[b]}
                                                     : std::array<Index, 3>{number[a], number[b], number[c]});
        }
    }
    return test::make_mesh(points, triangles);
}

void expect_normals_of_the_whole(const Mesh& cell) {
    const Mesh whole = with_images(cell);
    Mesh alone = cell;
    alone.repetition = {};
    alone.derive();
    double difference = 0.0, alone_difference = 0.0;
    for (const SurfacePoint& x : even_points(cell, 2000, RandomStream(1, "points"))) {
        const Vec3 right = whole.shaded(x).normal;
        difference = std::max(difference, (x.normal - right).norm());
        alone_difference = std::max(alone_difference, (alone.shaded(x).normal - right).norm());
    }
    EXPECT_LT(difference, 1e4 * eps); // fits of normals that differ by a tenth
    EXPECT_GT(alone_difference, 1e-3);
}

} // namespace

TEST(ShadingNormals, GoOnBeyondSymmetryPlanes) {
    const auto direction = [](double angle) { return Vec3(-std::sin(angle), std::cos(angle), 0.0); };
    // One plane; two at right angles; a wedge of 45°, whose images meet along the axis; and planes at both ends.
    for (const double angle : {pi, pi / 2, pi / 4}) {
        SCOPED_TRACE(angle);
        std::vector<Vec3> normals{direction(0.0)};
        if (angle < pi) {
            normals.push_back(-direction(angle));
        }
        for (const bool pole : {false, true}) {
            const Mesh whole =
                pole ? rolled(48, 9,
                              [](double s, double t) {
                                  const double b = 1e-3 + 1.2 * t, a = 2 * pi * s;
                                  return Vec3(std::sin(b) * std::cos(a), -std::sin(b) * std::sin(a), 0.6 * std::cos(b));
                              })
                     : zone(48, 9);
            Mesh cell = cut(whole, normals);
            for (const Vec3& normal : normals) {
                cell.repetition.planes.push_back({Vec3::Zero(), normal});
            }
            settle_repetition(cell);
            expect_normals_of_the_whole(cell);
        }
    }
}

TEST(ShadingNormals, GoOnBeyondPeriods) {
    // Waves of a roof of which one period of either is a cell, and parts of it.
    const auto roof = [](double x, double y) {
        return Vec3(x, y, 0.04 * std::sin(2 * pi * x) + 0.02 * std::cos(4 * pi * y + 1));
    };
    Mesh cell = test::grid(12, 16);
    for (Vec3& p : cell.points) {
        p = roof(p[0], p[1]);
    }
    cell.derive();
    cell.repetition.periods = {Vec3(1, 0, 0)};
    settle_repetition(cell);
    expect_normals_of_the_whole(cell);
    cell.repetition.periods.push_back(Vec3(0, 1, 0));
    settle_repetition(cell);
    expect_normals_of_the_whole(cell);
    cell.repetition = {};
    cell.repetition.planes = {{Vec3(0, 0, 0), Vec3(0, 1, 0)}, {Vec3(0, 1, 0), Vec3(0, -1, 0)}};
    settle_repetition(cell);
    expect_normals_of_the_whole(cell);
    EXPECT_EQ(unfolded(cell).triangles.size(), cell.triangles.size() + 2 * 4 * 2 * 12); // four rows at either end
}

TEST(ShadingNormals, OfFacetsOfManyStripsGoOnBeyondAPlane) {
    // Nine facets of a half cylinder in ten strips each; the plane x = 0 cuts the middle one, which turns at both ends,
    // five strips away.
    std::vector<Eigen::Vector2d> profile;
    for (int k = 0; k <= 45; ++k) {
        const auto corner = [](int facet) {
            return Eigen::Vector2d(-std::cos(pi / 9 * facet), -std::sin(pi / 9 * facet));
        };
        const double along = 0.1 * (k % 10);
        profile.emplace_back((1.0 - along) * corner(k / 10) +
                             (k % 10 > 0 ? along * corner(k / 10 + 1) : Eigen::Vector2d(0, 0)));
    }
    Mesh half = strips(profile);
    half.repetition.planes = {{Vec3::Zero(), Vec3(-1, 0, 0)}};
    settle_repetition(half);
    expect_normals_of_the_whole(half);
}

TEST(ShadingNormals, OfAFlatRoofBetweenPlanesAreItsOwn) {
    Mesh floor = test::grid(4, 4);
    floor.repetition.planes = {{Vec3(0, 0, 0), Vec3(0, 1, 0)}};
    settle_repetition(floor);
    EXPECT_TRUE(floor.shading.flat());
    // With a wall in the plane, whose image faces the other way.
    Mesh corner = test::box(Vec3(1, 1, 1), 2);
    corner.repetition.planes = {{Vec3(0, 0, 0), Vec3(0, 1, 0)}};
    settle_repetition(corner);
    EXPECT_TRUE(corner.shading.flat());
}

TEST(ShadingNormals, OfFlatWallsAreThoseOfTheirFaces) {
    const Mesh mesh = test::box(Vec3(1, 1.3, 2.1), 5);
    EXPECT_TRUE(mesh.shading.flat());
    const Mesh both = test::together(mesh, test::icosphere(2, 1.0)); // not flat, but the walls are
    EXPECT_FALSE(both.shading.flat());
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        EXPECT_EQ(both.shaded(both.at(t, 0.3, 0.2)).normal, both.normals[t]);
    }
}

TEST(ShadingNormals, OfASphereWithRimsConvergeWithTheSquareOfItsFacets) {
    const auto radial = [](const Vec3& p) { return p; };
    const double coarse = largest_error(zone(24, 6), radial), fine = largest_error(zone(96, 24), radial);
    EXPECT_GT(std::log(coarse / fine) / std::log(4.0), 1.8) << coarse << " " << fine;
    // One rim normal from one side alone is off by half a facet's turn.
    EXPECT_LT(fine, 0.1 * 0.5 * 1.3 / 24);
}

TEST(ShadingNormals, OfACylinderAreRadialToItsRims) {
    // By symmetry. With one row all points are on the rims, and with two those between are in one line: nothing can be
    // extrapolated. Sums of some tens of normals that nearly cancel across the axis.
    for (const int rows : {1, 2, 3, 8}) {
        const double error = largest_error(cylinder(36, rows), [](const Vec3& p) { return Vec3(p[0], p[1], 0.0); });
        EXPECT_LT(error, 1e3 * eps) << rows;
    }
}

TEST(ShadingNormals, OfWallsBesideAFilletAreTheirOwn) {
    // A floor of 2, a quarter of a circle of radius 0.3 in five facets, and a wall.
    std::vector<Eigen::Vector2d> profile{{-2.0, 0.0}};
    for (int k = 0; k <= 5; ++k) {
        const double angle = 0.1 * pi * k;
        profile.emplace_back(0.3 * std::sin(angle), 0.3 * (1.0 - std::cos(angle)));
    }
    profile.emplace_back(0.3, 2.0);
    const Mesh mesh = strips(profile);
    EXPECT_FALSE(mesh.shading.flat());
    double fillet = 0.0;
    for (const SurfacePoint& x : even_points(mesh, 4000, RandomStream(1, "points"))) {
        if (x.position[0] < 0.0 || x.position[2] > 0.3) {
            EXPECT_EQ(x.normal, mesh.normals[x.face]) << x.position.transpose();
        } else {
            const Vec3 right(-x.position[0], 0.0, 0.3 - x.position[2]);
            fillet = std::max(fillet, (x.normal - right.normalized()).norm());
        }
    }
    // Its corners have exact normals, by symmetry and those of the walls, and what is interpolated on a chord is
    // radial.
    EXPECT_LT(fillet, 1e3 * eps);
}

TEST(ShadingNormals, OfASingleBendAreThoseOfItsFaces) {
    const double c = std::cos(0.35), s = std::sin(0.35);
    for (const std::vector<Eigen::Vector2d>& floor :
         {std::vector<Eigen::Vector2d>{{-4.0, 0.0}}, {{-4.0, 0.0}, {-2.0, 0.0}}, {{-4.0, 0.0}, {-0.5, 0.0}}}) {
        std::vector<Eigen::Vector2d> profile = floor;
        profile.insert(profile.end(), {{0.0, 0.0}, {c, s}, {2.0 * c, 2.0 * s}});
        EXPECT_TRUE(strips(profile).shading.flat());
    }
}

TEST(ShadingNormals, OfAFloorWithASliverAreItsOwn) {
    // One corner of the sliver is beside the diagonal, and a little above the floor.
    const Vec3 tip(1e-5, 0.0, 6e-6);
    const Mesh mesh = test::make_mesh({{-2, -4, 0}, {2, -4, 0}, {2, 4, 0}, {-2, 4, 0}, tip},
                                      {{0, 1, 4}, {1, 2, 4}, {0, 4, 2}, {0, 2, 3}});
    for (const SurfacePoint& x : even_points(mesh, 500, RandomStream(1, "points"))) {
        if (mesh.areas[x.face] > 1.0) {
            EXPECT_EQ(x.normal, mesh.normals[x.face]);
            EXPECT_GT(x.normal[2], 1.0 - 1e-9);
        }
    }
}

TEST(ShadingNormals, OfATurnedWallOfManyTrianglesAreThoseOfItsFaces) {
    Mesh mesh = test::grid(40, 40);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vec3& p : mesh.points) {
        p = turn * p + Vec3(10, 20, 30);
    }
    mesh.derive();
    EXPECT_TRUE(mesh.shading.flat());
}

TEST(ShadingNormals, StopAtCreases) {
    Mesh mesh = cylinder(12, 3); // turns by 30° from facet to facet
    mesh.crease_angle = 29.0 * pi / 180.0;
    mesh.derive();
    EXPECT_TRUE(mesh.shading.flat());
    mesh.crease_angle = 31.0 * pi / 180.0;
    mesh.derive();
    EXPECT_FALSE(mesh.shading.flat());
}

} // namespace difusa
