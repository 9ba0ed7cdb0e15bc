#include <difusa/study/references/ball_over_disc.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>
#include <difusa/rays/lambert.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>

namespace difusa::references_ball_over_disc_test {
namespace {

constexpr double pi = std::numbers::pi;

double indirect(const ReferenceLight& light) {
    return light.H - light.H_direct.value();
}

/// ∫ f over [from, to] with 40 nodes between the ends, which may be singular with half-integer powers.
double integral(double from, double to, const std::function<double(double)>& f) {
    double sum = 0.0;
    for_each_node(gauss_legendre(40), from, to, [&](double x, double weight) { sum += weight * f(x); });
    return sum;
}

TEST(GaussLegendre, IsExactForPolynomialsOfDegreeTwiceTheNodesLessOne) {
    for (const std::size_t n : {1U, 2U, 5U, 24U, 97U}) {
        const QuadratureRule rule = gauss_legendre(n);
        for (std::size_t degree = 0; degree < 2 * n; ++degree) {
            double sum = 0.0;
            for (std::size_t k = 0; k < n; ++k) {
                sum += rule.weight[k] * std::pow(rule.node[k], static_cast<double>(degree));
            }
            EXPECT_NEAR(sum, 1.0 / static_cast<double>(degree + 1), 1e-14) << n << " nodes";
        }
        EXPECT_TRUE(std::is_sorted(rule.node.begin(), rule.node.end()));
    }
}

TEST(GaussLegendre, BarycentricWeightsReproducePolynomials) {
    const QuadratureRule rule = gauss_legendre(9);
    const std::vector<double> weight = barycentric_weights(rule);
    for (const double x : {0.0, 0.1, 0.77, 1.0}) {
        double above = 0.0, below = 0.0;
        for (std::size_t j = 0; j < rule.size(); ++j) {
            above += weight[j] / (x - rule.node[j]) * std::pow(rule.node[j], 8);
            below += weight[j] / (x - rule.node[j]);
        }
        EXPECT_NEAR(above / below, std::pow(x, 8), 1e-13);
    }
}

/// Half-integer powers at both ends: exact but for rounding, since x^(k/2) (1-x)^(l/2) is smooth in the variable.
TEST(GaussLegendre, EndsMayBeSingular) {
    EXPECT_NEAR(integral(0.0, 1.0, [](double x) { return x * std::sqrt(x); }), 0.4, 1e-14);
    EXPECT_NEAR(integral(0.0, 1.0, [](double x) { return std::sqrt(x * (1.0 - x)); }), pi / 8.0, 1e-14);
    EXPECT_NEAR(integral(-2.0, 5.0, [](double x) { return x * x; }), 133.0 / 3.0, 1e-12);
}

/// What the file says of itself: each value to 1e-6.
TEST(BallOverDisc, AgreesWithTheTable) {
    const BallOverDisc solution({}, 1e-9);
    std::ifstream file(DIFUSA_TEST_DATA "/../tests/reference/ball_over_disc.csv");
    ASSERT_TRUE(file.is_open());
    std::string line;
    int count = 0;
    while (std::getline(file, line)) {
        if (line.starts_with("#") || line.starts_with("surface")) {
            continue;
        }
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream fields(line);
        std::string surface;
        double place = 0.0, area = 0.0, total = 0.0, direct = 0.0;
        ASSERT_TRUE(fields >> surface >> place >> area >> total >> direct) << line;
        const ReferenceLight light = surface == "ball" ? solution.ball(place) : solution.disc(place);
        EXPECT_NEAR(light.B(), total, 1e-6) << line;
        EXPECT_NEAR(light.rho * light.H_direct.value(), direct, 1e-6) << line;
        ++count;
    }
    EXPECT_EQ(count, 800);
}

TEST(BallOverDisc, ConvergesFasterThanItsEstimate) {
    const BallOverDisc coarse({}, 1e-3), fine({}, 1e-12);
    ASSERT_LT(coarse.size(), fine.size());
    ASSERT_GT(coarse.error_estimate(), fine.error_estimate());
    for (int k = 0; k <= 300; ++k) {
        const double alpha = -pi / 2.0 + pi * k / 300.0, u = 40.0 * k / 300.0;
        EXPECT_NEAR(coarse.ball(alpha).H, fine.ball(alpha).H, coarse.error_estimate());
        EXPECT_NEAR(coarse.disc(u).H, fine.disc(u).H, coarse.error_estimate());
    }
}

/// A black ball: the lit ring sends it delta mu F, known in closed form at the nadir, and in the whole from the form
/// factor r²h/(h²+u²)^(3/2) of a disc's point to the ball.
TEST(BallOverDisc, ABlackBallOverALitRing) {
    const double R = 7.0, r = 1.0, h = 2.5, delta = 0.6, mu = 3.0, gap = h - r;
    const BallOverDisc solution({R, r, h, 0.0, delta, mu}, 1e-12);
    EXPECT_NEAR(indirect(solution.ball(-pi / 2.0)),
                delta * mu * (R * R / (gap * gap + R * R) - r * r / (gap * gap + r * r)), 1e-12);
    // Half-integer powers where the tangent plane touches a rim: pieces between these latitudes.
    const auto tangent = [&](double v, double sign) {
        return sign * std::atan(v / h) - std::asin(r / std::hypot(h, v));
    };
    const double ends[] = {-pi / 2.0, tangent(R, -1.0), tangent(r, -1.0), 0.0, tangent(R, 1.0)};
    double power = 0.0;
    for (int k = 0; k < 4; ++k) {
        power += integral(ends[k], ends[k + 1], [&](double alpha) {
            return 2.0 * pi * r * r * std::cos(alpha) * indirect(solution.ball(alpha));
        });
    }
    EXPECT_NEAR(power, delta * mu * 2.0 * pi * r * r * (h / std::hypot(h, r) - h / std::hypot(h, R)), 1e-11);
    EXPECT_EQ(indirect(solution.ball(tangent(R, 1.0) + 1e-9)), 0.0) << "above the horizon of the disc";
    for (const double u : {0.0, 0.5, 2.0, 7.0}) {
        EXPECT_EQ(indirect(solution.disc(u)), 0.0) << "the ball sends nothing";
    }
}

/// A second way to the form factor of the ring: triangles between two circles, seen by Lambert's formula. Inscribed
/// polygons of n sides miss a share of 1 - sin(2pi/n)/(2pi/n) <= (2pi/n)²/6 of each circle's sector.
TEST(BallOverDisc, TheRingsFormFactorAgainstLambertsFormula) {
    const double R = 7.0, r = 1.0, h = 2.5;
    const BallOverDisc solution({R, r, h, 0.0, 1.0, 1.0}, 1e-12);
    const int sides = 2000;
    for (const double alpha : {-1.5, -1.0, -0.4, -0.1, 0.1, 0.5}) {
        const Vec3 n(std::cos(alpha), 0.0, std::sin(alpha)), x = Vec3(0.0, 0.0, h) + r * n;
        const auto disc = [&](double radius) {
            double F = 0.0;
            for (int k = 0; k < sides; ++k) {
                const double a = 2.0 * pi * k / sides, b = 2.0 * pi * (k + 1) / sides;
                F += lambert_form_factor(x, n, Vec3::Zero(), radius * Vec3(std::cos(a), std::sin(a), 0.0),
                                         radius * Vec3(std::cos(b), std::sin(b), 0.0));
            }
            return F;
        };
        // The missing slivers are at least h - r away, so their form factors are at most area / (pi (h - r)²).
        const double missing = std::pow(2.0 * pi / sides, 2) / 6.0 * R * R / ((h - r) * (h - r));
        EXPECT_NEAR(indirect(solution.ball(alpha)), disc(R) - disc(r), missing) << alpha;
    }
}

/// A black disc: under the ball no lit latitude is seen. Of the light that the lit half scatters, the share
/// (1 - sin alpha)/2 goes down; the disc misses what leaves within the angle e = (h+r)/(R-r) of the horizon, at most
/// 2e of it.
TEST(BallOverDisc, ABlackDiscUnderALitBall) {
    const double R = 4000.0, r = 1.0, h = 2.5, beta = 0.7, mu = 2.0;
    const BallOverDisc solution({R, r, h, beta, 0.0, mu}, 1e-10);
    for (const double u : {0.0, 0.3, 0.999}) {
        EXPECT_EQ(indirect(solution.disc(u)), 0.0);
        EXPECT_EQ(solution.disc(u).H, 0.0) << "in the shadow";
    }
    double power = 0.0;
    for (double u = r; u < R; u *= 2.0) {
        power += integral(u, std::min(2.0 * u, R), [&](double v) { return 2.0 * pi * v * indirect(solution.disc(v)); });
    }
    const double scattered = beta * mu * pi * r * r, down = scattered / 6.0;
    EXPECT_LT(power, down);
    EXPECT_GT(power, down - 2.0 * (h + r) / (R - r) * scattered);
}

TEST(BallOverDisc, EnergyIsConserved) {
    for (const BallOverDiscParameters& p : {BallOverDiscParameters{},
                                            {40, 5, 6, 0.9, 0.9, 1},
                                            {100, 1, 2, 1, 1, 1},
                                            {4, 5, 6, 0.5, 0.5, 1},
                                            {3e-6, 1e-6, 2e-6, 0.2, 0.8, 5},
                                            {40, 0.01, 20, 0.5, 0.5, 1},
                                            {30, 20, 2000, 0.9, 0.3, 1}}) {
        const double tolerance = 1e-8;
        const BallOverDisc::Power power = BallOverDisc(p, tolerance).power();
        const double widest = std::max(p.R, p.r);
        EXPECT_NEAR(power.incoming, p.mu * pi * widest * widest, tolerance * power.incoming);
        EXPECT_NEAR(power.absorbed + power.escaped, power.incoming, tolerance * power.incoming);
        EXPECT_GE(power.escaped, 0.0);
    }
}

/// The higher the ball, the less light they exchange: the ball receives at most delta mu R²/(h-r)², the disc at most
/// beta mu r²/(h-r)².
TEST(BallOverDisc, FarApartTheyDoNotKnowOfEachOther) {
    for (const double h : {1e2, 1e4, 1e6}) {
        const BallOverDisc solution({3.0, 1.0, h, 0.9, 0.8, 1.0});
        const double most = 1.0 / ((h - 1.0) * (h - 1.0));
        for (int k = 0; k <= 20; ++k) {
            EXPECT_LE(indirect(solution.ball(-pi / 2.0 + pi * k / 20.0)), 9.0 * most);
            EXPECT_LE(indirect(solution.disc(3.0 * k / 20.0)), most);
        }
        EXPECT_GT(indirect(solution.ball(-pi / 2.0)), 0.0);
    }
}

/// The rule of the dissertation (T 7.7, 7.8, with the area r² cos alpha): midpoints in alpha, u and tau, iterated.
class Midpoints {
  public:
    Midpoints(const BallOverDiscParameters& p, int n) : n_(n), p_(p) {
        std::vector<double> kernel(static_cast<std::size_t>(n * n));
        ball.assign(static_cast<std::size_t>(n), 0.0);
        disc = ball;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                for (int k = 0; k < n; ++k) {
                    const double tau = 2.0 * pi * (k + 0.5) / n;
                    const Vec3 normal(std::cos(alpha(i)), 0.0, std::sin(alpha(i)));
                    const Vec3 d = Vec3(u(j) * std::cos(tau), u(j) * std::sin(tau), -p.h) - p.r * normal;
                    kernel[static_cast<std::size_t>(i * n + j)] +=
                        2.0 * pi / n * std::max(0.0, d.dot(normal)) * -d.z() / (pi * d.squaredNorm() * d.squaredNorm());
                }
            }
        }
        for (int bounce = 0; bounce < 100; ++bounce) {
            std::vector<double> to_ball(ball.size()), to_disc(ball.size());
            for (int i = 0; i < n; ++i) {
                for (int j = 0; j < n; ++j) {
                    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
                    const double F = kernel[static_cast<std::size_t>(i * n + j)];
                    to_ball[a] += F * u(j) * p.R / n * p.delta * (disc[b] + (u(j) > p.r ? p.mu : 0.0));
                    to_disc[b] += F * p.r * p.r * std::cos(alpha(i)) * pi / n * p.beta *
                                  (ball[a] + p.mu * std::max(0.0, std::sin(alpha(i))));
                }
            }
            ball = to_ball;
            disc = to_disc;
        }
    }
    double alpha(int i) const { return -pi / 2.0 + pi * (i + 0.5) / n_; }
    double u(int j) const { return p_.R * (j + 0.5) / n_; }

