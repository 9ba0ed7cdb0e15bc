#include <difusa/core/error.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/directions.h>
#include <difusa/study/references/form_factors.h>

#include <meshes.h>
#include <support/plugins.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

namespace difusa::directions_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double eps = std::numeric_limits<double>::epsilon();

DirectionSet make(const std::string& name, std::size_t count, std::uint64_t index = 0) {
    return test::plugin<Directions>(name)->make(count, RandomStream(1, "test", index));
}

double mean(const DirectionSet& set, const std::function<double(const Vec3&)>& f) {
    double sum = 0.0;
    for (std::size_t d = 0; d < set.direction.size(); ++d) {
        sum += set.weight[d] * f(set.direction[d]);
    }
    return sum;
}

TEST(Directions, AreUnitVectorsOfTheUpperHemisphereWithWeightsThatSumToOne) {
    for (const std::string& name : test::plugin_names<Directions>()) {
        for (const std::size_t count : {1U, 2U, 3U, 7U, 64U, 100U, 1000U}) {
            const DirectionSet set = make(name, count);
            ASSERT_EQ(set.direction.size(), set.weight.size());
            EXPECT_EQ(set.direction.size(), test::plugin<Directions>(name)->size(count)) << name;
            ASSERT_FALSE(set.direction.empty());
            double sum = 0.0;
            for (std::size_t d = 0; d < set.direction.size(); ++d) {
                EXPECT_NEAR(set.direction[d].norm(), 1.0, 2 * eps) << name;
                EXPECT_GT(set.direction[d].z(), 0.0) << name;
                EXPECT_GT(set.weight[d], 0.0) << name;
                sum += set.weight[d];
            }
            EXPECT_NEAR(sum, 1.0, static_cast<double>(set.weight.size()) * eps) << name;
        }
    }
}

/// (1/pi) ∫ f cos over the hemisphere, known exactly.
struct Integral {
    std::function<double(const Vec3&)> f;
    double value;
};

std::vector<Integral> integrals() {
    return {{[](const Vec3& w) { return w.x(); }, 0.0},
            {[](const Vec3& w) { return w.z(); }, 2.0 / 3.0},
            {[](const Vec3& w) { return w.x() * w.x(); }, 0.25},
            {[](const Vec3& w) { return w.z() * w.z(); }, 0.5},
            {[](const Vec3& w) { return w.x() * w.x() * w.y() * w.y(); }, 1.0 / 24.0},
            {[](const Vec3& w) { return std::pow(w.x(), 4); }, 1.0 / 8.0}};
}

class EvenDirections : public testing::TestWithParam<std::string> {};

TEST_P(EvenDirections, ConvergeInTheFirstOrderForSmoothIntegrands) {
    for (std::size_t k = 0; k < integrals().size(); ++k) {
        const Integral integral = integrals()[k];
        const auto rms = [&](std::size_t count) {
            double sum = 0.0;
            for (std::uint64_t s = 0; s < 48; ++s) {
                const double error = mean(make(GetParam(), count, s), integral.f) - integral.value;
                sum += error * error;
            }
            return std::sqrt(sum / 48.0);
        };
        // 48 scrambles know an RMS to about 10 %; the order over a factor of 64 then to 0.03. Independent directions
        // would have order 1/2.
        const auto size = [](std::size_t count) {
            return static_cast<double>(test::plugin<Directions>(GetParam())->size(count));
        };
        const double order = std::log(rms(64) / rms(4096)) / std::log(size(4096) / size(64));
        EXPECT_GT(order, 0.9) << "integrand " << k;
    }
}

TEST_P(EvenDirections, AreRightInTheMean) {
    constexpr int scrambles = 400;
    for (const std::size_t count : {1U, 5U, 16U, 768U}) {
        // The factors of random points of a hemicube's pixels sum to 1 up to O(1/size), by which they are divided.
        const double bias =
            GetParam() == "hemicube" ? 4.0 / static_cast<double>(make("hemicube", count).weight.size()) : 0.0;
        for (const Integral& integral : integrals()) {
            double sum = 0.0, squares = 0.0;
            for (std::uint64_t s = 0; s < scrambles; ++s) {
                const double value = mean(make(GetParam(), count, s), integral.f);
                sum += value;
                squares += value * value;
            }
            const double average = sum / scrambles;
            const double deviation = std::sqrt(std::max(0.0, squares / scrambles - average * average) / scrambles);
            EXPECT_LE(std::abs(average - integral.value), 5.0 * deviation + 1e-12 + bias);
        }
    }
}

