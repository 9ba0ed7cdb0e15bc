#include <difusa/discretisation/separators.h>

#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/obstacles.h>

#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>
#include <support/wall_feet.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace difusa::separators_test {
namespace {

/// A room [0, 2 + thickness] × [0,1]², each side cut into n × n rectangles, and two sheets across it at x = 1 and
/// x = 1 + thickness that end at y = `end`. Their triangles come last: 2 that look down the x axis, 2 that look up it.
Mesh parted_room(double thickness, int n = 1, double end = 1.0) {
    const auto sheet = [&](double x, bool looks_up) {
        return test::make_mesh({{x, 0, 0}, {x, end, 0}, {x, end, 1}, {x, 0, 1}}, {{0, 1, 2}, {0, 2, 3}}, !looks_up);
    };
    const Mesh room = test::box(Vec3(2.0 + thickness, 1, 1), n, true);
    return test::together(test::together(room, sheet(1.0, false)), sheet(1.0 + thickness, true));
}

/// Regions of a room's floor, ceiling and walls along the x axis, if a side of it has 2 n² triangles.
std::vector<Separator> sides_parted_by(const Mesh& mesh, Index n, std::vector<Index> triangles) {
    std::vector<Separator> all;
    for (const Index side : {2U, 3U, 4U, 5U}) {
        for (const Index triangle : triangles) {
            all.push_back({mesh.region[2 * n * n * side], triangle});
        }
    }
    return all;
}

TEST(Separators, NoneWhereNothingCanPart) {
    RandomStream random(4, "motions");
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const double far : {0.0, 1e3}) {
            const auto none_in = [&](const Mesh& mesh) {
                const Mesh there =
                    test::transformed(mesh, test::random_rotation(random), scale, scale * far * Vec3(1, -0.7, 0.4));
                return find_separators(mesh).empty() && find_separators(there).empty();
            };
            EXPECT_TRUE(none_in(test::box(Vec3(1.0, 1.3, 0.7), 1, true))) << "room";
            EXPECT_TRUE(none_in(test::box(Vec3(1.0, 1.3, 0.7), 3, true))) << "room of many triangles";
            EXPECT_TRUE(none_in(test::icosphere(2))) << "sphere";
            EXPECT_TRUE(none_in(test::icosphere(0))) << "sphere of few facets";
            EXPECT_TRUE(
                none_in(test::together(test::grid(4, 4), test::moved(test::icosphere(2), 0.3, {0.5, 0.5, 0.5}))))
                << "ball over a disc";
            EXPECT_TRUE(none_in(test::shelf_over_table(1e-3))) << "shelf over table";
            EXPECT_TRUE(none_in(test::shelf_over_table(0.0))) << "shelf on table";
            EXPECT_TRUE(none_in(test::thin_wall(1e-9))) << "thin wall";
            EXPECT_TRUE(none_in(test::room_with_block())) << "block in the air";
        }
    }
}

TEST(Separators, AWallPartsTheFloorTheCeilingAndTheWallsItStandsBetween) {
    RandomStream random(5, "motions");
    for (const double thickness : {0.1, 1e-3, 1e-6, 1e-9, 0.0}) {
        // Both triangles of a sheet have a corner on each of the four sides, and each side lies on both sides of it.
        const Mesh one = parted_room(thickness);
        EXPECT_EQ(find_separators(one), sides_parted_by(one, 1, {12, 13, 14, 15})) << thickness;
        const Mesh turned = test::transformed(one, test::random_rotation(random), 1e-5, Vec3(3e-3, -1e-2, 2e-3));
        EXPECT_EQ(find_separators(turned), find_separators(one)) << thickness;
    }
    // A wall that stands on an edge of the floor is met by triangles on the one side and by others on the other.
    const Mesh along_edges = parted_room(0.0, 2);
    EXPECT_EQ(find_separators(along_edges), sides_parted_by(along_edges, 2, {48, 49, 50, 51}));
}

