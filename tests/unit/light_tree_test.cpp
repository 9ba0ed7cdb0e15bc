#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/lighting/light_tree.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/lambert.h>
#include <difusa/rays/shaft.h>

#include <gtest/gtest.h>

#include <map>
#include <numeric>

namespace difusa::light_tree_test {
namespace {

std::vector<Index> all_of(const Mesh& mesh) {
    std::vector<Index> triangles(mesh.triangles.size());
    std::iota(triangles.begin(), triangles.end(), Index{0});
    return triangles;
}

/// Balls of 80 triangles here and there: lights in many directions.
Mesh bulbs(int count) {
    RandomStream stream(3, "bulbs");
    Mesh mesh;
    for (int i = 0; i < count; ++i) {
        Mesh ball = sphere(0.05, 1, Front::outside);
        move(ball, Vec3(stream.uniform(), stream.uniform(), stream.uniform()));
        if (i == 0) {
            mesh = ball;
        } else {
            add(mesh, ball, 0);
        }
    }
    return mesh;
}

double form_factor(const Mesh& mesh, Index t, const Vec3& x, const Vec3& n) {
    return lambert_form_factor(x, n, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
}

/// Every light of a node with what the probabilities say: with that of choosing none they sum to 1, and no light that
/// reaches x is left out.
TEST(LightTree, ACutHoldsEveryLightThatReachesThePointOnce) {
    const Mesh mesh = bulbs(7);
    const std::vector<Index> triangles = all_of(mesh);
    std::vector<double> power;
    for (const Index t : triangles) {
        power.push_back(mesh.areas[t] * (1.0 + t % 3));
    }
    const LightTree tree(mesh, triangles, power);
    std::vector<Index> nodes;
    for (const double opening : {0.05, 0.3, 1.0}) {
        for (const auto& [x, n] :
             {std::pair(Vec3(0.5, 0.5, -0.4), Vec3(0, 0, 1)), std::pair(Vec3(0.5, 0.4, 0.3), Vec3(0.6, 0.0, 0.8)),
              std::pair(Vec3(3.0, 0.4, 0.3), Vec3(-1.0, 0.0, 0.0))}) {
            tree.cut(x, n, opening, nodes);
            std::map<Index, double> probability;
            for (const Index node : nodes) {
                double sum = 0.0;
                std::map<Index, double> of_node;
                const int steps = 4096;
                for (int i = 0; i < steps; ++i) {
                    if (const auto pick = tree.pick(node, x, n, (i + 0.5) / steps)) {
                        of_node[pick->light] = pick->probability;
                    } else {
                        sum += 1.0 / steps;
                    }
                }
                for (const auto& [light, p] : of_node) {
                    sum += p;
                    EXPECT_TRUE(probability.try_emplace(light, p).second) << "in two nodes";
                }
                // Lights of a probability below a step may be missed, and each end of an interval be off by one.
                EXPECT_NEAR(sum, 1.0, 560.0 / steps);
            }
            double found = 0.0, all = 0.0;
            for (const Index t : triangles) {
                const double light = form_factor(mesh, t, x, n) * power[t];
                all += light;
                found += probability.contains(t) ? light : 0.0;
            }
            EXPECT_GT(found, 0.98 * all);
            EXPECT_GT(all, 0.0);
        }
    }
}

/// The sum over a cut of (light of a picked lamp / its probability) has the sum over all lamps as mean.
TEST(LightTree, PicksAreRightInTheMean) {
    const Mesh mesh = bulbs(5);
    const std::vector<Index> triangles = all_of(mesh);
    const std::vector<double> power(triangles.size(), 1.0);
    const LightTree tree(mesh, triangles, power);
    const Vec3 x(0.5, 0.5, -0.3), n(0, 0, 1);
    double exact = 0.0, sum_of_squares = 0.0;
    for (const Index t : triangles) {
        const double F = form_factor(mesh, t, x, n);
        exact += F;
        sum_of_squares += F * F;
    }
    // The variance of choosing by power alone, relative to the square of the sum.
    const double by_power = static_cast<double>(triangles.size()) * sum_of_squares / (exact * exact) - 1.0;
    RandomStream stream(1, "picks");
    const int count = 20000;
    double mean = 0.0, squares = 0.0;
    for (int i = 0; i < count; ++i) {
        const auto pick = tree.pick(LightTree::root, x, n, stream.uniform());
        const double value = pick ? form_factor(mesh, triangles[pick->light], x, n) / pick->probability / exact : 0.0;
        mean += value / count;
        squares += (value - 1.0) * (value - 1.0) / count;
    }
    EXPECT_NEAR(mean, 1.0, 4.5 * std::sqrt(squares / count));
    EXPECT_LT(squares, 0.7 * by_power);
}

/// The weighted sum over representatives, relative to that over all lights: mean and mean square of the deviation over
/// `draws`.
std::pair<double, double> deviation(const Mesh& mesh, const Vec3& x, const Vec3& n, double count, int draws) {
    const std::vector<Index> triangles = all_of(mesh);
    const LightTree tree(mesh, triangles, mesh.areas);
    double exact = 0.0;
    for (const Index t : triangles) {
        exact += form_factor(mesh, t, x, n);
    }
    RandomStream stream(2, "representatives");
    std::vector<Index> scratch;
    std::vector<LightTree::Part> parts;
    std::vector<LightTree::Representative> chosen;
    double mean = 0.0, squares = 0.0;
    for (int i = 0; i < draws; ++i) {
        tree.represent(x, n, 0.15, count, stream, scratch, parts, chosen);
        double sum = 0.0;
        for (const LightTree::Representative& one : chosen) {
            sum += one.weight * form_factor(mesh, one.light, x, n);
        }
        mean += (sum / exact - 1.0) / draws;
        squares += (sum / exact - 1.0) * (sum / exact - 1.0) / draws;
    }
    return {mean, squares};
}

/// A far globe is a single node of the cut. Evenly spaced picks are no worse than as many independent ones, whose
/// variance is that of one over their number.
TEST(LightTree, RepresentativesAreRightInTheMeanAndEvenlySpaced) {
    const Mesh globe = sphere(0.15, 4, Front::outside); // 5120 triangles
    const Vec3 x(0.7, 0.3, -1.6), n(0, 0, 1);
    const auto [mean_of_one, of_one] = deviation(globe, x, n, 1.0, 4000);
    EXPECT_NEAR(mean_of_one, 0.0, 4.5 * std::sqrt(of_one / 4000));
    EXPECT_GT(of_one, 0.01);
    const auto [mean, squares] = deviation(globe, x, n, 256.0, 400);
    EXPECT_NEAR(mean, 0.0, 4.5 * std::sqrt(squares / 400));
    EXPECT_LT(squares, of_one / 256.0);
}

/// As many picks as lights, and more where importance differs: nothing is left to chance.
TEST(LightTree, EnoughRepresentativesAreAllLights) {
    const Mesh mesh = bulbs(5);
    const Vec3 x(0.5, 0.5, -0.3), n(0, 0, 1);
    const auto [mean, squares] = deviation(mesh, x, n, 1e6, 4);
    EXPECT_NEAR(mean, 0.0, 400 * 0x1p-52);
    EXPECT_LT(squares, std::pow(400 * 0x1p-52, 2));
}

/// Sixteen times as many lights take hardly more nodes.
TEST(LightTree, CutsGrowSlowerThanTheNumberOfLights) {
    std::vector<std::size_t> sizes;
    for (const int n : {16, 64, 256}) {
        const Mesh mesh = rectangle(Vec3(0, 0, 1), Vec3(0, 1, 0), Vec3(1, 0, 0), n, n); // facing down
        const std::vector<Index> triangles = all_of(mesh);
        const LightTree tree(mesh, triangles, std::vector<double>(triangles.size(), 1.0));
        std::vector<Index> nodes;
        tree.cut(Vec3(0.4, 0.3, 0.0), Vec3::UnitZ(), 0.15, nodes);
        sizes.push_back(nodes.size());
    }
    // From 0.15 / sqrt(2) of the distance on a square of two triangles is as small as wanted: lengths of nodes along
    // both axes are halved in turn, so that there are at most as many as squares of half that size.
    const double most = 1.0 / std::pow(0.5 * 0.15 / std::sqrt(2.0), 2);
    EXPECT_LT(static_cast<double>(sizes[1]), most);
    EXPECT_LT(static_cast<double>(sizes[2]), most);
    EXPECT_LE(sizes[2], 2 * sizes[1]);
    EXPECT_GT(sizes[0], 50U);
}

/// What rays find blocked, the shaft must have announced; and it must not cry wolf all the time.
TEST(Shafts, AnnounceEveryBlocker) {
    RandomStream stream(5, "shafts");
    int clear = 0, blocked_lamps = 0;
    for (int scene = 0; scene < 40; ++scene) {
        Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), 2, 2);
        const auto lamp = static_cast<Index>(mesh.triangles.size());
        add(mesh, rectangle(Vec3(0.4, 0.4, 1), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0)), 0);
        for (int i = 0; i < 4; ++i) {
            const Vec3 a(stream.uniform(), stream.uniform(), stream.uniform());
            const auto edge = [&] {
                return Vec3(0.3 * (Vec3(stream.uniform(), stream.uniform(), stream.uniform()) - Vec3::Constant(0.5)));
            };
            add(mesh, rectangle(a, edge(), edge()), 0);
        }
        BruteForceVisibility visibility;
        visibility.build(mesh);
        const Shafts shafts(mesh), between(mesh, occluders(exposures(mesh, Execution{1})));
        Index last = none;
        for (const SurfacePoint& x : even_points(mesh, 50, RandomStream(7, "points"))) {
            if (x.face >= lamp) {
                continue;
            }
            bool blocked = false;
            for (int i = 0; i < 200 && !blocked; ++i) {
                const double u = stream.uniform(), v = stream.uniform();
                const SurfacePoint y = uniform_point(mesh, lamp, u, v);
                const Segment segment{x.position, y.position, x.face, y.face};
                std::uint8_t hidden = 0;
                visibility.occluded(std::span(&segment, 1), std::span(&hidden, 1));
                blocked = hidden != 0;
            }
            Index first = none;
            const bool announced = shafts.may_be_blocked(x, lamp, first);
            EXPECT_TRUE(announced || !blocked);
            EXPECT_EQ(between.may_be_blocked(x, lamp, last), announced); // whatever was found before
            clear += announced ? 0 : 1;
            blocked_lamps += blocked ? 1 : 0;
        }
    }
    EXPECT_GT(clear, 200);
    EXPECT_GT(blocked_lamps, 200);
}

/// Walls that only touch the tetrahedron between a point and a lamp hide nothing.
TEST(Shafts, NeighboursDoNotCount) {
    const Mesh mesh = box(Vec3(0, 0, 0), Vec3(1, 2, 3), 3, Front::inside);
    EXPECT_TRUE(mesh.convex);
    const Shafts shafts(mesh);
    Index last = none;
    for (const SurfacePoint& x : even_points(mesh, 100, RandomStream(1, "points"))) {
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            if (form_factor(mesh, t, x.position, x.normal) > 0.0) {
                EXPECT_FALSE(shafts.may_be_blocked(x, t, last));
            }
        }
    }
}

} // namespace
} // namespace difusa::light_tree_test
