#include <difusa/algebra/quadrature.h>
#include <difusa/core/frame.h>
#include <difusa/core/random.h>
#include <difusa/mesh/lobe_harmonics.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <ostream>

namespace difusa {

static void PrintTo(const LobeShape& shape, std::ostream* out) {
    *out << (shape.model == LobeShape::Model::phong ? "phong " : "ggx ") << shape.sharpness;
}

namespace glossy_lobe_test {
namespace {

using Model = LobeShape::Model;
constexpr double pi = std::numbers::pi;

Vec3 direction(double cosine, double angle) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    return {sine * std::cos(angle), sine * std::sin(angle), cosine};
}

/// ∫ f g dω over the hemisphere by a product rule in the polar angle around the mirror direction of `in`, where f is
/// narrow. g(out).
template <class G> double over_hemisphere(const GlossyLobe& lobe, const Vec3& in, const G& g, int around = 400) {
    static const QuadratureRule rule = gauss_legendre(400);
    const Eigen::Matrix3d frame = frame_of(Vec3(-in.x(), -in.y(), in.z()));
    double sum = 0.0;
    for (std::size_t k = 0; k < rule.size(); ++k) {
        // Nodes crowd where the polar angle is small.
        const double t = rule.node[k], polar = pi * t * t;
        for (int a = 0; a < around; ++a) {
            const Vec3 out = frame * direction(std::cos(polar), 2.0 * pi * (a + 0.5) / around);
            if (out.z() > 0.0) {
                sum += rule.weight[k] * 2.0 * pi * t * std::sin(polar) * 2.0 * pi / around *
                       lobe.value(Vec3::UnitZ(), in, out) * g(out);
            }
        }
    }
    return sum;
}

class Lobes : public testing::TestWithParam<LobeShape> {};

/// All light is reflected, from any direction. The bound is that of the quadrature at the edge of the horizon, half a
/// cell of 400, and of the table at grazing angles.
TEST_P(Lobes, ReflectAllLight) {
    const GlossyLobe lobe(GetParam());
    for (const double cosine : {1.0, 0.8, 0.5, 0.2, 0.05}) {
        const double sum = over_hemisphere(lobe, direction(cosine, 0.7), [](const Vec3& out) { return out.z(); });
        EXPECT_NEAR(sum, 1.0, 3e-3) << cosine;
    }
}

TEST_P(Lobes, AreSymmetric) {
    const GlossyLobe lobe(GetParam());
    RandomStream stream(1, "lobes");
    const Vec3 n = direction(0.3, 2.0);
    const Eigen::Matrix3d frame = frame_of(n);
    for (int i = 0; i < 50; ++i) {
        const Vec3 a = frame * direction(1.0 - stream.uniform(), 7.0 * stream.uniform());
        const Vec3 b = frame * direction(1.0 - stream.uniform(), 7.0 * stream.uniform());
        const double f = lobe.value(n, a, b);
        EXPECT_GE(f, 0.0);
        EXPECT_NEAR(lobe.value(n, b, a), f, 1e-12 * f);
        EXPECT_EQ(lobe.value(n, a, -b), 0.0);
    }
}

/// The mean of weight times g over draws is ∫ f g cos dω, for g = 1 and for a g that varies, within 4.5 standard
/// errors.
TEST_P(Lobes, AreDrawnWithTheirWeights) {
    const GlossyLobe lobe(GetParam());
    RandomStream stream(2, "draws");
    const Eigen::Matrix3d frame = frame_of(direction(0.6, 1.0));
    for (const double cosine : {1.0, 0.6, 0.1}) {
        const Vec3 out = direction(cosine, 0.4);
        const auto g = [](const Vec3& in) { return (1.0 + in.x()) * (1.0 + in.x()); };
        double ones = 0.0, sum = 0.0, squares = 0.0, one_squares = 0.0;
        constexpr int draws = 40000;
        for (int i = 0; i < draws; ++i) {
            const double u = stream.uniform(), v = stream.uniform(), w = stream.uniform();
            const GlossyLobe::Draw drawn = lobe.draw(frame.col(2), frame * out, {u, v, w});
            EXPECT_NEAR(drawn.direction.norm(), 1.0, 1e-12);
            const double value = drawn.weight * g(frame.transpose() * drawn.direction);
            ones += drawn.weight;
            one_squares += drawn.weight * drawn.weight;
            sum += value;
            squares += value * value;
        }
        const double n = draws, mean = sum / n, one = ones / n;
        EXPECT_NEAR(one, 1.0, 4.5 * std::sqrt((one_squares / n - one * one) / n) + 1e-3) << cosine;
        const double exact = over_hemisphere(lobe, out, [&](const Vec3& in) { return in.z() * g(in); });
        EXPECT_NEAR(mean, exact, 4.5 * std::sqrt((squares / n - mean * mean) / n) + 1e-2) << cosine;
    }
}

/// The tabulated coefficients are those of a plain quadrature.
TEST_P(Lobes, HaveTheirHarmonics) {
    const GlossyLobe lobe(GetParam());
    const SphericalHarmonics harmonics(6);
    const LobeHarmonics of_lobe(lobe, harmonics);
    std::vector<double> F(of_lobe.numbers().size()), Y(harmonics.count());
    for (const double cosine : {1.0, 0.7, 0.3}) {
        const Vec3 in = direction(cosine, 2.5);
        of_lobe.at(in, F);
        for (std::size_t k = 0; k < F.size(); ++k) {
            const double exact = over_hemisphere(
                lobe, in,
                [&](const Vec3& out) {
                    harmonics.at(out, Y);
                    return 2.0 * pi * Y[of_lobe.numbers()[k]];
                },
                60);
            EXPECT_NEAR(F[k], exact, 2e-2 * LobeHarmonics::even()) << cosine << ", " << of_lobe.numbers()[k];
        }
    }
    EXPECT_GT(of_lobe.resolved(), 0.0);
    EXPECT_LE(of_lobe.resolved(), 1.0);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Lobes,
                         testing::Values(LobeShape{Model::phong, 1.0}, LobeShape{Model::phong, 30.0},
                                         LobeShape{Model::phong, 300.0}, LobeShape{Model::ggx, 1.0},
                                         LobeShape{Model::ggx, 0.5}, LobeShape{Model::ggx, 0.2}));

/// At normal incidence the formula of Phong reflects everything, and at the horizon no more than half.
TEST(GlossyLobe, OfPhongLosesNothingAtNormalIncidence) {
    const GlossyLobe lobe({Model::phong, 50.0});
    EXPECT_NEAR(lobe.reflected(1.0), 1.0, 1e-12);
    EXPECT_LT(lobe.reflected(0.0), 0.51);
}

/// More harmonics hold more of a lobe, and nearly all if they are many for its width.
TEST(LobeHarmonics, HoldMoreOfALobeTheMoreThereAre) {
    const GlossyLobe lobe({Model::phong, 30.0});
    double before = -1.0;
    for (const int order : {0, 2, 4, 8, 16}) {
        const double held = LobeHarmonics(lobe, SphericalHarmonics(order)).resolved();
        EXPECT_GE(held, before);
        before = held;
    }
    EXPECT_GT(before, 0.99);
}

} // namespace
} // namespace glossy_lobe_test
} // namespace difusa