/// Inverse of the concentric map: the point of the unit square a direction came from.
Eigen::Vector2d square_of(const Vec3& w) {
    const double radius = std::hypot(w.x(), w.y());
    double angle = std::atan2(w.y(), w.x());          // (-pi, pi]
    angle = angle < -pi / 4 ? angle + 2 * pi : angle; // [-pi/4, 7 pi/4)
    double a = 0.0, b = 0.0;
    if (angle < pi / 4) {
        a = radius;
        b = angle * a / (pi / 4);
    } else if (angle < 3 * pi / 4) {
        b = radius;
        a = -(angle - pi / 2) * b / (pi / 4);
    } else if (angle < 5 * pi / 4) {
        a = -radius;
        b = (angle - pi) * a / (pi / 4);
    } else {
        b = -radius;
        a = -(angle - 3 * pi / 2) * b / (pi / 4);
    }
    return {0.5 * (a + 1.0), 0.5 * (b + 1.0)};
}

TEST(LowDiscrepancy, PutsOneDirectionIntoEveryElementaryInterval) {
    for (const unsigned m : {4U, 7U, 10U}) {
        const std::size_t count = std::size_t{1} << m;
        for (std::uint64_t s = 0; s < 8; ++s) {
            const DirectionSet set = make("low-discrepancy", count, s);
            for (unsigned along = 0; along <= m; ++along) {
                const std::size_t columns = std::size_t{1} << along, rows = count / columns;
                std::vector<int> hits(count, 0);
                for (const Vec3& w : set.direction) {
                    const Eigen::Vector2d p = square_of(w);
                    const auto cell = [](double x, std::size_t cells) {
                        return std::min(cells - 1, static_cast<std::size_t>(x * static_cast<double>(cells)));
                    };
                    ++hits[cell(p[0], columns) * rows + cell(p[1], rows)];
                }
                // A (0, m, 2)-net in base 2. The map there and back rounds: points lie 2^-33 or more inside.
                EXPECT_TRUE(std::all_of(hits.begin(), hits.end(), [](int n) { return n == 1; }))
                    << count << " directions in " << columns << " by " << rows;
            }
        }
    }
}

TEST_P(EvenDirections, DrawnTwiceDiffer) {
    const DirectionSet a = make(GetParam(), 64, 1), b = make(GetParam(), 64, 2);
    for (std::size_t d = 0; d < a.direction.size(); ++d) {
        EXPECT_NE(a.direction[d], b.direction[d]);
    }
}

INSTANTIATE_TEST_SUITE_P(All, EvenDirections, testing::ValuesIn(test::plugin_names<Directions>()),
                         [](const auto& which) {
                             std::string name = which.param;
                             std::erase(name, '-');
                             return name;
                         });

/// The share of the view of an element that a rectangle parallel to it fills, from the pixels whose rays meet it.
TEST(Hemicube, DeltaFactorsAddUpToTheFormFactorOfARectangle) {
    const Rectangle seen{-0.3, 0.8, -0.5, 0.9};
    const double exact = element_to_rectangle(seen, 1.0);
    for (const int n : {16, 64, 256}) {
        const DirectionSet set = make("hemicube:grid=fixed,resolution=" + std::to_string(n), 1);
        ASSERT_EQ(set.direction.size(), static_cast<std::size_t>(3 * n * n));
        const double F = mean(set, [&](const Vec3& w) {
            const double x = w.x() / w.z(), y = w.y() / w.z();
            return x >= seen.x0 && x <= seen.x1 && y >= seen.y0 && y <= seen.y1 ? 1.0 : 0.0;
        });
        // Each edge of the rectangle moves by half a pixel, 1/n, at most; the factors are at most 1/pi by area, and the
        // outline is 5 long.
        EXPECT_NEAR(F, exact, 5.0 / (pi * n)) << n;
    }
}

