// Basis `moving-least-squares`; what holds for every basis is in bases_test.cpp.
#include <difusa/discretisation/basis.h>

#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <Eigen/LU>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace difusa::moving_least_squares_test {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double bound = 5.0; ///< of sum |phi_i|, as documented

std::shared_ptr<Basis> bound_basis(const Mesh& mesh, const SiteSet& sites, const std::string& parameters = "") {
    auto basis = test::plugin<Basis>("moving-least-squares" + parameters);
    basis->bind(mesh, sites);
    return basis;
}

SiteSet sites_at(const Mesh& mesh, std::vector<SurfacePoint> points, double spacing, int neighbours = 10) {
    return make_site_set(mesh, std::move(points), spacing, neighbours, Execution{});
}

/// sum_i f(p_i) phi_i(x).
double applied(const SiteSet& sites, const BasisRow& row, const std::function<double(const Vec3&)>& f) {
    double sum = 0.0;
    for (std::size_t i = 0; i < row.element.size(); ++i) {
        sum += row.weight[i] * f(sites.points[row.element[i]].position);
    }
    return sum;
}

double absolute_sum(const BasisRow& row) {
    double sum = 0.0;
    for (const double w : row.weight) {
        sum += std::abs(w);
    }
    return sum;
}

/// The printed formula phi_i = w_i p(0)ᵀ M⁻¹ p(d_i), all sites asked and lengths in units of H; and how far the guards
/// are: the least eigenvalue of C and δ.
struct Twin {
    Eigen::VectorXd phi;
    double least = 0.0, delta = std::numeric_limits<double>::infinity();
    bool unguarded() const { return least > 0.0041 && delta < 3.99; }
};

Twin twin(const Mesh& mesh, const SiteSet& sites, const SurfacePoint& x, double width, bool l_room = false) {
    const auto n = static_cast<Eigen::Index>(sites.size());
    Eigen::VectorXd w = Eigen::VectorXd::Zero(n);
    Eigen::MatrixXd p = Eigen::MatrixXd::Ones(n, 3);
    const Vec3 s = x.normal.unitOrthogonal(), t = x.normal.cross(s);
    double H_squared = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto site = static_cast<std::size_t>(i);
        const Vec3 away = sites.points[site].position - x.position;
        const double R = width * sites.radius[site], q = away.norm() / R, c = x.normal.dot(sites.points[site].normal);
        const bool seen = !l_room || test::see_in_l_room(x.position, sites.points[site].position);
        if (sites.region[site] == mesh.region[x.face] && q < 1.0 && c > perpendicular && seen) {
            w[i] = (2.0 * q * q * q - 3.0 * q * q + 1.0) * c;
            H_squared += w[i] * R * R;
        }
        p(i, 1) = away.dot(s);
        p(i, 2) = away.dot(t);
    }
    Twin result;
    if (!(w.sum() > 0.0)) {
        return result;
    }
    p.rightCols(2) /= std::sqrt(H_squared / w.sum());
    const Eigen::Matrix3d M = p.transpose() * w.asDiagonal() * p;
    const Eigen::Vector2d m = M.block<2, 1>(1, 0) / M(0, 0);
    const Eigen::Matrix2d C = M.block<2, 2>(1, 1) / M(0, 0) - m * m.transpose();
    result.least = 0.5 * C.trace() - std::hypot(0.5 * (C(0, 0) - C(1, 1)), C(0, 1)); // its lesser eigenvalue
    if (result.least > 0.0) {
        result.delta = std::sqrt(m.dot(C.inverse() * m));
        const Eigen::Vector3d solution = M.inverse().col(0);
        result.phi = w.cwiseProduct(p * solution);
    }
    return result;
}

struct Case {
    std::string name;
    Mesh mesh;
    double spacing;
};