TEST(Separators, WhatCrossesPartsEachOther) {
    const Mesh upright =
        test::transformed(test::grid(1, 1), Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()).toRotationMatrix(),
                          0.5, Vec3(0.3, 0.4, -0.2)); // at y = 0.4, z from -0.2 to 0.3
    const Mesh mesh = test::together(test::grid(1, 1), upright);
    const Index floor = mesh.region[0], wall = mesh.region[2];
    ASSERT_NE(floor, wall);
    std::vector<Separator> parted; // the diagonal of the floor is met by the wall, and the reverse
    for (const Separator& s : find_separators(mesh)) {
        EXPECT_EQ(s.region, s.triangle < 2 ? wall : floor);
        parted.push_back(s);
    }
    EXPECT_EQ(parted.size(), 4U);
}

TEST(Separators, TheFootOfATableIsOne) {
    const Mesh leg = test::moved(test::box(Vec3(0.1, 0.1, 0.6)), 1.0, Vec3(0.45, 0.3, 0.0));
    const Mesh mesh = test::together(test::grid(1, 1), leg);
    std::vector<Separator> sides;
    for (Index t = 2; t < 10; ++t) { // not its top, nor its bottom, which lies in the floor
        sides.push_back({mesh.region[0], t});
    }
    EXPECT_EQ(find_separators(mesh), sides);
}

/// Six times the volume of a tetrahedron.
double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return (b - a).cross(c - a).dot(d - a);
}

/// True if a side of triangle A passes through triangle B.
bool pierces(const Mesh& mesh, Index A, Index B) {
    const Vec3 &a = mesh.corner(B, 0), &b = mesh.corner(B, 1), &c = mesh.corner(B, 2);
    for (int k = 0; k < 3; ++k) {
        const Vec3 &p = mesh.corner(A, k), &q = mesh.corner(A, (k + 1) % 3);
        const bool sides = (volume(a, b, c, p) > 0.0) != (volume(a, b, c, q) > 0.0);
        const bool u = volume(p, q, a, b) > 0.0, v = volume(p, q, b, c) > 0.0, w = volume(p, q, c, a) > 0.0;
        if (sides && u == v && v == w) {
            return true;
        }
    }
    return false;
}

/// Triangles in general position, some large, among them a sheet of many.
Mesh thicket(int count) {
    RandomStream random(8, "thicket");
    const auto somewhere = [&] { return Vec3(random.uniform(), random.uniform(), random.uniform()); };
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (int t = 0; t < count; ++t) {
        const Vec3 middle = somewhere();
        const double size = t % 10 == 0 ? 0.8 : 0.15;
        const auto first = static_cast<Index>(points.size());
        for (int k = 0; k < 3; ++k) {
            points.emplace_back(middle + size * (somewhere() - Vec3::Constant(0.5)));
        }
        triangles.push_back({first, first + 1, first + 2});
    }
    Mesh sheet = test::grid(7, 7);
    for (Vec3& p : sheet.points) {
        p = Vec3(p.x(), p.y(), 0.4 + 0.2 * std::sin(3.0 * p.x() + 1.0) * p.y());
    }
    return test::together(test::make_mesh(points, triangles), test::make_mesh(sheet.points, sheet.triangles));
}

TEST(Separators, AreThoseThatEveryPairOfTrianglesShows) {
    const Mesh mesh = thicket(300);
    std::vector<Separator> naive;
    for (Index region = 0; region < mesh.region_count; ++region) {
        for (Index F = 0; F < mesh.triangles.size(); ++F) {
            bool below = false, above = false;
            for (Index T = 0; mesh.region[F] != region && T < mesh.triangles.size(); ++T) {
                if (mesh.region[T] == region && (pierces(mesh, F, T) || pierces(mesh, T, F))) {
                    for (int k = 0; k < 3; ++k) {
                        const double height = mesh.normals[F].dot(mesh.corner(T, k) - mesh.corner(F, 0));
                        (height < 0.0 ? below : above) = true;
                    }
                }
            }
            if (below && above) {
                naive.push_back({region, F});
            }
        }
    }
    EXPECT_GT(naive.size(), 100U);
    EXPECT_EQ(find_separators(mesh), naive);
}

