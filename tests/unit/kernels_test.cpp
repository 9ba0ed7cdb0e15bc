#include <difusa/transport/kernel.h>

#include <support/plugins.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace difusa::kernels_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double eps = std::numeric_limits<double>::epsilon();

/// Gauss-Legendre nodes and weights on [0,1], the roots of P_n by Newton's method.
void gauss(int n, std::vector<double>& node, std::vector<double>& weight) {
    node.clear();
    weight.clear();
    for (int i = 1; i <= n; ++i) {
        double x = std::cos(pi * (i - 0.25) / (n + 0.5)), slope = 0.0;
        for (int step = 0; step < 8; ++step) {
            double previous = 1.0, P = x; // P_0, P_1
            for (int k = 2; k <= n; ++k) {
                const double next = ((2 * k - 1) * x * P - (k - 1) * previous) / k;
                previous = P;
                P = next;
            }
            slope = n * (x * P - previous) / (x * x - 1.0);
            x -= P / slope;
        }
        node.push_back(0.5 * (1.0 + x));
        weight.push_back(1.0 / ((1.0 - x * x) * slope * slope));
    }
}

TEST(PointKernel, IntegratesToTheFormFactorOfParallelSquares) {
    const auto kernel = test::plugin<Kernel>("point");
    std::vector<double> node, weight;
    constexpr std::size_t n = 12; // the integrand is smooth: the error falls by a factor of about 10 a node
    gauss(n, node, weight);
    double sum = 0.0;
    for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = 0; b < n; ++b) {
            for (std::size_t c = 0; c < n; ++c) {
                for (std::size_t d = 0; d < n; ++d) {
                    sum += weight[a] * weight[b] *
                           kernel->form_factor(Vec3(node[a], node[b], 0), Vec3::UnitZ(), Vec3(node[c], node[d], 1),
                                               -Vec3::UnitZ(), weight[c] * weight[d]);
                }
            }
        }
    }
    EXPECT_NEAR(sum, 0.199824895698387, 1e-13);
}

TEST(PointKernel, IntegratesToTheFormFactorOfSquaresWithACommonEdge) {
    // Along the edge the kernel depends on the difference s of the two places only: of the pairs in [0,1]² the share
    // 2 (1-s) ds has it. What is left is singular where s and both distances from the edge vanish; nodes drawn to
    // there by x = a^4 make up for it.
    const auto kernel = test::plugin<Kernel>("point");
    std::vector<double> node, weight;
    const auto integral = [&](int n) {
        gauss(n, node, weight);
        for (std::size_t i = 0; i < node.size(); ++i) {
            weight[i] *= 4.0 * node[i] * node[i] * node[i];
            node[i] *= node[i] * node[i] * node[i];
        }
        double sum = 0.0;
        for (std::size_t a = 0; a < node.size(); ++a) {
            for (std::size_t b = 0; b < node.size(); ++b) {
                for (std::size_t c = 0; c < node.size(); ++c) {
                    sum += weight[a] * weight[c] * 2.0 * (1.0 - node[c]) *
                           kernel->form_factor(Vec3(node[a], 0, 0), Vec3::UnitZ(), Vec3(0, node[c], node[b]),
                                               Vec3::UnitX(), weight[b]);
                }
            }
        }
        return sum;
    };
    const double exact = 0.200043776075403;
    const double coarse = std::abs(integral(16) - exact), fine = std::abs(integral(64) - exact);
    EXPECT_LT(fine, 1e-8);
    EXPECT_LT(fine, 0.1 * coarse) << "does not converge";
}

TEST(Kernels, AreZeroWhereOneFacesAwayAndNeverNegative) {
    for (const std::string& name : test::plugin_names<Kernel>()) {
        const auto kernel = test::plugin<Kernel>(name);
        RandomStream random(1, "pairs");
        for (int i = 0; i < 2000; ++i) {
            const Vec3 x = test::random_direction(random), n_x = test::random_direction(random);
            const Vec3 y = 3.0 * test::random_direction(random), n_y = test::random_direction(random);
            const double f = kernel->form_factor(x, n_x, y, n_y, 0.1);
            const bool facing = n_x.dot(y - x) > 0.0 && n_y.dot(x - y) > 0.0;
            EXPECT_EQ(f > 0.0, facing) << name;
            EXPECT_GE(f, 0.0) << name;
        }
        EXPECT_EQ(kernel->form_factor(Vec3::Zero(), Vec3::UnitZ(), Vec3::Zero(), -Vec3::UnitZ(), 1.0), 0.0) << name;
    }
}

TEST(PointKernel, IsReciprocal) {
    const auto kernel = test::plugin<Kernel>("point");
    RandomStream random(2, "pairs");
    for (int i = 0; i < 2000; ++i) {
        const Vec3 x = test::random_direction(random), n_x = test::random_direction(random);
        const Vec3 y = 3.0 * test::random_direction(random), n_y = test::random_direction(random);
        const double A_x = random.uniform() + 0.1, A_y = random.uniform() + 0.1;
        const double there = kernel->form_factor(x, n_x, y, n_y, A_y) * A_x;
        const double back = kernel->form_factor(y, n_y, x, n_x, A_x) * A_y;
        EXPECT_NEAR(there, back, 8 * eps * there);
    }
}

TEST(DiscKernel, IsBoundedByTheCosinesAndEqualsThePointKernelFarAway) {
    const auto disc = test::plugin<Kernel>("disc"), point = test::plugin<Kernel>("point");
    RandomStream random(3, "pairs");
    for (int i = 0; i < 2000; ++i) {
        const Vec3 n_x = Vec3::UnitZ();
        Vec3 w = test::random_direction(random), n_y = test::random_direction(random);
        w.z() = std::abs(w.z());
        n_y = n_y.dot(w) > 0.0 ? Vec3(-n_y) : n_y;
        const double cosines = n_x.dot(w) * -n_y.dot(w);
        const double r = std::pow(10.0, 6.0 * random.uniform() - 3.0), A = 0.01;
        const double f = disc->form_factor(Vec3::Zero(), n_x, r * w, n_y, A);
        const double p = point->form_factor(Vec3::Zero(), n_x, r * w, n_y, A);
        EXPECT_LE(f, cosines * (1 + 8 * eps));
        EXPECT_LE(f, p * (1 + 8 * eps));
        // f = p / (1 + A/(pi r²)) exactly
        EXPECT_NEAR(f * (1.0 + A / (pi * r * r)), p, 16 * eps * p);
    }
    // A disc seen from its axis: r²/(h²+r²).
    const double R = 0.7, h = 0.4;
    EXPECT_NEAR(disc->form_factor(Vec3::Zero(), Vec3::UnitZ(), Vec3(0, 0, h), -Vec3::UnitZ(), pi * R * R),
                R * R / (h * h + R * R), 1e-15);
}

TEST(Kernels, DoNotDependOnTheUnitOfLength) {
    for (const std::string& name : test::plugin_names<Kernel>()) {
        const auto kernel = test::plugin<Kernel>(name);
        const Vec3 x(0, 0, 0), n_x = Vec3(1, 2, 3).normalized(), y(2, 1, 1), n_y = Vec3(-1, -1, 0.2).normalized();
        const double f = kernel->form_factor(x, n_x, y, n_y, 0.3);
        EXPECT_GT(f, 0.0);
        for (const double scale : {1e-6, 1e6}) {
            EXPECT_NEAR(kernel->form_factor(x, n_x, scale * y, n_y, scale * scale * 0.3), f, 16 * eps * f) << name;
        }
    }
}

} // namespace
} // namespace difusa::kernels_test
