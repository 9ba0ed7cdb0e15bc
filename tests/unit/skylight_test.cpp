// Rays to the openings of a scene, in a room with a rectangular hole in its ceiling, whose form factors are known.
#include <difusa/transport/skylight.h>

#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/rays/lambert.h>
#include <difusa/scene/sky_parts.h>

#include <support/discretised.h>
#include <support/rooms.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace difusa::skylight_test {
namespace {

using test::Discretised;

const std::array<Vec3, 4> hole{Vec3(2.5, 1.7, 3), Vec3(2.5, 2.3, 3), Vec3(3.3, 2.3, 3), Vec3(3.3, 1.7, 3)};

/// 6 by 4 by 3 m, fronts inwards.
Mesh room() {
    const Vec3 x(6, 0, 0), y(0, 4, 0), z(0, 0, 3);
    Mesh mesh = rectangle({0, 0, 0}, x, y);
    add(mesh, rectangle({0, 0, 0}, z, x), 0);
    add(mesh, rectangle({0, 4, 0}, x, z), 0);
    add(mesh, rectangle({0, 0, 0}, y, z), 0);
    add(mesh, rectangle({6, 0, 0}, z, y), 0);
    add(mesh, rectangle({0, 0, 3}, {0, 4, 0}, {2.5, 0, 0}), 0);
    add(mesh, rectangle({3.3, 0, 3}, {0, 4, 0}, {2.7, 0, 0}), 0);
    add(mesh, rectangle({2.5, 0, 3}, {0, 1.7, 0}, {0.8, 0, 0}), 0);
    add(mesh, rectangle({2.5, 2.3, 3}, {0, 1.7, 0}, {0.8, 0, 0}), 0);
    mesh.derive();
    return mesh;
}

double exact_share(const SurfacePoint& x) {
    return x.position[2] > 2.999 ? 0.0 : lambert_form_factor(x.position, x.normal, hole);
}

class Skylight : public testing::Test {
  protected:
    Skylight() : made_(test::uniform_scene(room(), 0.5, 0.0), 0.5, "cgal", "shepard") {}

    LightTransport refined(std::size_t rays, unsigned threads = 1, std::uint64_t seed = 1) const {
        return with_skylight(made_.gathered(rays, "fibonacci", seed), made_.tracer(), made_.discretisation.points,
                             *test::plugin<Directions>("fibonacci"), seed, Execution{threads, nullptr, nullptr});
    }