TEST(Separators, HideWhatIsBehindAWallThatEndsInTheRoom) {
    // On the floor a point is hidden from a site if the straight line between them passes x = 1 at y < 0.45, or, if the
    // wall is thick, passes through the rectangle: one of the two sheets at least (it has no end face).
    RandomStream random(6, "motions");
    for (const double thickness : {0.1, 1e-6, 0.0}) {
        const Mesh flat = parted_room(thickness, 1, 0.45);
        const SiteSet plan = test::poisson_sites(flat, 0.2);
        const Eigen::Matrix3d R = test::random_rotation(random);
        const Vec3 offset(30, -20, 10);
        const Mesh mesh = test::transformed(flat, R, 7.0, offset);
        SiteSet sites = plan;
        for (SurfacePoint& site : sites.points) {
            site = mesh.at(site.face, site.u, site.v);
        }
        for (double& radius : sites.radius) {
            radius *= 7.0;
        }
        const Separators separators(mesh, sites, sites.radius);
        ASSERT_TRUE(separators.any());
        std::size_t wrong = 0, missed = 0, hidden = 0, seen = 0;
        for (const SurfacePoint& x : test::random_points(flat, 600, RandomStream(2, "probes"))) {
            const SurfacePoint there = mesh.at(x.face, x.u, x.v);
            for (Index i = 0; i < sites.size(); ++i) {
                const Vec3 &p = plan.points[i].position, &q = x.position;
                if (plan.points[i].normal.z() < 0.5 || x.normal.z() < 0.5) {
                    continue; // the floor only
                }
                const auto passes = [&](double at) {
                    return (p.x() < at) != (q.x() < at) &&
                           p.y() + (at - p.x()) / (q.x() - p.x()) * (q.y() - p.y()) < 0.45;
                };
                const bool behind = passes(1.0) || passes(1.0 + thickness);
                wrong += separators.hides(i, there) != behind ? 1 : 0;
                if (behind && (p - q).norm() < plan.radius[i]) {
                    missed += separators.near(i) ? 0 : 1;
                }
                ++(behind ? hidden : seen);
            }
        }
        EXPECT_EQ(wrong, 0U) << thickness;
        EXPECT_EQ(missed, 0U) << thickness;
        EXPECT_GT(hidden, 100U);
        EXPECT_GT(seen, 100U);
    }
}

TEST(Separators, HideALowGapFromTheOpenSurface) {
    // A table and a shelf close over a part of it. Between the open table and what is below the shelf, the line from a
    // quarter of the support over the one point to the middle of the gap over the other decides, if the gap is less
    // than 1/48 of the support: hidden if it is over or under the shelf where it passes the shelf's height.
    const double support = 0.3;
    for (const double scale : {1.0, 1e5}) {
        for (const double gap : {1e-6, 1e-3, 6e-3, 7e-3}) {
            const Vec3 offset(3, -2, 1);
            const Mesh plan = test::shelf_over_table(gap), mesh = test::moved(plan, scale, offset);
            const SiteSet sites = test::poisson_sites(mesh, 0.1 * scale);
            const Separators separators(mesh, sites, std::vector<double>(sites.size(), scale * support));
            std::size_t wrong = 0, hidden = 0, seen = 0, seen_from_gap = 0;
            for (const SurfacePoint& x : test::random_points(mesh, 1000, RandomStream(2, "probes"))) {
                for (Index i = 0; i < sites.size(); ++i) {
                    const SurfacePoint& site = sites.points[i];
                    const Vec3 p = plan.at(site.face, site.u, site.v).position;
                    const Vec3 q = plan.at(x.face, x.u, x.v).position;
                    if (sites.region[i] != mesh.region[x.face] || (p - q).norm() >= support) {
                        continue;
                    }
                    const bool parted = !test::see_on_table(p, q), flip = test::under_shelf(p);
                    const Vec3 &open = flip ? q : p, &low = flip ? p : q;
                    const double high = 0.25 * support, t = (high - gap) / (high - 0.5 * gap);
                    const bool behind = parted && gap < support / 48.0 && test::under_shelf(open + t * (low - open));
                    wrong += (separators.near(i) && separators.hides(i, x)) != behind ? 1 : 0;
                    ++(behind ? hidden : seen);
                    seen_from_gap += parted && !behind ? 1 : 0;
                }
            }
            EXPECT_EQ(wrong, 0U) << gap;
            EXPECT_GT(seen, 1000U);
            EXPECT_EQ(hidden > 1000U, gap < support / 48.0);
            EXPECT_TRUE(seen_from_gap > 10U || gap < 2e-3);
        }
    }
}