    std::vector<double> ball, disc; ///< indirect irradiance

  private:
    int n_;
    BallOverDiscParameters p_;
};

TEST(BallOverDisc, TheRuleOfMidpointsConvergesToIt) {
    const BallOverDiscParameters parameters{4.0, 1.0, 2.0, 0.9, 0.8, 1.0}; // r is a border between midpoints
    const BallOverDisc solution(parameters, 1e-10);
    const auto error = [&](int n) {
        const Midpoints twin(parameters, n);
        double largest = 0.0;
        for (int i = 0; i < n; ++i) {
            const auto k = static_cast<std::size_t>(i);
            largest = std::max({largest, std::abs(twin.ball[k] - indirect(solution.ball(twin.alpha(i)))),
                                std::abs(twin.disc[k] - indirect(solution.disc(twin.u(i))))});
        }
        return largest;
    };
    // At least first order, even at the kinks.
    const double coarse = error(24), fine = error(96);
    EXPECT_LT(fine, coarse / 4.0);
    EXPECT_LT(fine, 0.01);
}

TEST(BallOverDisc, TheUnitOfLengthDoesNotMatter) {
    const BallOverDisc metres({}), other({40e-9, 5e-9, 20e-9, 0.9, 0.9, 0.9});
    for (int k = 0; k <= 10; ++k) {
        EXPECT_NEAR(other.disc(4e-9 * k).H, metres.disc(4.0 * k).H, 1e-12);
        EXPECT_NEAR(other.ball(0.15 * k).H, metres.ball(0.15 * k).H, 1e-12);
    }
}