    Discretised made_;
};

/// The mean over many sets of rays is the form factor, and each set is near it.
TEST_F(Skylight, RaysToAnOpeningHaveItsFormFactorInTheMean) {
    const auto openings = SkyOpenings::find(made_.tracer(), made_.discretisation.points,
                                            *test::plugin<Directions>("fibonacci"), 1, Execution{});
    ASSERT_TRUE(openings);
    constexpr int sets = 200;
    int looked_at = 0;
    for (std::size_t j = 0; j < made_.discretisation.points.size(); j += 7) {
        const SurfacePoint& x = made_.discretisation.points[j];
        const double exact = exact_share(inset(made_.scene.mesh, x));
        EXPECT_TRUE(exact == 0.0 || openings->contain(x.position, Vec3(2.9, 2.0, 3.0) - x.position));
        double sum = 0.0, squares = 0.0;
        bool looked = true;
        for (int i = 0; i < sets && looked; ++i) {
            RandomStream stream(7, "sets", static_cast<std::uint64_t>(i));
            SkyOpenings::View view;
            looked = view.look(made_.tracer(), *openings, x, 128, stream);
            double seen = 0.0;
            view.for_each([&](const Vec3&, double weight) { seen += weight; });
            sum += seen;
            squares += (seen - exact) * (seen - exact);
        }
        if (!looked || exact == 0.0) {
            EXPECT_EQ(sum, 0.0);
            continue;
        }
        ++looked_at;
        const double deviation = std::sqrt(squares / sets);
        // Five standard errors: one point in two million is beyond.
        EXPECT_NEAR(sum / sets, exact, 5.0 * deviation / std::sqrt(sets)) << x.position.transpose();
        // About a sixth of the rays pass the hole. Of these 21, its edges cut about 4 √21 cells of the lattice
        // (gathering_noise.h): 8 % of noise, or twice that where only corners of it are in sight.
        EXPECT_LT(deviation, 0.18 * exact) << x.position.transpose();
    }
    EXPECT_GT(looked_at, 20);
}

TEST_F(Skylight, RowsAddUpToOneAndAreNearTheFormFactors) {
    constexpr std::size_t rays = 512;
    const LightTransport by_rays = made_.gathered(rays, "fibonacci"), transport = refined(rays);
    ASSERT_TRUE(transport.openings);
    const Values ones = Values::Ones(static_cast<Eigen::Index>(transport.W->columns()), 1);
    Values sums;
    transport.W->apply(ones, sums, Execution{});
    double of_rays = 0.0, of_openings = 0.0;
    for (std::size_t j = 0; j < transport.points(); ++j) {
        EXPECT_NEAR(sums(static_cast<Eigen::Index>(j), 0) + transport.back[j], 1.0, 1e-13);
        const double exact = exact_share(inset(made_.scene.mesh, made_.discretisation.points[j]));
        if (exact < 10.0 / static_cast<double>(rays)) {
            of_rays += std::pow(by_rays.sky[j] - exact, 2);
            of_openings += std::pow(transport.sky[j] - exact, 2);
        }
    }
    // At most 10 of 512 rays pass the hole. The cells around it are about six times its area, so that 21 of 128 aimed
    // rays do: noise in proportion to the power -3/4 of these.
    EXPECT_LT(std::sqrt(of_openings), std::pow(10.0 / 21.0, 0.75) * std::sqrt(of_rays));
}

/// The operator is what its parts say: surfels as the rays of a row meet them, times what is left of 1.
TEST_F(Skylight, ProductsAreThoseOfTheRowsWithScaledSurfaces) {
    const LightTransport by_rays = made_.gathered(256, "fibonacci"), transport = refined(256, 2);
    const auto m = static_cast<Eigen::Index>(transport.surfels);
    RandomStream random(3, "values");
    Values b(m, 2);
    for (Eigen::Index i = 0; i < b.size(); ++i) {
        b.data()[i] = random.uniform();
    }
    Values h, plain;
    transport.gather(b, {}, h, Execution{});
    by_rays.gather(b, {}, plain, Execution{2, nullptr, nullptr});
    for (Eigen::Index j = 0; j < h.rows(); ++j) {
        const auto row = static_cast<std::size_t>(j);
        const double scale = (1.0 - transport.sky[row]) / (1.0 - by_rays.sky[row]);
        EXPECT_NEAR((h.row(j) - scale * plain.row(j)).cwiseAbs().maxCoeff(), 0.0, 1e-14);
    }
    // <W x, z> = <x, Wᵀ z>.
    Values x(static_cast<Eigen::Index>(transport.W->columns()), 1), z(h.rows(), 1), Wx, Wz;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        x.data()[i] = random.uniform();
    }
    for (Eigen::Index i = 0; i < z.size(); ++i) {
        z.data()[i] = random.uniform();
    }
    transport.W->apply(x, Wx, Execution{});
    transport.W->apply_transpose(z, Wz, Execution{});
    EXPECT_NEAR(Wx.cwiseProduct(z).sum(), x.cwiseProduct(Wz).sum(), 1e-12 * static_cast<double>(z.size()));
}

/// Of light from the sky alone: that of aimed rays as if they were independent. They are even: about a sixth of 128
/// pass the hole, and in the 4 √21 cells of the lattice that its edges cut, each of which has a variance of 1/4 at
/// most, they have a quarter of the variance of as many independent ones, 128 · 5/36.
TEST_F(Skylight, TheVarianceOfAimedRaysIsTold) {
    constexpr std::size_t rays = 512;
    constexpr int seeds = 40;
    const auto rows = static_cast<Eigen::Index>(made_.discretisation.points.size());
    Values sum = Values::Zero(rows, 1), squares = sum, told = sum;
    for (int seed = 0; seed < seeds; ++seed) {
        const LightTransport transport = refined(rays, 2, static_cast<std::uint64_t>(seed));
        const auto& W = dynamic_cast<const SkylightTransport&>(*transport.W);
        Values x = Values::Zero(static_cast<Eigen::Index>(W.columns()), 1), seen;
        x.bottomRows(x.rows() - static_cast<Eigen::Index>(transport.surfels)).setOnes();
        W.apply(x, seen, Execution{});
        sum += seen;
        squares += seen.cwiseAbs2();
        told += W.variance_of_rays(x, Execution{}) / rays;
    }
    double measured = 0.0, expected = 0.0;
    for (Eigen::Index j = 0; j < rows; ++j) {
        const double variance = (squares(j, 0) - sum(j, 0) * sum(j, 0) / seeds) / (seeds - 1);
        if (variance > 0.0) { // rows that keep their rays have none over these seeds
            measured += variance;
            expected += told(j, 0) / seeds;
        }
    }
    EXPECT_GT(measured, 0.0);
    EXPECT_LT(measured, expected);
    EXPECT_GT(measured, 0.1 * expected);
}