/// A floor bent around the y axis, z = -bend x², x from -1 to 1, and a sheet of both sides on x = 0 from z = 0 up,
/// leaning by `lean` to +x.
Mesh bent_floor_with_wall(double bend, double lean) {
    Mesh floor = test::moved(test::grid(20, 2, 2.0, 1.0), 1.0, Vec3(-1, 0, 0));
    for (Vec3& p : floor.points) {
        p.z() = -bend * p.x() * p.x();
    }
    const std::vector<Vec3> wall{{0, 0, 0}, {0, 1, 0}, {lean, 1, 1}, {lean, 0, 1}};
    const Mesh front = test::make_mesh(wall, {{0, 1, 2}, {0, 2, 3}}),
               back = test::make_mesh(wall, {{0, 2, 1}, {0, 3, 2}});
    return test::together(test::together(test::make_mesh(floor.points, floor.triangles), front), back);
}

TEST(Separators, HideAcrossABulgeADentAndALeaningWall) {
    // Sites on the one side of the wall do not see points on the other, and see all on their own: a bulge between them
    // is no wall.
    for (const double bend : {-0.4, 0.0, 0.4}) {
        for (const double lean : {0.0, 1.0, 2.0}) {
            SCOPED_TRACE(std::to_string(bend) + ", " + std::to_string(lean));
            const Mesh mesh = bent_floor_with_wall(bend, lean);
            const SiteSet sites = test::poisson_sites(mesh, 0.1);
            const Separators separators(mesh, sites, sites.radius);
            ASSERT_TRUE(separators.any(mesh.region[0]));
            std::size_t leaks = 0, blind = 0, across = 0, along = 0;
            for (const SurfacePoint& x : test::random_points(mesh, 2000, RandomStream(2, "probes"))) {
                for (Index i = 0; i < sites.size(); ++i) {
                    const SurfacePoint& p = sites.points[i];
                    if (mesh.region[x.face] != mesh.region[0] || sites.region[i] != mesh.region[0] ||
                        (p.position - x.position).norm() >= sites.radius[i]) {
                        continue;
                    }
                    const bool hidden = separators.near(i) && separators.hides(i, x);
                    if ((p.position.x() < 0.0) != (x.position.x() < 0.0)) {
                        ++across;
                        leaks += hidden ? 0 : 1;
                    } else {
                        ++along;
                        blind += hidden ? 1 : 0;
                    }
                }
            }
            EXPECT_EQ(leaks, 0U);
            EXPECT_EQ(blind, 0U);
            EXPECT_GT(across, 50U);
            EXPECT_GT(along, 500U);
        }
    }
}