std::vector<Case> cases() {
    return {{"square", test::grid(1, 1), 0.08},
            {"cube", test::box(1.0), 0.15},
            {"sphere", test::icosphere(2), 0.2},
            {"room", test::l_room(), 0.25},
            {"needles", test::needles(60), 0.1},
            {"thin wall", test::thin_wall(1e-9), 0.2},
            {"few facets, far away", test::moved(test::icosphere(0), 1e6, Vec3(1e8, 0, 0)), 4e5}};
}

TEST(MovingLeastSquares, SaysWhatItIs) {
    const auto basis = test::plugin<Basis>("moving-least-squares");
    EXPECT_FALSE(basis->partition_of_unity());
    EXPECT_TRUE(basis->sums_to_one());
    EXPECT_TRUE(basis->coefficients_are_values());
}

TEST(MovingLeastSquares, AgreesWithThePrintedFormulaWhereItsMatrixIsGood) {
    for (const Case& c : cases()) {
        const SiteSet sites = test::poisson_sites(c.mesh, c.spacing);
        for (const double width : {1.0, 0.8, 2.0}) {
            SCOPED_TRACE(c.name + ", width " + std::to_string(width));
            const auto basis = bound_basis(c.mesh, sites, ":width=" + std::to_string(width));
            BasisRow row;
            std::size_t compared = 0;
            const auto probes = test::random_points(c.mesh, 400, RandomStream(8, "probes"));
            // Weights of the condition 1/least, positions rounded at the scene's magnitude and divided by H.
            const double tolerance = 100.0 * eps / 0.004 * std::max(1.0, c.mesh.magnitude() / c.spacing);
            double worst = 0.0;
            for (const SurfacePoint& x : probes) {
                const Twin exact = twin(c.mesh, sites, x, width, c.name == "room");
                if (!exact.unguarded()) {
                    continue;
                }
                ++compared;
                basis->evaluate(x, row);
                Eigen::VectorXd difference = exact.phi;
                for (std::size_t i = 0; i < row.element.size(); ++i) {
                    difference[row.element[i]] -= row.weight[i];
                }
                worst = std::max(worst, difference.cwiseAbs().maxCoeff());
            }
            EXPECT_LE(worst, tolerance);
            EXPECT_GT(compared, probes.size() * 8 / 10);
        }
    }
}

TEST(MovingLeastSquares, SumsToOneAndIsBoundedEverywhere) {
    for (const Case& c : cases()) {
        for (const double spacing : {c.spacing, 6.0 * c.spacing}) { // the wider: a handful of sites a face, or one
            const SiteSet sites = test::poisson_sites(c.mesh, spacing);
            for (const char* width : {":width=1", ":width=0.6", ":width=0.2"}) {
                SCOPED_TRACE(c.name + ", " + std::to_string(spacing) + width);
                const auto basis = bound_basis(c.mesh, sites, width);
                auto probes = test::random_points(c.mesh, 500, RandomStream(8, "probes"));
                const auto special = test::special_points(c.mesh);
                probes.insert(probes.end(), special.begin(),
                              special.begin() + std::min<std::ptrdiff_t>(500, std::ssize(special)));
                BasisRow row;
                double worst_sum = 0.0, largest = 0.0;
                for (const SurfacePoint& x : probes) {
                    basis->evaluate(x, row);
                    worst_sum = std::max(worst_sum, std::abs(applied(sites, row, [](const Vec3&) { return 1.0; }) - 1));
                    largest = std::max(largest, absolute_sum(row));
                }
                EXPECT_LE(worst_sum, 200 * bound * eps);
                EXPECT_LE(largest, bound * (1 + 200 * eps));
            }
        }
    }
}

