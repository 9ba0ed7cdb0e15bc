// The exponent of the light at an edge against quadrature, and against the exact light of two walls.
#include <difusa/study/edge_study.h>
#include <difusa/study/references/edge.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>

#include <support/plugins.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

namespace difusa::references_edge_test {
namespace {

/// With t = s tan(a) the integral is ∫ sin(a)^(1+gamma) cos(a)^-gamma da / 2 over a right angle; 200 panels halve
/// towards its ends, where it is singular.
double symbol_by_quadrature(double gamma) {
    const QuadratureRule rule = gauss_legendre(16);
    const auto panel = [&](double from, double to, bool from_above) {
        double sum = 0.0;
        for (std::size_t i = 0; i < rule.size(); ++i) {
            const double a = from + (to - from) * rule.node[i]; // from the end of the angle that is near
            const double sine = from_above ? std::cos(a) : std::sin(a), cosine = from_above ? std::sin(a) : std::cos(a);
            sum += (to - from) * rule.weight[i] * std::pow(sine, 1.0 + gamma) * std::pow(cosine, -gamma);
        }
        return 0.5 * sum;
    };
    double sum = 0.0;
    for (int k = 0; k < 200; ++k) {
        const double to = std::ldexp(std::numbers::pi / 4.0, -k);
        sum += panel(0.5 * to, to, false) + panel(0.5 * to, to, true);
    }
    return sum;
}

TEST(EdgeSymbol, IsTheIntegral) {
    // The panels leave out 2^(-200 (1 - gamma)) / (1 - gamma) at most: 5e-12. Gauss' rule is exact to rounding on a
    // panel from a to 2a, on which a power of its variable is analytic.
    for (const double gamma : {-0.7, -0.3, 0.0, 0.2, 0.5, 0.7, 0.8}) {
        EXPECT_NEAR(edge_symbol(gamma), symbol_by_quadrature(gamma), 1e-11) << gamma;
    }
    EXPECT_NEAR(edge_symbol(0.0), 0.5, 1e-15);
    EXPECT_THROW(edge_symbol(1.0), UsageError);
    EXPECT_THROW(edge_symbol(-2.0), UsageError);
}

TEST(EdgeExponent, SolvesItsEquation) {
    double last = 1.0;
    for (const double rho : {1e-6, 0.1, 0.2, 0.5, 0.8, 0.95, 1.0}) {
        const double gamma = edge_exponent(rho);
        EXPECT_GT(gamma, 0.5);
        EXPECT_LT(gamma, last);
        // Next to its pole K is 1 / (2 (1 - gamma)), and gamma is rounded.
        EXPECT_NEAR(rho * edge_symbol(gamma), 1.0, 1e-14 + 1e-15 / (1.0 - gamma)) << rho;
        last = gamma;
    }
    for (const double wrong : {0.0, -0.1, 1.1, std::nan("")}) {
        EXPECT_THROW(edge_exponent(wrong), UsageError);
    }
}

TEST(LocalExponent, IsExactForPowers) {
    for (const double gamma : {0.3, 0.9, 2.5}) {
        const auto f = [&](double d) { return 2.0 - 3.0 * std::pow(d, gamma); };
        EXPECT_NEAR(local_exponent(f(0.1), f(0.2), f(0.4)), gamma, 1e-13);
    }
}

/// The next term of the light is like d³ or higher: what the slope is off by falls by more than 2² = 4 each time the
/// distances are halved, down to the error of the reference, 1e-7 of a light whose differences are above 1e-3.
TEST(EdgeExponent, IsThatOfTheExactLight) {
    for (const double rho : {0.2, 0.5, 0.8, 0.95}) {
        const ReferenceCase edge = edge_case(rho);
        const auto off = [&](double d) {
            const auto H = [&](double at) { return edge.exact->at(Vec3(at, 0, 0), Vec3::UnitZ()).H; };
            return std::abs(local_exponent(H(d), H(2 * d), H(4 * d)) - edge_exponent(rho));
        };
        double before = off(0.04);
        for (const double d : {0.02, 0.01, 0.005, 0.0025}) {
            const double now = off(d);
            EXPECT_LT(now, before / 4.0 + 1e-5) << rho << " at " << d;
            before = now;
        }
        EXPECT_LT(before, 1e-4);
    }
}

TEST(EdgeStudy, BakesTheInfiniteEdge) {
    BakeOptions options;
    options.rays = 4096;
    MeasureOptions how;
    how.places = 1000;
    std::vector<EdgeTrial> told;
    const std::vector<double> spacings{0.2, 0.1};
    const std::vector<EdgeTrial> trials =
        edge_study(test::registry(), {0.8}, spacings, 0.05, options, how, Execution{2, nullptr},
                   [&](const EdgeTrial& t) { told.push_back(t); });
    ASSERT_EQ(trials.size(), 1U);
    ASSERT_EQ(told.size(), 1U);
    const EdgeTrial& trial = trials.front();
    for (const std::vector<Measurement>* const bakes : {&trial.even, &trial.graded}) {
        ASSERT_EQ(bakes->size(), spacings.size());
        for (const Measurement& m : *bakes) {
            EXPECT_FALSE(m.failed);
            // The light varies by less than the first distance between sites to the power gamma.
            EXPECT_LT(*m.total.l2.relative(), std::pow(0.2, edge_exponent(0.8) + 0.5));
            EXPECT_LE(m.total.l2.error, m.estimate.high);
        }
        EXPECT_LT(*bakes->back().total.l2.relative(), *bakes->front().total.l2.relative());
    }
    const std::string header = edge_header(spacings), row = edge_row(trial), csv = edge_csv_rows(trial);
    const auto bars = [](const std::string& line) { return std::count(line.begin(), line.end(), '|'); };
    EXPECT_EQ(bars(header), 2 * bars(row));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
    const std::string first = csv.substr(0, csv.find('\n')), names = edge_csv_header();
    EXPECT_EQ(std::count(first.begin(), first.end(), ','), std::count(names.begin(), names.end(), ','));
}

} // namespace
} // namespace difusa::references_edge_test
