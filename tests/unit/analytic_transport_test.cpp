// Exact form factors in gathered transport, against closed forms, rays and surfel by surfel.
#include <difusa/transport/analytic_transport.h>

#include <difusa/algebra/dense.h>
#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/rays/lambert.h>
#include <difusa/rays/visible_part.h>
#include <difusa/transport/analytic_factors.h>

#include <support/discretised.h>
#include <support/group_factors.h>
#include <support/rooms.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace difusa::analytic_transport_test {
namespace {

using test::Discretised;
using test::sum_of;

LightTransport refined(const Discretised& made, LightTransport transport, AnalyticUse use, unsigned threads = 1) {
    return with_analytic_factors(std::move(transport), made.scene.mesh, made.discretisation.points,
                                 *made.discretisation.surfels, use, Execution{threads, nullptr, nullptr});
}

/// A floor of 4 by 4, a wall at its side x = 0, and a box on the floor.
Mesh floor_wall_box() {
    Mesh mesh = rectangle({0, -2, 0}, {4, 0, 0}, {0, 4, 0});
    add(mesh, rectangle({0, -2, 0}, {0, 4, 0}, {0, 0, 3}), 1);
    add(mesh, box({1, -0.5, 0}, {2, 0.5, 1}, 1, Front::outside), 2);
    mesh.derive();
    return mesh;
}

/// 1 on surfels of the material, 0 on others.
Values of_material(const Discretised& made, Index material) {
    const Surfels& surfels = *made.discretisation.surfels;
    Values b = made.on_surfels(0.0);
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        surfels.pieces(s, pieces);
        b(s, 0) = made.scene.mesh.material[pieces.front().triangle] == material ? 1.0 : 0.0;
    }
    return b;
}

/// The floor as a point of the wall higher than the box sees it: less what the box hides of it, whose outline is the
/// hull of the box' corners as projected onto the floor.
double floor_beside_box(const SurfacePoint& x) {
    const std::array<Vec3, 4> floor{Vec3(0, -2, 0), {4, -2, 0}, {4, 2, 0}, {0, 2, 0}};
    const double h = x.position[2];
    const auto shadow = [&](double px, double py, double pz) {
        const double t = h / (h - pz);
        return Vec3(t * px, x.position[1] + t * (py - x.position[1]), 0.0);
    };
    // Seen from x < 1: the near side of the box stands in front of its foot, the far side of its top behind.
    std::vector<Vec3> corners;
    for (const double px : {1.0, 2.0}) {
        for (const double py : {-0.5, 0.5}) {
            corners.push_back(shadow(px, py, 0.0));
            corners.push_back(shadow(px, py, 1.0));
        }
    }
    std::sort(corners.begin(), corners.end(),
              [](const Vec3& a, const Vec3& b) { return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1]; });
    std::vector<Vec3> hull;
    for (int side = 0; side < 2; ++side) {
        const std::size_t start = hull.size();
        for (const Vec3& p : corners) {
            while (hull.size() >= start + 2 && (hull.back() - hull[hull.size() - 2]).cross(p - hull.back())[2] <= 0) {
                hull.pop_back();
            }
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(corners.begin(), corners.end());
    }
    const FlatPolygon hidden =
        FlatPolygon(hull).above({{-1, 0, 0}, -4.0}, 0.0).above({{0, 1, 0}, -2.0}, 0.0).above({{0, -1, 0}, -2.0}, 0.0);
    return lambert_form_factor(x.position, x.normal, floor) -
           (hidden.empty() ? 0.0 : lambert_form_factor(x.position, x.normal, hidden.corners()));
}