TEST(MovingLeastSquares, ReproducesLinearFunctionsOnPlanes) {
    // A unit square anywhere, up to its border and corners. Positions are rounded to eps · magnitude, and weighed with
    // sum |phi| <= 5.
    RandomStream random(3, "motions");
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const double far : {0.0, 1e3}) {
            const Mesh mesh =
                test::transformed(test::grid(3, 2), test::random_rotation(random), scale, scale * far * Vec3(1, -2, 3));
            const SiteSet sites = test::poisson_sites(mesh, 0.08 * scale);
            const auto basis = bound_basis(mesh, sites);
            auto probes = test::random_points(mesh, 500, RandomStream(8, "probes"));
            const auto special = test::special_points(mesh);
            probes.insert(probes.end(), special.begin(), special.end());
            BasisRow row;
            std::size_t guarded = 0;
            double worst = 0.0;
            for (const SurfacePoint& x : probes) {
                if (!twin(mesh, sites, x, 1.0).unguarded()) {
                    ++guarded;
                    continue;
                }
                basis->evaluate(x, row);
                for (int axis = 0; axis < 3; ++axis) {
                    const double value = applied(sites, row, [&](const Vec3& p) { return p[axis]; });
                    worst = std::max(worst, std::abs(value - x.position[axis]));
                }
            }
            EXPECT_LE(worst, 200 * bound * eps * mesh.magnitude());
            EXPECT_LE(guarded, probes.size() / 100);
        }
    }
}

double wave(const Vec3& p) {
    return std::sin(3.0 * p.x() + 1.0) * std::cos(2.0 * p.y()) + std::sin(2.0 * p.z());
}

TEST(MovingLeastSquares, ErrsByTheSecondDerivativeAtMost) {
    // Taylor: |f(x) - sum_i f(p_i) phi_i(x)| <= ½ F sum_i |phi_i| |p_i - x|² with F >= ‖f''‖, where linear functions
    // are reproduced. On the plane z = 0 the second derivatives of `wave` are at most 9, 6 and 4: F <= 13.
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.05);
    const auto basis = bound_basis(mesh, sites);
    BasisRow row;
    std::size_t compared = 0;
    for (const SurfacePoint& x : test::random_points(mesh, 2000, RandomStream(8, "probes"))) {
        if (!twin(mesh, sites, x, 1.0).unguarded()) {
            continue;
        }
        ++compared;
        basis->evaluate(x, row);
        double remainder = 0.0;
        for (std::size_t i = 0; i < row.element.size(); ++i) {
            remainder += std::abs(row.weight[i]) * (sites.points[row.element[i]].position - x.position).squaredNorm();
        }
        EXPECT_LE(std::abs(applied(sites, row, wave) - wave(x.position)), 0.5 * 13.0 * remainder + 1e-13);
    }
    EXPECT_GT(compared, 1980U);
}

/// Root mean square error of `wave` at random points.
double error_of(const std::string& choice, const Mesh& mesh, double spacing) {
    const SiteSet sites = test::poisson_sites(mesh, spacing);
    const auto basis = test::plugin<Basis>(choice);
    basis->bind(mesh, sites);
    BasisRow row;
    double sum = 0.0;
    const auto probes = test::random_points(mesh, 4000, RandomStream(8, "probes"));
    for (const SurfacePoint& x : probes) {
        basis->evaluate(x, row);
        const double miss = applied(sites, row, wave) - wave(x.position);
        sum += miss * miss;
    }
    return std::sqrt(sum / static_cast<double>(probes.size()));
}

TEST(MovingLeastSquares, ConvergesAtSecondOrder) {
    // Down to a quarter of the spacing; the sites are random, which moves the slope by a few hundredths. On a sphere of
    // facets (5120, turned by 3° to each other) the error of the tangent plane is of second order too.
    // (`normalized-radial` has 1.5.)
    for (const bool sphere : {false, true}) {
        const Mesh mesh = sphere ? test::icosphere(4) : test::grid(1, 1);
        const double coarse = sphere ? 0.24 : 0.1, fine = coarse / 4.0;
        const double order =
            std::log(error_of("moving-least-squares", mesh, coarse) / error_of("moving-least-squares", mesh, fine)) /
            std::log(4.0);
        EXPECT_GE(order, 1.9) << (sphere ? "sphere" : "plane");
    }
}

