#include <difusa/core/error.h>
#include <difusa/discretisation/surfels.h>
#include <difusa/mesh/surface_sampling.h>

#include <support/rooms.h>

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace difusa::surfels_test {
namespace {

struct Named {
    std::string name;
    Mesh mesh;
};

/// A wall x = 1 of two triangles, of both sides or one, from `from` to `to` in height, on or through a floor of 2 n²
/// triangles, [0, 2]².
Mesh floor_with_wall(int n, double from, double to) {
    const Mesh wall =
        test::make_mesh({{1, 0.3, from}, {1, 1.7, from}, {1, 1.7, to}, {1, 0.3, to}}, {{0, 1, 2}, {0, 2, 3}});
    return test::together(test::grid(n, n, 2.0, 2.0), wall);
}

std::vector<Named> meshes() {
    return {{"square", test::grid(1, 1)},
            {"obtuse triangle", test::make_mesh({{0, 0, 0}, {3, 0, 0}, {-2, 0.4, 1}}, {{0, 1, 2}})},
            {"acute triangle", test::make_mesh({{0, 0, 0}, {3, 0, 0}, {1.4, 2.4, 1}}, {{0, 1, 2}})},
            {"needles", test::needles(60)},
            {"sliver", test::make_mesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1e-9, 0}}, {{0, 1, 2}})},
            {"room", test::box(Vec3(1.0, 1.3, 0.7), 1, true)},
            {"fine room", test::box(Vec3(1.0, 1.3, 0.7), 12, true)},
            {"room with block", test::room_with_block()},
            {"L-shaped room", test::l_room()},
            {"sphere", test::icosphere(3)},
            {"rough sphere", test::icosphere(1)},
            {"book", test::book(3)},
            {"strip with one side", test::mobius(60)},
            {"large among small", test::huge_among_tiny(16, 0.5)},
            {"thin wall", test::thin_wall(1e-9)},
            {"shelf", test::shelf_over_table(1e-7)},
            {"wall on a floor", floor_with_wall(1, 0.0, 1.0)},
            {"wall through a floor", floor_with_wall(1, -0.5, 1.0)},
            {"wall on a fine floor", floor_with_wall(30, 0.0, 1.0)}};
}

constexpr double edges[] = {0.0937, 0.3141, 10.0};

/// How far (u, v) is outside of the polygon, in barycentric coordinates.
double outside_by(const ConvexPolygon& polygon, double u, double v) {
    const Eigen::Vector2d x(u, v);
    double most = 0.0;
    for (std::size_t k = 0; k < polygon.count; ++k) {
        const Eigen::Vector2d p = polygon.corner[k], side = polygon.corner[(k + 1) % polygon.count] - p;
        if (const double length = side.norm(); length > 1e-9) {
            most = std::max(most, -(side.x() * (x - p).y() - side.y() * (x - p).x()) / length);
        }
    }
    return most;
}

/// To the corners and sides of a piece.
double distance(const Mesh& mesh, const Surfels::Piece& piece, const Vec3& x) {
    double least = std::numeric_limits<double>::infinity();
    const auto corner = [&](std::size_t k) {
        const Eigen::Vector2d& uv = piece.outline.corner[k % piece.outline.count];
        return mesh.at(piece.triangle, uv.x(), uv.y()).position;
    };
    for (std::size_t k = 0; k < piece.outline.count; ++k) {
        const Vec3 p = corner(k), side = corner(k + 1) - p;
        const double length = side.squaredNorm();
        const double along = length > 0.0 ? std::clamp(side.dot(x - p) / length, 0.0, 1.0) : 0.0;
        least = std::min(least, (p + along * side - x).norm());
    }
    return least;
}

/// Corners, middles of sides and random points of all triangles.
std::vector<SurfacePoint> points_of(const Mesh& mesh) {
    std::vector<SurfacePoint> points = even_points(mesh, 300, RandomStream(1, "points"));
    const std::size_t stride = 1 + mesh.triangles.size() / 200;
    for (Index t = 0; t < mesh.triangles.size(); t += static_cast<Index>(stride)) {
        for (const auto& [u, v] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {0.5, 0.5}, {0.3, 0.3}}) {
            points.push_back(mesh.at(t, u, v));
        }
    }
    return points;
}