TEST(Separators, NoElementReachesThroughAWall) {
    // With thickness 0 there is a site of the same side among the 16 nearest of each point, so no basis has a reason to
    // reach to the other side, not even where supports leave gaps.
    const Mesh mesh = parted_room(0.0);
    const SiteSet sites = test::poisson_sites(mesh, 0.1);
    std::vector<std::string> choices = test::plugin_names<Basis>();
    choices.insert(choices.end(), {"normalized-radial:width=0.1", "normalized-radial:width=3", "shepard:width=0.2"});
    const std::vector<SurfacePoint> points = test::random_points(mesh, 1500, RandomStream(9, "probes"));
    for (const std::string& choice : choices) {
        SCOPED_TRACE(choice);
        const auto basis = test::plugin<Basis>(choice);
        basis->bind(mesh, sites);
        std::vector<BasisRow> rows(points.size());
        basis->evaluate(points, rows);
        std::size_t through = 0, elements = 0, unlike = 0;
        double worst_sum = 0.0;
        BasisRow row;
        for (std::size_t k = 0; k < points.size(); ++k) {
            double sum = 0.0;
            for (std::size_t i = 0; i < rows[k].element.size(); ++i) {
                const Vec3& p = sites.points[rows[k].element[i]].position;
                // Points of the sheets themselves are at x = 1 up to rounding.
                through += points[k].face < 12 && (p.x() - 1.0) * (points[k].position.x() - 1.0) < 0.0 ? 1 : 0;
                sum += rows[k].weight[i];
                ++elements;
            }
            worst_sum = std::max(worst_sum, std::abs(sum - 1.0));
            basis->evaluate(points[k], row);
            unlike += row.element != rows[k].element || row.weight != rows[k].weight ? 1 : 0;
        }
        EXPECT_EQ(through, 0U);
        EXPECT_EQ(unlike, 0U);
        EXPECT_GT(elements, 0U);
        if (basis->sums_to_one()) {
            EXPECT_LE(worst_sum, 1e-12) << "a thousand roundings of numbers whose absolute values sum to at most 5";
        }
    }
}

/// For each region the triangles that lines of sight may cross which end within `lift` of it.
std::vector<std::vector<Index>> obstacles_of(const Mesh& mesh, double around, double lift) {
    const auto trees = std::make_shared<const RegionTrees>(mesh);
    const double rounding = wall_rounding(mesh);
    std::vector<SightReach> reach;
    for (const Index plane : planes_of_regions(mesh, *trees, rounding)) {
        reach.push_back({around, lift, plane});
    }
    const Obstacles obstacles(mesh, trees, reach, rounding);
    std::vector<std::vector<Index>> found(mesh.region_count);
    for (Index region = 0; region < mesh.region_count; ++region) {
        for (Index T = 0; T < mesh.triangles.size(); ++T) {
            if (mesh.region[T] != region && obstacles.may_obstruct(T, region)) {
                found[region].push_back(T);
            }
        }
        EXPECT_EQ(obstacles.any(region), !found[region].empty());
    }
    return found;
}

TEST(Obstacles, AreNoneWhereNothingIsBetween) {
    RandomStream random(14, "motions");
    for (const Mesh& mesh :
         {test::box(Vec3(1.0, 1.3, 0.7), 1, true), test::box(Vec3(1.0, 1.3, 0.7), 3, true), test::thin_wall(1e-9)}) {
        const Mesh there = test::transformed(mesh, test::random_rotation(random), 1e3, Vec3(2e3, -1e3, 5e2));
        for (const auto& found : obstacles_of(there, 50.0, 50.0)) {
            EXPECT_EQ(found, std::vector<Index>());
        }
    }
}

TEST(Obstacles, ArePiecesThatHangCloseOverTheSurface) {
    // An upright sheet over the diagonal of a floor, 0.1 above it.
    const Mesh floor = test::grid(1, 1);
    const Mesh sheet =
        test::make_mesh({{0, 0.5, 0.1}, {1, 0.5, 0.1}, {1, 0.5, 0.8}, {0, 0.5, 0.8}}, {{0, 1, 2}, {0, 2, 3}});
    const Mesh mesh = test::together(floor, sheet);
    for (const double reach : {0.05, 0.2}) {
        const auto found = obstacles_of(mesh, reach, reach);
        EXPECT_EQ(found[mesh.region[0]], reach > 0.1 ? (std::vector<Index>{2, 3}) : std::vector<Index>());
    }
}