TEST_F(Skylight, TheSameBitsForAnyNumberOfThreads) {
    const LightTransport one = refined(128, 1), three = refined(128, 3);
    EXPECT_EQ(one.sky, three.sky);
    EXPECT_EQ(one.back, three.back);
    Values x = Values::Ones(static_cast<Eigen::Index>(one.W->columns()), 1), of_one, of_three;
    x.topRows(100).setConstant(0.3);
    one.W->apply(x, of_one, Execution{});
    three.W->apply(x, of_three, Execution{3, nullptr, nullptr});
    EXPECT_EQ(of_one, of_three);
    EXPECT_EQ(one.rays, three.rays);
    EXPECT_EQ(one.segments, three.segments);
}

/// Without the rays to openings it is what it was.
TEST_F(Skylight, ByRaysAloneIsTheTransportBefore) {
    const LightTransport before = made_.gathered(128, "fibonacci"), after = by_rays_alone(refined(128));
    EXPECT_EQ(after.sky, before.sky);
    EXPECT_EQ(after.back, before.back);
    EXPECT_EQ(after.segments, before.segments);
    EXPECT_EQ(after.bytes, before.bytes);
    EXPECT_FALSE(after.openings);
    EXPECT_NE(dynamic_cast<const HitLists*>(after.W.get()), nullptr);
}

/// Rays that escape where no opening is known count as they did.
TEST_F(Skylight, AnOpeningThatWasNotFoundIsNotDark) {
    // Openings of the same box with a hole elsewhere: in the wall x = 6, which is closed here.
    Mesh other = rectangle({0, 0, 0}, {6, 0, 0}, {0, 4, 0});
    add(other, rectangle({0, 0, 0}, {0, 0, 3}, {6, 0, 0}), 0);
    add(other, rectangle({0, 4, 0}, {6, 0, 0}, {0, 0, 3}), 0);
    add(other, rectangle({0, 0, 0}, {0, 4, 0}, {0, 0, 3}), 0);
    add(other, rectangle({0, 0, 3}, {0, 4, 0}, {6, 0, 0}), 0);
    add(other, rectangle({6, 0, 0}, {0, 0, 3}, {0, 3.6, 0}), 0);
    other.derive();
    const Discretised of_other(test::uniform_scene(other, 0.5, 0.0), 0.5, "cgal", "shepard");
    const auto openings = SkyOpenings::find(of_other.tracer(), of_other.discretisation.points,
                                            *test::plugin<Directions>("fibonacci"), 1, Execution{});
    ASSERT_TRUE(openings);
    const LightTransport by_rays = made_.gathered(256, "fibonacci");
    const LightTransport transport =
        with_skylight(by_rays, made_.tracer(), made_.discretisation.points, {SkyParts::count, SkyParts::at}, openings,
                      *test::plugin<Directions>("fibonacci"), 1, Execution{});
    for (std::size_t j = 0; j < transport.points(); ++j) {
        if (made_.discretisation.points[j].position[0] < 4.5) { // the other hole is out of the way
            EXPECT_NEAR(transport.sky[j], by_rays.sky[j], 1e-13);
        }
    }
}

/// What comes through the opening does not depend on how the sky is divided: the ends of rows do not say whether a ray
/// left through it. A part may be all of the sky, and one near a pole is long and narrow.
TEST_F(Skylight, DoesNotDependOnThePartsOfTheSky) {
    const auto directions = test::plugin<Directions>("fibonacci");
    const LightTransport by_parts = refined(256);
    const SkyBins one{1, [](const Vec3&) { return Index{0}; }};
    const LightTransport whole =
        with_skylight(gathered(made_.tracer(), made_.discretisation.points, *made_.discretisation.surfels, one,
                               *directions, 256, 1, Execution{}),
                      made_.tracer(), made_.discretisation.points, one, by_parts.openings, *directions, 1, Execution{});
    for (std::size_t j = 0; j < whole.points(); ++j) {
        EXPECT_NEAR(whole.sky[j], by_parts.sky[j], 1e-13);
    }
}