TEST(Surfels, DivideTheWholeSurface) {
    for (const Named& test : meshes()) {
        for (const double edge : edges) {
            SCOPED_TRACE(test.name + ", edge " + std::to_string(edge));
            const Surfels surfels(test.mesh, edge, Execution{});
            std::vector<Surfels::Piece> pieces;
            double sum = 0.0;
            for (Index s = 0; s < surfels.size(); ++s) {
                surfels.pieces(s, pieces);
                ASSERT_FALSE(pieces.empty());
                double area = 0.0;
                for (const Surfels::Piece& piece : pieces) {
                    area += piece.area;
                    // 2 A (u, v) coordinates: an outline has its share of the triangle.
                    EXPECT_NEAR(piece.area, 2.0 * test.mesh.areas[piece.triangle] * piece.outline.area(),
                                1e-15 * test.mesh.areas[piece.triangle]);
                }
                EXPECT_NEAR(surfels.area(s), area, 1e-12 * area);
                sum += surfels.area(s);
            }
            EXPECT_NEAR(sum, test.mesh.area, 1e-12 * test.mesh.area);
        }
    }
}

TEST(Surfels, APointLiesInAPieceOfItsSurfel) {
    for (const Named& test : meshes()) {
        for (const double edge : edges) {
            SCOPED_TRACE(test.name + ", edge " + std::to_string(edge));
            const Surfels surfels(test.mesh, edge, Execution{});
            std::vector<Surfels::Piece> pieces;
            for (const SurfacePoint& x : points_of(test.mesh)) {
                const Index s = surfels.at(x.face, x.u, x.v);
                ASSERT_LT(s, surfels.size());
                surfels.pieces(s, pieces);
                double nearest = 1.0;
                for (const Surfels::Piece& piece : pieces) {
                    EXPECT_EQ(test.mesh.region[piece.triangle], test.mesh.region[x.face]);
                    if (piece.triangle == x.face) {
                        nearest = std::min(nearest, outside_by(piece.outline, x.u, x.v));
                    }
                }
                if (nearest <= 1e-9) {
                    continue;
                }
                // Only on the very plane of a wall may a corner or side be told to another part of the same cell.
                EXPECT_TRUE(x.u == 0.0 || x.v == 0.0 || x.u + x.v == 1.0) << x.position.transpose();
                double apart = std::numeric_limits<double>::infinity();
                for (const Surfels::Piece& piece : pieces) {
                    apart = std::min(apart, distance(test.mesh, piece, x.position));
                }
                EXPECT_LE(apart, (std::sqrt(3.0) + 4.0 / 3.0) * edge) << x.position.transpose();
            }
        }
    }
}

/// And the other way round: points drawn on a surfel belong to it.
TEST(Surfels, PointsOnASurfelBelongToIt) {
    for (const Named& test : meshes()) {
        for (const double edge : edges) {
            SCOPED_TRACE(test.name + ", edge " + std::to_string(edge));
            const Surfels surfels(test.mesh, edge, Execution{});
            RandomStream random(2, "points");
            std::vector<Surfels::Piece> pieces;
            std::size_t others = 0, all = 0;
            for (Index s = 0; s < surfels.size(); ++s) {
                if (surfels.area(s) < 1e-6 * std::min(edge * edge, test.mesh.area)) {
                    continue; // specks, all of which are border
                }
                const SurfacePoint centre = surfels.centre(s, pieces);
                EXPECT_EQ(surfels.at(centre.face, centre.u, centre.v), s);
                for (int k = 0; k < 4; ++k, ++all) {
                    const double u = random.uniform(), v = random.uniform();
                    const SurfacePoint x = surfels.point_on(pieces, u, v);
                    others += surfels.at(x.face, x.u, x.v) != s ? 1 : 0;
                }
            }
            EXPECT_EQ(others, 0U) << "of " << all;
        }
    }
}