TEST(BallOverDisc, PointsOfAMesh) {
    const BallOverDisc solution({});
    const Vec3 n = Vec3(0.6, 0.0, -0.8);
    EXPECT_EQ(solution.at(Vec3(0, 0, 20) + 4.9 * n, n).H, solution.ball(std::asin(n.z())).H) << "a chord of the ball";
    EXPECT_EQ(solution.at(Vec3(0, 12, 0), Vec3::UnitZ()).H, solution.disc(12.0).H);
    EXPECT_EQ(solution.at(Vec3(0, 40.001, 0), Vec3::UnitZ()).H, solution.disc(40.0).H);
    EXPECT_THROW(solution.at(Vec3(0, 12, 0), -Vec3::UnitZ()), UsageError);
    EXPECT_EQ(solution.disc(5.0).H_direct, 0.0);
    EXPECT_EQ(solution.disc(std::nextafter(5.0, 6.0)).H_direct, 0.9);
}

TEST(BallOverDisc, BadParametersAreRefused) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    for (const BallOverDiscParameters& p : {BallOverDiscParameters{0, 5, 20, 0.9, 0.9, 1},
                                            {40, 0, 20, 0.9, 0.9, 1},
                                            {40, 5, 5, 0.9, 0.9, 1},
                                            {40, 5, 20, 1.1, 0.9, 1},
                                            {40, 5, 20, 0.9, -0.1, 1},
                                            {40, 5, 20, 0.9, 0.9, 0},
                                            {nan, 5, 20, 0.9, 0.9, 1},
                                            {40, nan, 20, 0.9, 0.9, 1},
                                            {infinity, 5, 20, 0.9, 0.9, 1},
                                            {40, 5, infinity, 0.9, 0.9, 1},
                                            {40, 5, 20, nan, 0.9, 1},
                                            {40, 5, 20, 0.9, 0.9, infinity}}) {
        EXPECT_THROW(BallOverDisc{p}, UsageError);
    }
    EXPECT_THROW(BallOverDisc({}, 1e-13), UsageError);
    EXPECT_THROW(BallOverDisc({40, 5, 5.0001, 0.9, 0.9, 1}), NotConverged);
    const BallOverDisc solution({});
    EXPECT_THROW(solution.ball(1.6), UsageError);
    EXPECT_THROW(solution.ball(nan), UsageError);
    EXPECT_THROW(solution.disc(40.5), UsageError);
    EXPECT_THROW(solution.disc(-1.0), UsageError);
}

} // namespace
} // namespace difusa::references_ball_over_disc_test