TEST(Obstacles, OfAFlatSurfaceAreWithinTheLiftOfItsPlane) {
    // Three small sheets within the box of a floor that is tilted by 45 degrees: across it, just under where lines of
    // sight end, just above that, and below the floor. All are perpendicular to it and cross the middle of it.
    const auto tilted = [](double x, double y, double height) -> Vec3 {
        const double h = std::sqrt(0.5);
        return {x * h - height * h, y, x * h + height * h};
    };
    const auto sheet = [&](double low, double high) {
        return test::make_mesh({tilted(0.5, 0.4, low), tilted(0.5, 0.6, low), tilted(0.5, 0.6, high)}, {{0, 1, 2}});
    };
    const Mesh floor =
        test::make_mesh({tilted(0, 0, 0), tilted(1, 0, 0), tilted(1, 1, 0), tilted(0, 1, 0)}, {{0, 1, 2}, {0, 2, 3}});
    const Mesh mesh =
        test::together(test::together(floor, sheet(-0.05, 0.05)),
                       test::together(sheet(0.09, 0.3), test::together(sheet(0.11, 0.3), sheet(-0.3, -0.01))));
    EXPECT_EQ(obstacles_of(mesh, 10.0, 0.1)[mesh.region[0]], (std::vector<Index>{2, 3}));
}

TEST(Obstacles, AreWithinTheBoxOfTheSurfaceAndTheLift) {
    // Two upright sheets over the middle of a floor, one on it and one beside it, in one plane. Points of the floor lie
    // on both sides of it, but no line between two of them comes to the second, however far it may reach.
    const auto sheet = [](double from, double to) {
        return test::make_mesh({{from, 0.5, 0.01}, {to, 0.5, 0.01}, {to, 0.5, 0.8}, {from, 0.5, 0.8}},
                               {{0, 1, 2}, {0, 2, 3}});
    };
    const Mesh mesh = test::together(test::together(test::grid(1, 1), sheet(0.2, 0.8)), sheet(1.5, 2.5));
    for (const double around : {0.2, 100.0}) {
        EXPECT_EQ(obstacles_of(mesh, around, 0.1)[mesh.region[0]], (std::vector<Index>{2, 3}));
    }
}

enum class Pair { parted, together, other };

struct PairCount {
    std::size_t all = 0, hidden = 0;
};

/// Sites and random points within their radius: pairs of each kind, and how many of these are hidden from each other,
/// whether each is asked about alone or all sites of a point one after the other.
template <class Kind> std::map<Pair, PairCount> count_pairs(const Mesh& mesh, double spacing, const Kind& kind) {
    const SiteSet sites = test::poisson_sites(mesh, spacing);
    const Separators separators(mesh, sites, sites.radius);
    std::map<Pair, PairCount> count;
    for (const SurfacePoint& x : test::random_points(mesh, 2000, RandomStream(2, "probes"))) {
        Separators::Viewpoint shared(x);
        for (Index i = 0; i < sites.size(); ++i) {
            const SurfacePoint& p = sites.points[i];
            if (mesh.region[x.face] != sites.region[i] || (p.position - x.position).norm() >= sites.radius[i] ||
                p.normal.dot(x.normal) <= perpendicular) {
                continue;
            }
            PairCount& of_kind = count[kind(p.position, x.position)];
            ++of_kind.all;
            const bool near = separators.any() && separators.near(i), hidden = near && separators.hides(i, x);
            EXPECT_EQ(near && separators.hides(i, shared), hidden);
            of_kind.hidden += hidden ? 1 : 0;
        }
    }
    return count;
}

void expect_parted(std::map<Pair, PairCount> count) {
    EXPECT_GT(count[Pair::parted].all, 100U);
    EXPECT_EQ(count[Pair::parted].hidden, count[Pair::parted].all);
    EXPECT_GT(count[Pair::together].all, 1000U);
    EXPECT_EQ(count[Pair::together].hidden, 0U);
}

TEST(Separators, HideNothingOfASurfaceThatBulgesOrIsRough) {
    RandomStream random(15, "ground");
    Mesh rough = test::grid(40, 40);
    for (Vec3& p : rough.points) {
        p.z() = 0.01 * random.uniform();
    }
    rough.derive();
    for (const Mesh& mesh : {rough, test::icosphere(3), test::icosphere(0)}) {
        const PairCount count =
            count_pairs(mesh, 0.15, [](const Vec3&, const Vec3&) { return Pair::together; })[Pair::together];
        EXPECT_GT(count.all, 1000U);
        EXPECT_EQ(count.hidden, 0U);
    }
}