/// Of a grid: the diagonal of a square. Of a cluster: centroids of triangles with sides of up to `edge` in a cube of
/// that side, whose corners are at most 2/3 of a median, which is at most `edge`, away from there.
TEST(Surfels, AreNotLargerThanTold) {
    for (const Named& test : meshes()) {
        for (const double edge : edges) {
            SCOPED_TRACE(test.name + ", edge " + std::to_string(edge));
            const Surfels surfels(test.mesh, edge, Execution{});
            std::vector<Surfels::Piece> pieces;
            for (Index s = 0; s < surfels.size(); ++s) {
                surfels.pieces(s, pieces);
                double diameter = 0.0, longest = 0.0;
                std::vector<Vec3> corners;
                for (const Surfels::Piece& piece : pieces) {
                    const Mesh& mesh = test.mesh;
                    for (std::size_t k = 0; k < piece.outline.count; ++k) {
                        corners.push_back(
                            mesh.at(piece.triangle, piece.outline.corner[k].x(), piece.outline.corner[k].y()).position);
                    }
                    for (int k = 0; k < 3; ++k) {
                        longest = std::max(
                            longest,
                            (mesh.corner(piece.triangle, k) - mesh.corner(piece.triangle, (k + 1) % 3)).norm());
                    }
                }
                const std::size_t stride = 1 + corners.size() / 60; // pairs
                for (std::size_t a = 0; a < corners.size(); a += stride) {
                    for (const Vec3& b : corners) {
                        diameter = std::max(diameter, (corners[a] - b).norm());
                    }
                }
                const double most = longest > edge ? std::sqrt(2.0) : std::sqrt(3.0) + 4.0 / 3.0;
                EXPECT_LE(diameter, most * edge * (1.0 + 1e-9));
                EXPECT_TRUE(longest <= edge || pieces.size() == 1);
            }
        }
    }
}

/// A straight line through a surfel leaves as much of the points on one side as of its area. 4.5 standard deviations of
/// a share: one of the 600 comparisons goes beyond with a probability of 0.4 %, and the numbers are always the same.
TEST(Surfels, PointsOnASurfelAreUniform) {
    RandomStream random(3, "points");
    constexpr int count = 4000;
    for (const Mesh& mesh : {test::grid(1, 1), test::needles(30), test::icosphere(3), floor_with_wall(1, 0.0, 1.0)}) {
        const Surfels surfels(mesh, 0.21, Execution{});
        std::vector<Surfels::Piece> pieces;
        for (int round = 0; round < 15; ++round) {
            const auto s = static_cast<Index>(random.below(surfels.size()));
            const SurfacePoint centre = surfels.centre(s, pieces);
            std::vector<Vec3> points;
            for (int k = 0; k < count; ++k) {
                const double u = random.uniform(), v = random.uniform();
                points.push_back(surfels.point_on(pieces, u, v).position);
            }
            for (int line = 0; line < 10; ++line) {
                const Vec3 n =
                    Vec3(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5).normalized();
                const double offset =
                    n.dot(points[static_cast<std::size_t>(random.below(count))] + 0.2 * (centre.position - points[0]));
                double above = 0.0;
                for (const Surfels::Piece& piece : pieces) {
                    const double a = n.dot(mesh.corner(piece.triangle, 0)) - offset;
                    const Eigen::Vector2d b(n.dot(mesh.corner(piece.triangle, 1)) - offset - a,
                                            n.dot(mesh.corner(piece.triangle, 2)) - offset - a);
                    above += 2.0 * mesh.areas[piece.triangle] * piece.outline.cut(a, b).area();
                }
                const double p = above / surfels.area(s);
                const auto got = static_cast<double>(
                    std::count_if(points.begin(), points.end(), [&](const Vec3& x) { return n.dot(x) >= offset; }));
                EXPECT_NEAR(got / count, p, 4.5 * std::sqrt(std::max(0.0, p * (1.0 - p)) / count) + 1e-9);
            }
        }
    }
}