TEST(MovingLeastSquares, FewSitesOrSitesOnALineGiveNoSlopeAcross) {
    const Mesh mesh = test::grid(1, 1);
    const auto at = [&](double x, double y) { return x >= y ? mesh.at(0, x - y, y) : mesh.at(1, x, y - x); };
    const std::vector<SurfacePoint> probes = test::random_points(mesh, 300, RandomStream(5, "probes"));

    const SiteSet one = sites_at(mesh, {at(0.3, 0.4)}, 0.5);
    const auto single = bound_basis(mesh, one);
    BasisRow row;
    for (const SurfacePoint& x : probes) {
        single->evaluate(x, row);
        ASSERT_EQ(row.element.size(), 1U);
        EXPECT_NEAR(row.weight[0], 1.0, 4 * eps);
    }

    // Nine on the line y = ½: what is linear along it is reproduced beside it, what grows across it is its value there.
    std::vector<SurfacePoint> line;
    for (int i = 0; i < 9; ++i) {
        line.push_back(at(0.1 + 0.1 * i, 0.5));
    }
    const SiteSet sites = sites_at(mesh, line, 0.1, 4);
    const auto basis = bound_basis(mesh, sites);
    for (const double y : {0.5, 0.5 + 1e-12, 0.5 - 1e-3, 0.51, 0.58}) {
        basis->evaluate(at(0.53, y), row);
        ASSERT_GE(row.element.size(), 2U);
        EXPECT_NEAR(applied(sites, row, [](const Vec3& p) { return p.x(); }), 0.53, 100 * bound * eps / 0.004);
        EXPECT_NEAR(applied(sites, row, [](const Vec3& p) { return p.y(); }), 0.5, 100 * bound * eps);
    }
}

TEST(MovingLeastSquares, SitesThatMoveOffALineMeetNoStep) {
    // The weights at a point are Lipschitz in the sites' places, through the guards too: where sites move in steps of a
    // quarter, the largest change is a quarter, while a jump would stay what it is.
    const Mesh mesh = test::grid(1, 1);
    const auto at = [&](double x, double y) { return x >= y ? mesh.at(0, x - y, y) : mesh.at(1, x, y - x); };
    constexpr int count = 9;
    /// Weights of nine sites that lie `e` beside the line y = ½ in turns.
    const auto phi = [&](double e, double y) {
        std::vector<SurfacePoint> zigzag;
        for (int i = 0; i < count; ++i) {
            zigzag.push_back(at(0.1 + 0.1 * i, 0.5 + (i % 2 == 0 ? e : -e)));
        }
        const SiteSet sites = sites_at(mesh, zigzag, 0.1, 4);
        const auto basis = bound_basis(mesh, sites);
        BasisRow row;
        basis->evaluate(at(0.53, y), row);
        std::array<double, count> weight{};
        for (std::size_t i = 0; i < row.element.size(); ++i) { // sites are renumbered: named by their x
            weight[static_cast<std::size_t>(std::lround(10 * sites.points[row.element[i]].position.x())) - 1] =
                row.weight[i];
        }
        return weight;
    };
    for (const double y : {0.5, 0.5001, 0.52}) {
        const auto largest_change = [&](int steps) {
            double largest = 0.0;
            auto before = phi(0.0, y);
            for (int step = 1; step <= steps; ++step) {
                const auto now = phi(0.08 * step / steps, y);
                for (std::size_t i = 0; i < count; ++i) {
                    largest = std::max(largest, std::abs(now[i] - before[i]));
                }
                before = now;
            }
            return largest;
        };
        const double coarse = largest_change(100), fine = largest_change(400);
        EXPECT_LE(fine, 0.35 * coarse) << y;
        EXPECT_GT(fine, 0.0) << y;
    }
}

} // namespace
} // namespace difusa::moving_least_squares_test