TEST(Separators, HideTheFloorsOfARampFromEachOther) {
    // A spiral of which each turn is 0.2 above the last: all of it is one region. From floor to floor one only sees
    // through the hole in the middle.
    constexpr Index steps = 48;
    constexpr double inner = 0.4, rise = 0.2;
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (Index k = 0; k <= 3 * steps; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / steps;
        for (const double r : {inner, 1.0}) {
            points.emplace_back(r * std::cos(angle), r * std::sin(angle), rise * k / steps);
        }
        if (k > 0) {
            const Index a = 2 * k - 2;
            triangles.push_back({a, a + 1, a + 3});
            triangles.push_back({a, a + 3, a + 2});
        }
    }
    const Mesh mesh = test::make_mesh(points, triangles);
    ASSERT_EQ(mesh.region_count, 1U);
    expect_parted(count_pairs(mesh, 0.2, [](const Vec3& p, const Vec3& x) {
        const Vec3 way = x - p, flat(way.x(), way.y(), 0.0), from(p.x(), p.y(), 0.0);
        const double t = std::clamp(-from.dot(flat) / flat.squaredNorm(), 0.0, 1.0);
        if ((from + t * flat).norm() < inner + 0.05 || std::max(p.z(), x.z()) > 2.6 * rise) {
            return Pair::other; // across the hole, or around the end of the last turn
        }
        const double turned = std::atan2(p.x() * x.y() - p.y() * x.x(), p.x() * x.x() + p.y() * x.y());
        const double floors = (x.z() - p.z()) / rise - turned / (2.0 * std::numbers::pi);
        return std::abs(floors) > 0.5 ? Pair::parted : Pair::together;
    }));
}

TEST(Separators, AWallThatIsJoinedToItsFloorHidesWhatIsBehindIt) {
    // All sides of the partition and the floor that runs on beneath it are one region.
    for (const double size : {0.05, 0.01}) {
        SCOPED_TRACE(size);
        const feet::TwoRooms rooms = feet::rounded_partition(size);
        expect_parted(count_pairs(rooms.mesh, 0.2, [&](const Vec3& p, const Vec3& x) {
            const double face = 0.3 * size - 1e-9, a = p.x() - 1.0, b = x.x() - 1.0;
            if (std::abs(a) < face || std::abs(b) < face || std::max(p.y(), x.y()) > 1.0 - 2.0 * size ||
                std::min(p.z(), x.z()) < 0.0) {
                return Pair::other; // beneath the partition, where it is rounded, or under the floor
            }
            return a * b < 0.0 ? Pair::parted : Pair::together;
        }));
    }
}

TEST(BoxTree, FindsEachBoxThatOverlaps) {
    RandomStream random(7, "boxes");
    const auto random_box = [&](double size) {
        const Vec3 low(random.uniform(), random.uniform(), random.uniform());
        return BoxTree::Box(low, low + size * Vec3(random.uniform(), random.uniform(), random.uniform()));
    };
    for (const std::size_t count : {0, 1, 4, 5, 1000}) {
        std::vector<BoxTree::Box> boxes;
        std::vector<Index> items;
        for (std::size_t i = 0; i < count; ++i) {
            boxes.push_back(i % 7 == 3 ? boxes[i - 1] : random_box(0.1));
            items.push_back(static_cast<Index>(3 * i + 1));
        }
        const BoxTree tree(boxes, items);
        EXPECT_EQ(tree.empty(), count == 0);
        for (int query = 0; query < 200; ++query) {
            const BoxTree::Box with = random_box(0.2);
            std::vector<Index> found, naive;
            EXPECT_FALSE(tree.visit(with, [&](Index item, const BoxTree::Box&) {
                found.push_back(item);
                return false;
            }));
            for (std::size_t i = 0; i < count; ++i) {
                if (boxes[i].intersects(with)) {
                    naive.push_back(items[i]);
                }
            }
            std::sort(found.begin(), found.end());
            EXPECT_EQ(found, naive);
            EXPECT_EQ(tree.visit(with, [](Index, const BoxTree::Box&) { return true; }), !naive.empty());
        }
    }
}

} // namespace
} // namespace difusa::separators_test