/// L 44: on the top 1/(pi (x² + y² + 1)²) dA, on the side z/(pi (y² + z² + 1)²) dA; the sum of all is 1 up to the
/// midpoint rule, whose error is h²/24 times the difference of normal derivatives over the outlines.
TEST(Hemicube, WeighsPixelsByTheirDeltaFactors) {
    const int n = 64;
    const double step = 2.0 / n;
    const DirectionSet set = make("hemicube:grid=fixed,resolution=64", 1);
    const auto delta = [&](const Vec3& w) {
        const double largest = std::max(std::abs(w.x()), std::abs(w.y()));
        const Vec3 p = w / std::max(largest, w.z()); // on the cube
        return (w.z() > largest ? 1.0 : p.z()) * step * step / (pi * std::pow(p.squaredNorm(), 2));
    };
    double sum = 0.0;
    for (const Vec3& w : set.direction) {
        sum += delta(w);
    }
    // Second derivatives of the factors by area are at most 4/pi, on an area of 12.
    EXPECT_NEAR(sum, 1.0, step * step / 24.0 * 2.0 * 4.0 / pi * 12.0);
    for (std::size_t d = 0; d < set.direction.size(); ++d) {
        EXPECT_NEAR(set.weight[d], delta(set.direction[d]) / sum, 1e-14);
    }
}

/// A band between two angles to the normal has its integral of the cosine exactly, whatever the number of rays.
TEST(Sphere, BandsHaveTheirExactShare) {
    for (const char* const grid : {"random", "fixed"}) {
        const DirectionSet set = make(std::string("sphere:grid=") + grid, 815); // 18 bands
        for (int band = 1; band < 18; ++band) {
            const double angle = 0.5 * pi * band / 18.0;
            const double inside = mean(set, [&](const Vec3& w) { return w.z() > std::cos(angle) ? 1.0 : 0.0; });
            EXPECT_NEAR(inside, std::sin(angle) * std::sin(angle), 1e-12) << grid << " " << band;
        }
    }
}

/// Ring k of n holds 3 (2k + 1) of the 3 n² directions.
TEST(Nusselt, HasEquallyManyDirectionsOnEqualAreasOfTheDisc) {
    const DirectionSet set = make("nusselt", 300);
    ASSERT_EQ(set.direction.size(), 300U);
    for (int k = 1; k < 10; ++k) {
        const double inside = mean(set, [&](const Vec3& w) { return std::hypot(w.x(), w.y()) < 0.1 * k ? 1.0 : 0.0; });
        EXPECT_NEAR(inside, 0.01 * k * k, 1e-12) << k;
    }
}

/// A fixed set is the same at every site; weights are summed without rounding.
TEST(DirectionPool, KeepsFixedSetsAndMakesWeightsSumToExactlyOne) {
    const Mesh mesh = test::make_mesh({{0, 0, 0}, {1, 0, 0.5}, {0, 1, 0.7}}, {{0, 1, 2}});
    const SurfacePoint x = mesh.at(0, 0.2, 0.3);
    for (const std::string name : {"hemicube", "sphere", "nusselt"}) {
        for (const std::string grid : {"fixed", "random"}) {
            const auto directions = test::plugin<Directions>(name + ":grid=" + grid);
            EXPECT_EQ(directions->is_fixed(), grid == "fixed");
            const DirectionPool pool(*directions, 500, 3);
            EXPECT_EQ(pool.count(), directions->size(500));
            EXPECT_EQ(pool.equal_weights(), directions->equal_weights());
            std::vector<Ray> one(pool.count()), other(pool.count());
            const auto weights = pool.rays(x, 1, one);
            pool.rays(x, 2, other);
            EXPECT_EQ(one[7].direction == other[7].direction, grid == "fixed");
            if (!pool.equal_weights()) {
                double forwards = 0.0, backwards = 0.0;
                for (std::size_t d = 0; d < weights.size(); ++d) {
                    forwards += weights[d];
                    backwards += weights[weights.size() - 1 - d];
                }
                EXPECT_EQ(forwards, 1.0);
                EXPECT_EQ(backwards, 1.0);
            }
        }
    }
}

/// One in each ring of equal area around the normal; neighbours in that order a golden angle apart.
/// One direction, along z, or what a faulty plugin makes of it.
class Faulty final : public Directions {
  public:
    Faulty(const Vec3& direction, double weight) : set_{{direction}, {weight}} {}
    DirectionSet make(std::size_t, RandomStream) const override { return set_; }

  private:
    DirectionSet set_;
};