/// No surfel has points on both sides of a wall, as far as the wall reaches.
TEST(Surfels, EndAtWalls) {
    for (const int n : {1, 30, 7}) {
        for (const double from : {0.0, -0.5}) {
            for (const double angle : {0.0, 0.4}) {
                const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Vec3(1, 2, 3).normalized()).toRotationMatrix();
                const Mesh flat = floor_with_wall(n, from, 1.0);
                const Mesh mesh = test::transformed(flat, turn, 1.0, Vec3(0.1, 0.2, 0.3));
                const Surfels surfels(mesh, 0.137, Execution{});
                const auto wall = static_cast<Index>(mesh.triangles.size() - 2);
                const auto local = [&](const Vec3& p) { return Vec3(turn.transpose() * (p - Vec3(0.1, 0.2, 0.3))); };
                std::vector<Surfels::Piece> pieces;
                std::size_t beside = 0;
                for (Index s = 0; s < surfels.size(); ++s) {
                    surfels.pieces(s, pieces);
                    if (pieces[0].triangle >= wall) {
                        continue;
                    }
                    bool left = false, right = false;
                    for (const Surfels::Piece& piece : pieces) {
                        for (std::size_t k = 0; k < piece.outline.count; ++k) {
                            const Eigen::Vector2d& c = piece.outline.corner[k];
                            const Vec3 p = local(mesh.at(piece.triangle, c.x(), c.y()).position);
                            if (p.y() > 0.3 && p.y() < 1.7) {
                                left = left || p.x() < 1.0 - 1e-7;
                                right = right || p.x() > 1.0 + 1e-7;
                                beside += std::abs(p.x() - 1.0) < 1e-7 ? 1 : 0;
                            }
                        }
                    }
                    EXPECT_FALSE(left && right) << n << ", from " << from << ", surfel " << s;
                }
                EXPECT_GT(beside, 20U);
                // Points just beside the wall.
                const Mesh floor = test::grid(n, n, 2.0, 2.0);
                for (double y = 0.301; y < 1.7; y += 0.0317) {
                    Index side[2] = {none, none};
                    for (const int k : {0, 1}) {
                        const Vec3 place(1.0 + (k == 0 ? -1e-6 : 1e-6), y, 0.0);
                        for (Index t = 0; t < wall; ++t) {
                            const Vec3 a = floor.corner(t, 0), b = floor.corner(t, 1) - a, c = floor.corner(t, 2) - a,
                                       d = place - a;
                            const double det = b.x() * c.y() - b.y() * c.x();
                            const double u = (d.x() * c.y() - d.y() * c.x()) / det,
                                         v = (b.x() * d.y() - b.y() * d.x()) / det;
                            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
                                side[k] = surfels.at(t, u, v);
                            }
                        }
                        ASSERT_NE(side[k], none);
                    }
                    EXPECT_NE(side[0], side[1]) << y;
                }
            }
        }
    }
}

TEST(Surfels, TheUnitOfLengthAndTheThreadsDoNotMatter) {
    for (const Named& test : meshes()) {
        SCOPED_TRACE(test.name);
        const double edge = 0.0937;
        const Surfels one(test.mesh, edge, Execution{});
        const auto expect_same = [&](const Surfels& other, double scale) {
            ASSERT_EQ(other.size(), one.size()) << scale;
            for (Index s = 0; s < one.size(); ++s) {
                ASSERT_NEAR(other.area(s), scale * scale * one.area(s), 1e-9 * scale * scale * edge * edge);
            }
            for (const SurfacePoint& x : even_points(test.mesh, 500, RandomStream(1, "points"))) {
                ASSERT_EQ(other.at(x.face, x.u, x.v), one.at(x.face, x.u, x.v));
            }
        };
        for (const double scale : {1e-6, 0x1p-20, 0x1p20, 1e6}) {
            const Mesh scaled = test::moved(test.mesh, scale, Vec3::Zero());
            // Of equal sides rounding chooses the longest, which grids are laid along.
            if (std::exp2(std::round(std::log2(scale))) == scale || test.name.find("sphere") == std::string::npos) {
                expect_same(Surfels(scaled, scale * edge, Execution{}), scale);
            }
        }
        expect_same(Surfels(test.mesh, edge, Execution{3}), 1.0);
    }
}

TEST(Surfels, RefuseToBeCountless) {
    EXPECT_THROW(Surfels(test::grid(1, 1), 1e-6, Execution{}), ResourceError);
}

} // namespace
} // namespace difusa::surfels_test