/// A tall room with a small hole in the middle of its roof: parts of the sky near the zenith are as large as it is
/// seen.
TEST(TallRoom, IsLitAlikeWhereverItsHoleFaces) {
    constexpr double height = 16.0, inner = 2.75, edge = 0.5;
    for (int axis = 0; axis < 3; ++axis) {
        const auto turned = [axis](double u, double v, double w) {
            Vec3 p;
            p[axis] = w;
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            return p;
        };
        const Vec3 u = turned(6, 0, 0), v = turned(0, 6, 0), w = turned(0, 0, height);
        Mesh mesh = rectangle(Vec3::Zero(), u, v);
        add(mesh, rectangle(Vec3::Zero(), w, u), 0);
        add(mesh, rectangle(v, u, w), 0);
        add(mesh, rectangle(Vec3::Zero(), v, w), 0);
        add(mesh, rectangle(u, w, v), 0);
        const double outer = inner + edge;
        add(mesh, rectangle(w, v, turned(inner, 0, 0)), 0);
        add(mesh, rectangle(turned(outer, 0, height), v, turned(inner, 0, 0)), 0);
        add(mesh, rectangle(turned(inner, 0, height), turned(0, inner, 0), turned(edge, 0, 0)), 0);
        add(mesh, rectangle(turned(inner, outer, height), turned(0, inner, 0), turned(edge, 0, 0)), 0);
        mesh.derive();
        const std::array<Vec3, 4> opening{turned(inner, inner, height), turned(inner, outer, height),
                                          turned(outer, outer, height), turned(outer, inner, height)};
        const Discretised made(test::uniform_scene(mesh, 0.5, 0.0), 1.0, "cgal", "shepard");
        const auto directions = test::plugin<Directions>("fibonacci");
        constexpr int seeds = 16;
        const std::size_t count = made.discretisation.points.size();
        std::vector<double> of_seed(seeds, 0.0); // light on the floor
        double exact = 0.0;
        for (int seed = 0; seed < seeds; ++seed) {
            const LightTransport transport =
                with_skylight(made.gathered(512, "fibonacci", static_cast<std::uint64_t>(seed)), made.tracer(),
                              made.discretisation.points, *directions, static_cast<std::uint64_t>(seed), Execution{});
            for (std::size_t j = 0; j < count; ++j) {
                const SurfacePoint x = inset(mesh, made.discretisation.points[j]);
                if (x.position[axis] < 1e-6) {
                    of_seed[static_cast<std::size_t>(seed)] += transport.sky[j];
                    exact += lambert_form_factor(x.position, x.normal, opening) / seeds;
                }
            }
        }
        double mean = 0.0, squares = 0.0;
        for (const double sum : of_seed) {
            mean += sum / seeds;
        }
        for (const double sum : of_seed) {
            squares += (sum - mean) * (sum - mean);
        }
        // Rays that leave through an opening that was not found count besides, without bias. Six standard errors of a
        // mean of 16: by Student's distribution, one run in 40,000 is beyond.
        EXPECT_NEAR(mean, exact, 6.0 * std::sqrt(squares / (seeds - 1.0) / seeds)) << axis;
        EXPECT_LT(std::sqrt(squares / (seeds - 1.0)), 0.1 * exact);
    }
}

/// Where most rays escape, or none does, there are no openings.
TEST(SkyOpenings, AreNotFoundUnderAnOpenSky) {
    Mesh ground = rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
    add(ground, rectangle({0, 0, 0}, {0, 4, 0}, {0, 0, 1}), 0);
    ground.derive();
    Mesh closed = box({0, 0, 0}, {1, 1, 1}, 1, Front::inside);
    closed.derive();
    for (const Mesh& mesh : {ground, closed}) {
        const Discretised made(test::uniform_scene(mesh, 0.5, 0.0), 0.5, "cgal", "shepard");
        EXPECT_FALSE(SkyOpenings::find(made.tracer(), made.discretisation.points,
                                       *test::plugin<Directions>("fibonacci"), 1, Execution{}));
    }
}

} // namespace
} // namespace difusa::skylight_test