TEST(DirectionPool, RefusesDirectionsThatAreNone) {
    EXPECT_NO_THROW(DirectionPool(Faulty(Vec3::UnitZ(), 1.0), 1, 1));
    const double not_a_number = std::nan("");
    for (const Vec3& wrong :
         {Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0, 0, 2), Vec3(0, 0, not_a_number), Vec3(0.1, 0, 1)}) {
        EXPECT_THROW(DirectionPool(Faulty(wrong, 1.0), 1, 1), InternalError) << wrong.transpose();
    }
    for (const double wrong : {0.0, -1.0, 0.9, 2.0, not_a_number}) {
        EXPECT_THROW(DirectionPool(Faulty(Vec3::UnitZ(), wrong), 1, 1), InternalError) << wrong;
    }
}

TEST(Fibonacci, IsASpiralOfGoldenAngles) {
    for (const std::size_t count : {1U, 7U, 100U, 4096U}) {
        const DirectionSet set = make("fibonacci", count, 3);
        ASSERT_EQ(set.direction.size(), count);
        const auto n = static_cast<double>(count);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3& w = set.direction[i];
            const double ring = n * (w.x() * w.x() + w.y() * w.y()) - static_cast<double>(i);
            // The squares round to 2 eps of 1, a ring is 1/n of it.
            EXPECT_GE(ring, -4.0 * n * eps) << i;
            EXPECT_LE(ring, 1.0 + 4.0 * n * eps) << i;
            if (i > 0) {
                const Vec3& v = set.direction[i - 1];
                const double turn =
                    std::atan2(v.x() * w.y() - v.y() * w.x(), v.x() * w.x() + v.y() * w.y()) / (2.0 * pi);
                // Turns are of the size of i, of which rounding leaves i eps; near the centre it is worth more angle.
                EXPECT_NEAR(std::abs(turn), 2.0 - std::numbers::phi, 16.0 * eps * (n + std::sqrt(n))) << i;
            }
        }
    }
}

TEST(Tangents, MakeARightHandedFrame) {
    RandomStream random(4, "normals");
    std::vector<Vec3> normals{Vec3::UnitX(),    -Vec3::UnitX(),    Vec3::UnitY(),
                              Vec3::UnitZ(),    -Vec3::UnitZ(),    Vec3(1e-9, 0, -1).normalized(),
                              Vec3(0, 1, -0.0), Vec3(1, 0, 1e-300)};
    for (int i = 0; i < 1000; ++i) {
        normals.push_back(test::random_direction(random).normalized());
    }
    for (const Vec3& n : normals) {
        Vec3 t, b;
        tangents(n, t, b);
        EXPECT_NEAR(t.norm(), 1.0, 8 * eps);
        EXPECT_NEAR(t.dot(n), 0.0, 8 * eps);
        EXPECT_NEAR((t.cross(b) - n).norm(), 0.0, 16 * eps);
    }
}

TEST(DirectionPool, GivesEverySiteRaysAboveItsPlaneFromItsPlace) {
    for (const std::string& name : test::plugin_names<Directions>()) {
        const DirectionPool pool(*test::plugin<Directions>(name), 64, 3);
        const Mesh mesh = test::make_mesh({{0, 0, 0}, {1, 0, 0.5}, {0, 1, 0.7}}, {{0, 1, 2}});
        const SurfacePoint x = mesh.at(0, 0.2, 0.3);
        std::vector<Ray> rays(pool.count());
        Vec3 sum = Vec3::Zero();
        constexpr std::size_t sites = 500;
        for (std::size_t site = 0; site < sites; ++site) {
            const auto weight = pool.rays(x, site, rays);
            double total = 0.0;
            for (std::size_t d = 0; d < rays.size(); ++d) {
                EXPECT_EQ(rays[d].origin, x.position);
                EXPECT_EQ(rays[d].face, x.face);
                EXPECT_GT(rays[d].direction.dot(x.normal), 0.0);
                EXPECT_NEAR(rays[d].direction.norm(), 1.0, 8 * eps);
                total += weight[d];
                sum += weight[d] * rays[d].direction;
            }
            EXPECT_NEAR(total, 1.0, 64 * eps);
        }
        // The cosine-weighted mean direction is 2/3 n; a ray's components have a variance of at most 1/4, and even
        // independent ones would make the mean of 32000 vary by 0.003.
        EXPECT_NEAR((sum / static_cast<double>(sites) - 2.0 / 3.0 * x.normal).norm(), 0.0, 5 * 0.003) << name;
    }
}

} // namespace
} // namespace difusa::directions_test