TEST(AnalyticFactors, OfAFloorBesideABox) {
    const Discretised made(test::uniform_scene(floor_wall_box(), 0.5, 0.0), 0.25, "cgal", "shepard");
    const Mesh& mesh = made.scene.mesh;
    // So many rays that groups are single surfels where anything hides a part of them.
    const AnalyticFactors factors(mesh, *made.discretisation.surfels, 1'000'000'000, Execution{});
    const Values floor = of_material(made, 0);
    AnalyticFactors::Worker worker;
    std::vector<AnalyticFactors::Factor> found;
    int tried = 0;
    for (const SurfacePoint& x : made.discretisation.points) {
        if (mesh.material[x.face] != 1 || x.position[2] < 1.01) {
            continue;
        }
        factors.find(x, found, worker);
        // Sums of some hundred terms of size up to 1, and clips of polygons at edges they nearly touch.
        EXPECT_NEAR(sum_of(factors, found, floor), floor_beside_box(x), 1e-10) << x.position.transpose();
        ++tried;
    }
    EXPECT_GT(tried, 50);
}

/// The form factor of a convex polygon above the face of x, with the shading normal of x and this mirrored at the face.
double above_face(const Mesh& mesh, const SurfacePoint& x, const std::vector<Vec3>& polygon) {
    const Vec3 &n = x.normal, &face = mesh.normals[x.face], from = inset(mesh, x).position;
    const Vec3 below = n - 2.0 * n.dot(face) * face;
    double sum = 0.0;
    for (std::size_t k = 2; k < polygon.size(); ++k) {
        sum += lambert_form_factor(from, n, polygon[0], polygon[k - 1], polygon[k]);
        sum += n == face ? 0.0 : lambert_form_factor(from, below, polygon[0], polygon[k - 1], polygon[k]);
    }
    return sum;
}

TEST(AnalyticFactors, OfABowlAreWhatTheSkyLeaves) {
    // Facets of a bowl occlude none of each other, whatever the outlines of the groups: the bowl and its opening are
    // the hemisphere, also around a shading normal, whose rays are mirrored to above the face.
    const double half = 0.7;
    const int rings = 9;
    const Discretised made(test::uniform_scene(spherical_cap(1.0, half, rings, Front::inside), 0.5, 0.0), 0.1, "cgal",
                           "shepard");
    const Mesh& mesh = made.scene.mesh;
    std::vector<Vec3> opening; // seen from below: clockwise from above
    for (const Vec3& p : mesh.points) {
        if (p[2] > -std::cos(half) - 1e-9) {
            opening.push_back(p);
        }
    }
    std::sort(opening.begin(), opening.end(),
              [](const Vec3& a, const Vec3& b) { return std::atan2(a[1], a[0]) > std::atan2(b[1], b[0]); });
    for (const std::size_t rays : {16, 1024, 1'000'000}) {
        const AnalyticFactors factors(mesh, *made.discretisation.surfels, rays, Execution{});
        AnalyticFactors::Worker worker;
        std::vector<AnalyticFactors::Factor> found;
        for (SurfacePoint x : made.discretisation.points) {
            for (const Vec3& normal : {x.normal, mesh.normals[x.face]}) {
                x.normal = normal;
                factors.find(x, found, worker);
                EXPECT_NEAR(sum_of(factors, found, made.on_surfels(1.0)), 1.0 - above_face(mesh, x, opening), 1e-9)
                    << x.position.transpose();
            }
        }
    }
}

TEST(AnalyticFactors, OfABowlConvergeWithTheSquareOfItsFacets) {
    // All points of the smooth bowl have the form factor (1 - cos(half)) / 2 to it. A normal that is off by d changes
    // that by the order of d: that of facets is off by their size, shading normals by its square, to the rim.
    const double half = 0.7, exact = 0.5 * (1.0 - std::cos(half));
    std::vector<double> shaded, faceted;
    for (const int rings : {3, 6, 12}) { // no facet is smaller than a surfel, so that none is left to rays
        const Discretised made(test::uniform_scene(spherical_cap(1.0, half, rings, Front::inside), 0.5, 0.0), 0.1,
                               "cgal", "shepard");
        const Mesh& mesh = made.scene.mesh;
        const AnalyticFactors factors(mesh, *made.discretisation.surfels, 1'000'000, Execution{});
        AnalyticFactors::Worker worker;
        std::vector<AnalyticFactors::Factor> found;
        double squares = 0.0, squares_faceted = 0.0;
        for (SurfacePoint x : made.discretisation.points) {
            factors.find(x, found, worker);
            squares += std::pow(sum_of(factors, found, made.on_surfels(1.0)) - exact, 2);
            x.normal = mesh.normals[x.face];
            factors.find(x, found, worker);
            squares_faceted += std::pow(sum_of(factors, found, made.on_surfels(1.0)) - exact, 2);
        }
        shaded.push_back(std::sqrt(squares));
        faceted.push_back(std::sqrt(squares_faceted));
    }
    // From 3 to 12 rings, 4^2 and 4^1 in the limit.
    EXPECT_GT(std::log(shaded[0] / shaded[2]) / std::log(4.0), 1.8);
    EXPECT_LT(std::log(faceted[0] / faceted[2]) / std::log(4.0), 1.2);
}

TEST(AnalyticTransport, RowsAddUpToOne) {
    for (const Mesh& mesh : {test::box(1.0, 1, true), test::box(1.0), test::l_room(), test::room_with_block(),
                             test::mobius(60), test::book(5), test::shelf_over_table(0.1), test::needles(100),
                             floor_wall_box(), spherical_cap(1.0, 0.7, 6, Front::inside)}) {
        const Discretised made(test::uniform_scene(mesh, 0.5, 1.0), 0.2, "cgal", "normalized-radial");
        const LightTransport by_rays = made.gathered(100);
        const LightTransport transport = refined(made, by_rays, AnalyticUse::always);
        const Values sums = made.row_sums(transport);
        for (std::size_t j = 0; j < made.sites().size(); ++j) {
            EXPECT_NEAR(sums(static_cast<Eigen::Index>(j), 0) + transport.sky[j] + transport.back[j], 1.0, 1e-12);
            EXPECT_GE(transport.sky[j], 0.0);
            EXPECT_GE(transport.back[j], 0.0);
        }
        // The same bits for any number of threads.
        const LightTransport again = refined(made, by_rays, AnalyticUse::always, 3);
        EXPECT_EQ(made.row_sums(again), sums);
        EXPECT_EQ(&plain_part(*transport.W), by_rays.W.get());
    }
}

TEST(AnalyticTransport, AgreesWithManyRays) {
    // Both estimate the same integral: with 40,000 rays the standard deviation of a share p is below sqrt(p / 40,000)
    // for independent rays, and these are more even; groups err by less than 1/4 of that of the 4096 rays they are made
    // for.
    const Discretised made(test::uniform_scene(floor_wall_box(), 0.5, 0.0), 0.4, "cgal", "shepard");
    const LightTransport many = made.gathered(40'000),
                         transport = refined(made, made.gathered(4096), AnalyticUse::always);
    for (const Index material : {0U, 1U, 3U, 7U}) {
        const Values b = of_material(made, material);
        const Values exact = Discretised::gather(many, b), found = Discretised::gather(transport, b);
        for (Eigen::Index j = 0; j < exact.rows(); ++j) {
            EXPECT_NEAR(found(j, 0), exact(j, 0), 5.0 * std::sqrt((exact(j, 0) + 1e-4) / 40'000.0) + 1e-3) << material;
        }
    }
}

/// Under a lid that turns its back, of which no form factor is computed: rays that bring 1 and rays that bring nothing.
TEST(AnalyticTransport, RaysThatMeetBacksCountForTheVariance) {
    Mesh mesh = rectangle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
    add(mesh, rectangle({-1, -1, 0.1}, {1.5, 0, 0}, {0, 3, 0}), 1);
    mesh.derive();
    const Discretised made(test::uniform_scene(mesh, 0.5, 0.0), 0.3, "cgal", "shepard");
    const LightTransport transport = refined(made, made.gathered(64), AnalyticUse::always);
    const RefinedTransport* const part = refined_part(*transport.W);
    ASSERT_NE(part, nullptr);
    const Values variance =
        part->variance_of_rays(Values::Ones(static_cast<Eigen::Index>(transport.W->columns()), 1), Execution{});
    double largest = 0.0;
    for (std::size_t j = 0; j < transport.points(); ++j) {
        EXPECT_NEAR(variance(static_cast<Eigen::Index>(j), 0), transport.back[j] * (1.0 - transport.back[j]), 1e-12);
        largest = std::max(largest, transport.back[j] * (1.0 - transport.back[j]));
    }
    EXPECT_GT(largest, 0.1);
}

/// Beside a wall that is seen whole, and under a lid that turns its back. With the shares r of the rays in bins and L
/// on backs, scaled by s to what the form factors leave, s (r + L) = 1 - F, rays that bring 1 have the variance s² (r -
/// r² / (r + L)).
TEST(AnalyticTransport, BacksCountForTheVarianceBesideExactFormFactors) {
    Mesh mesh = rectangle({0, -2, 0}, {4, 0, 0}, {0, 4, 0});
    add(mesh, rectangle({0, -2, 0}, {0, 4, 0}, {0, 0, 1}), 1);
    add(mesh, rectangle({2, -2, 2}, {2, 0, 0}, {0, 4, 0}), 2);
    mesh.derive();
    const Discretised made(test::uniform_scene(mesh, 0.5, 0.0), 0.5, "cgal", "shepard");
    const LightTransport by_rays = made.gathered(256);
    const LightTransport transport = refined(made, by_rays, AnalyticUse::always);
    const auto* const W = dynamic_cast<const AnalyticTransport*>(transport.W.get());
    ASSERT_NE(W, nullptr);
    const Values ones = Values::Ones(static_cast<Eigen::Index>(W->columns()), 1);
    const Values variance = W->variance_of_rays(ones, Execution{});
    int both = 0;
    for (std::size_t j = 0; j < transport.points(); ++j) {
        const double F = W->exact_share(j);
        const double L = by_rays.back[j], back = transport.back[j];
        if (F > 0.01 && L > 0.01) {
            ++both;
            const double s = back / L, r = (1.0 - F - back) / s;
            EXPECT_NEAR(variance(static_cast<Eigen::Index>(j), 0), s * s * (r - r * r / (r + L)), 1e-12);
        }
    }
    EXPECT_GT(both, 10);
}

TEST(AnalyticTransport, Transposes) {
    const Discretised made(test::uniform_scene(floor_wall_box(), 0.5, 0.0), 0.5, "cgal", "shepard");
    const LightTransport transport = refined(made, made.gathered(64), AnalyticUse::always);
    const auto rows = static_cast<Eigen::Index>(transport.W->rows()),
               columns = static_cast<Eigen::Index>(transport.W->columns());
    Values x(columns, 2), y(rows, 2), Wx, Wy;
    RandomStream stream(1, "test");
    for (Values* values : {&x, &y}) {
        for (Eigen::Index i = 0; i < values->size(); ++i) {
            values->data()[i] = stream.uniform();
        }
    }
    transport.W->apply(x, Wx, Execution{});
    transport.W->apply_transpose(y, Wy, Execution{});
    for (Eigen::Index c = 0; c < 2; ++c) {
        EXPECT_NEAR(Wx.col(c).dot(y.col(c)), x.col(c).dot(Wy.col(c)), 1e-12 * static_cast<double>(rows));
    }
}

TEST(AnalyticTransport, IsForScenesThatMostRaysLeave) {
    const Discretised room(test::uniform_scene(test::box(1.0, 1, true), 0.5, 0.0), 0.3, "cgal", "shepard"),
        bowl(test::uniform_scene(spherical_cap(1.0, 0.7, 6, Front::inside), 0.5, 0.0), 0.2, "cgal", "shepard");
    const LightTransport in_room = room.gathered(64), in_bowl = bowl.gathered(64);
    EXPECT_EQ(refined(room, in_room, AnalyticUse::automatic).W, in_room.W);
    EXPECT_EQ(refined(bowl, in_bowl, AnalyticUse::never).W, in_bowl.W);
    EXPECT_NE(refined(bowl, in_bowl, AnalyticUse::automatic).W, in_bowl.W);
    EXPECT_NE(refined(room, in_room, AnalyticUse::always).W, in_room.W);
}

TEST(AnalyticTransport, LeavesFacesOnTopOfEachOtherToRays) {
    // The floor twice: no ray tells which of the two it sees, but they see one.
    Mesh mesh = floor_wall_box();
    add(mesh, rectangle({0.5, -1.5, 0}, {3, 0, 0}, {0, 3, 0}), 8);
    mesh.derive();
    const Discretised made(test::uniform_scene(mesh, 0.5, 0.0), 0.4, "cgal", "shepard");
    const LightTransport by_rays = made.gathered(512), transport = refined(made, by_rays, AnalyticUse::always);
    const Values floor = of_material(made, 0) + of_material(made, 8);
    const Values found = Discretised::gather(transport, floor), expected = Discretised::gather(by_rays, floor);
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 0.05);
    const std::vector<std::uint8_t> overlaid = overlaid_faces(made.scene.mesh, Execution{});
    for (Index t = 0; t < overlaid.size(); ++t) {
        const Index material = made.scene.mesh.material[t];
        EXPECT_EQ(overlaid[t], material == 0 || material == 8 ? 1 : 0) << t;
    }
}

/// Form factor of what is in sight from x, looking down.
double in_sight(const Vec3& x, const VisiblePart& visible) {
    double sum = 0.0;
    visible.for_pieces([&](const FlatPolygon& piece) { sum += lambert_form_factor(x, {0, 0, -1}, piece.corners()); });
    return sum;
}

/// Hides what a triangle above the floor hides from x.
bool hide(const Vec3& x, const std::array<Vec3, 3>& triangle, VisiblePart& visible) {
    const FlatPolygon blocker = FlatPolygon(triangle).above({{0, 0, 1}, 0.0}, 0.0).above({{0, 0, -1}, -x[2]}, 0.0);
    const Vec3 normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
    return visible.hide(x, blocker, {normal, normal.dot(triangle[0])}, 0.0);
}

TEST(VisiblePart, ATriangleHidesItsCentralProjection) {
    // From height 2, a triangle at height 1 hides one twice as large on the floor: all of it, if that is inside.
    const Vec3 x(0.1, -0.2, 2.0);
    const std::array<Vec3, 4> floor{Vec3(-3, -3, 0), {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}};
    const std::array<Vec3, 3> triangle{Vec3(-0.4, -0.3, 1), {0.5, -0.1, 1}, {0.1, 0.6, 1}};
    VisiblePart visible;
    visible.set(FlatPolygon(floor));
    EXPECT_TRUE(hide(x, triangle, visible));
    std::array<Vec3, 3> hidden;
    for (std::size_t k = 0; k < 3; ++k) {
        hidden[k] = x + 2.0 * (triangle[k] - x);
    }
    const double left = in_sight(x, visible);
    EXPECT_NEAR(left,
                lambert_form_factor(x, {0, 0, -1}, floor) -
                    lambert_form_factor(x, {0, 0, -1}, hidden[0], hidden[1], hidden[2]),
                1e-14);
    // The same once more hides nothing more.
    const std::size_t count = visible.count();
    hide(x, triangle, visible);
    EXPECT_NEAR(in_sight(x, visible), left, 1e-14);
    EXPECT_GE(visible.count(), count);
    // Below the floor it hides nothing; nor does one without area.
    std::array<Vec3, 3> below = triangle;
    for (Vec3& p : below) {
        p[2] = -1.0;
    }
    visible.set(FlatPolygon(floor));
    EXPECT_FALSE(hide(x, below, visible));
    EXPECT_FALSE(visible.hide(x, FlatPolygon(std::array<Vec3, 3>{triangle[0], triangle[0], triangle[1]}),
                              {{0, 0, 1}, 1.0}, 0.0));
    EXPECT_EQ(visible.count(), 1U);
}

/// Triangles that tile a square, in any order and on either side of a second layer of it, hide the square.
TEST(VisiblePart, ManyBlockersHideTheirUnion) {
    constexpr std::size_t cells = 20;
    const Vec3 x(0.1, -0.2, 2.0);
    const std::array<Vec3, 4> floor{Vec3(-3, -3, 0), {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}};
    std::vector<std::array<Vec3, 3>> triangles;
    for (const double height : {1.0, 0.5}) { // the lower layer lies in the shadow of the upper one
        const double half = height == 1.0 ? 0.6 : 0.5;
        const auto corner = [&](std::size_t i, std::size_t j) {
            const auto along = [&](std::size_t k) {
                return half * (2.0 * static_cast<double>(k) / static_cast<double>(cells) - 1.0);
            };
            return Vec3(along(i), along(j), height);
        };
        for (std::size_t i = 0; i < cells; ++i) {
            for (std::size_t j = 0; j < cells; ++j) {
                triangles.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
                triangles.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
            }
        }
    }
    std::vector<Vec3> hidden;
    for (const Vec3& p : {Vec3(-0.6, -0.6, 1), Vec3(0.6, -0.6, 1), Vec3(0.6, 0.6, 1), Vec3(-0.6, 0.6, 1)}) {
        hidden.push_back(x + 2.0 * (p - x));
    }
    const double expected = lambert_form_factor(x, {0, 0, -1}, floor) - lambert_form_factor(x, {0, 0, -1}, hidden);
    RandomStream random(3, "order of blockers");
    for (int repeat = 0; repeat < 5; ++repeat) {
        for (std::size_t i = triangles.size(); i > 1; --i) {
            std::swap(triangles[i - 1], triangles[random.below(i)]);
        }
        VisiblePart visible;
        visible.set(FlatPolygon(floor));
        for (const std::array<Vec3, 3>& triangle : triangles) {
            hide(x, triangle, visible);
        }
        // Each of the edges between neighbours may leave a sliver as wide as rounding, each piece has that of its sum.
        EXPECT_NEAR(in_sight(x, visible), expected, 1e-12);
        EXPECT_GT(visible.count(), 4U);
    }
}

TEST(VisiblePart, PolygonsOfManyCornersLoseNone) {
    constexpr std::size_t corners = 18;
    std::vector<Vec3> circle;
    for (std::size_t k = 0; k < corners; ++k) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(corners);
        circle.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    }
    // A side that cuts off one corner, at (1, 0), leaves 19.
    const Vec3 x(0, 0, 2);
    VisiblePart visible;
    visible.set(FlatPolygon(circle));
    EXPECT_TRUE(hide(x, {Vec3(0.498, -9, 1), {9, 0, 1}, {0.498, 9, 1}}, visible));
    const FlatPolygon rest = FlatPolygon(circle).above({{-1, 0, 0}, -0.996}, 0.0);
    EXPECT_EQ(rest.size(), corners + 1);
    EXPECT_NEAR(in_sight(x, visible), lambert_form_factor(x, {0, 0, -1}, rest.corners()), 1e-14);
}

} // namespace
} // namespace difusa::analytic_transport_test
