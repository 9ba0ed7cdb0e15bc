#include <difusa/study/references/manufactured.h>

#include <difusa/core/error.h>
#include <difusa/rays/lambert.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace difusa::references_manufactured_test {
namespace {

Vec3 inward(int axis, bool upper) {
    Vec3 n = Vec3::Zero();
    n[axis] = upper ? -1.0 : 1.0;
    return n;
}

/// Points of a face in shares of its sizes, for each face: act(x, n).
void on_all_faces(const Vec3& size, const std::vector<double>& shares,
                  const std::function<void(const Vec3&, const Vec3&)>& act) {
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool upper : {false, true}) {
            for (const double p : shares) {
                for (const double q : shares) {
                    Vec3 x;
                    x[axis] = upper ? size[axis] : 0.0;
                    x[(axis + 1) % 3] = p * size[(axis + 1) % 3];
                    x[(axis + 2) % 3] = q * size[(axis + 2) % 3];
                    act(x, inward(axis, upper));
                }
            }
        }
    }
}

/// K B by n by n patches a face: B in their middles times their exact form factors.
double irradiance_of_patches(const Vec3& size, const ManufacturedBox::Radiosity& B, const Vec3& x, const Vec3& n_x,
                             int n) {
    std::vector<double> middles;
    for (int k = 0; k < n; ++k) {
        middles.push_back((k + 0.5) / n);
    }
    double sum = 0.0;
    on_all_faces(size, middles, [&](const Vec3& y, const Vec3& n_y) {
        if (n_y == n_x) {
            return;
        }
        int axis = 0;
        n_y.cwiseAbs().maxCoeff(&axis);
        Vec3 u = Vec3::Zero(), v = Vec3::Zero();
        u[(axis + 1) % 3] = 0.5 * size[(axis + 1) % 3] / n;
        v[(axis + 2) % 3] = 0.5 * size[(axis + 2) % 3] / n;
        if (n_y[axis] < 0.0) {
            std::swap(u, v); // counterclockwise seen from inside
        }
        sum += B(y, n_y) * (lambert_form_factor(x, n_x, y - u - v, y + u - v, y + u + v) +
                            lambert_form_factor(x, n_x, y - u - v, y + u + v, y - u + v));
    });
    return sum;
}

/// A constant in a closed box arrives as that constant everywhere, on edges and corners too, flat or long as it may be.
TEST(ManufacturedBox, AConstantIsAFurnace) {
    for (const Vec3& size :
         {Vec3(1, 1, 1), Vec3(1, 2, 3), Vec3(1000, 1, 1), Vec3(1000, 1000, 1), Vec3(3e-7, 2e-7, 1e-7)}) {
        const ManufacturedBox box(
            size, 0.6, [](const Vec3&, const Vec3&) { return 5.0; }, 1e-6);
        on_all_faces(size, {0.0, 1e-12, 1e-3, 0.4, 1.0}, [&](const Vec3& x, const Vec3& n) {
            const ReferenceLight light = box.at(x, n);
            EXPECT_NEAR(light.H, 5.0, 5e-6) << size.transpose() << ": " << x.transpose();
            EXPECT_NEAR(light.E, 2.0, 3e-6);
            EXPECT_NEAR(light.B(), 5.0, 1e-14);
        });
    }
}

/// Patches with their exact form factors converge to it with second order.
TEST(ManufacturedBox, AgreesWithPatches) {
    const Vec3 size(1.0, 0.7, 1.3);
    const auto B = ManufacturedBox::waves(size, 2.0, 0.3, 1.0);
    const ManufacturedBox box(size, 0.5, B, 1e-8);
    double error[3] = {0.0, 0.0, 0.0};
    on_all_faces(size, {0.25, 0.4, 0.8}, [&](const Vec3& x, const Vec3& n) {
        const double H = box.at(x, n).H;
        for (int k = 0; k < 3; ++k) {
            error[k] = std::max(error[k], std::abs(irradiance_of_patches(size, B, x, n, 6 << k) - H));
        }
    });
    // To a quarter; less than a third and more than a fifth would be no other order.
    EXPECT_LT(error[1], error[0] / 3.0);
    EXPECT_LT(error[2], error[1] / 3.0);
    EXPECT_GT(error[2], error[1] / 5.0);
}

/// A B that jumps over the edges: two faces of 1, all else 0, so H is a form factor known by Lambert's formula.
TEST(ManufacturedBox, LitFacesAgainstLambertsFormula) {
    const Vec3 size(2.0, 1.0, 0.5);
    const auto lit = [&](const Vec3& n_lit) {
        return [n_lit](const Vec3&, const Vec3& n) { return n == n_lit ? 1.0 : 0.0; };
    };
    for (const Vec3& n_lit : {Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(0, -1, 0)}) {
        const auto B = lit(n_lit);
        const ManufacturedBox box(size, 0.0, B, 1e-8);
        on_all_faces(size, {1e-9, 1e-4, 0.1, 0.6, 0.9999}, [&](const Vec3& x, const Vec3& n) {
            // One patch a face: exact for a constant. Rounding of x blurs the direction of a face 1e-9 away by 1e-7.
            EXPECT_NEAR(box.at(x, n).H, n == n_lit ? 0.0 : irradiance_of_patches(size, B, x, n, 1), 1e-7);
        });
    }
}

/// Of faces with a common edge each sends half of its radiosity there to the other, near the edge.
TEST(ManufacturedBox, OnAnEdgeTheNeighbourFillsHalfOfTheView) {
    const Vec3 size(1.0, 2.0, 3.0);
    const ManufacturedBox box(
        size, 0.0, [](const Vec3& x, const Vec3& n) { return n.x() > 0.0 ? std::exp(x.y() + x.z()) : 0.0; }, 1e-9);
    EXPECT_NEAR(box.at(Vec3(0.0, 0.5, 0.0), Vec3::UnitZ()).H, 0.5 * std::exp(0.5), 1e-8);
    // On the bisector of a corner the two walls, alike, fill all of the view but the quarter between them.
    EXPECT_NEAR(box.at(Vec3(0.0, 0.0, 3.0), -Vec3::UnitZ()).H, 0.375 * std::exp(3.0), 1e-8);
}

/// In a closed box nothing is lost: ∫ K B dA = ∫ B dA, whatever B.
TEST(ManufacturedBox, NothingIsLost) {
    const Vec3 size(1.0, 0.8, 1.5);
    const auto B = [](const Vec3& x, const Vec3&) { return std::exp(0.5 * x.x() - 0.3 * x.y() + 0.2 * x.z()); };
    const ManufacturedBox box(size, 0.1, B, 1e-7);
    const auto lost = [&](std::size_t nodes) {
        const QuadratureRule rule = gauss_legendre(nodes);
        double received = 0.0, sent = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            const int i = (axis + 1) % 3, j = (axis + 2) % 3;
            for (const bool upper : {false, true}) {
                Vec3 x;
                x[axis] = upper ? size[axis] : 0.0;
                for_each_node(rule, 0.0, size[i], [&](double p, double weight_p) {
                    for_each_node(rule, 0.0, size[j], [&](double q, double weight_q) {
                        x[i] = p;
                        x[j] = q;
                        const Vec3 n = inward(axis, upper);
                        received += weight_p * weight_q * box.at(x, n).H;
                        sent += weight_p * weight_q * B(x, n);
                    });
                });
            }
        }
        return std::abs(received / sent - 1.0);
    };
    // K B is like x log x near the edges, which the nodes of for_each_node, quadratic there, meet with fourth order.
    const double coarse = lost(6), fine = lost(12);
    EXPECT_LT(fine, coarse / 8.0);
    EXPECT_LT(fine, 1e-5);
}

TEST(ManufacturedBox, TheEstimateBoundsTheError) {
    const Vec3 size(1.0, 1.0, 1.0);
    const auto B = ManufacturedBox::waves(size, 3.0, 0.5, 2.0);
    const ManufacturedBox coarse(size, 0.5, B, 1e-4), fine(size, 0.5, B, 1e-9);
    EXPECT_GT(coarse.error_estimate(), fine.error_estimate());
    EXPECT_LE(fine.error_estimate(), 1e-9 * 3.5);
    on_all_faces(size, {0.0, 1e-6, 0.2, 0.5, 1.0},
                 [&](const Vec3& x, const Vec3& n) { EXPECT_NEAR(coarse.at(x, n).H, fine.at(x, n).H, 1e-4 * 3.5); });
}

TEST(ManufacturedBox, EmissionIsNeverNegative) {
    const Vec3 size(1, 2, 1);
    // The bound of `waves`: 2 (1 - 1/2) = (2/3) (1 + 1/2).
    const ManufacturedBox box(size, 0.5, ManufacturedBox::waves(size, 2.0, 2.0 / 3.0, 1.0), 1e-4);
    EXPECT_GE(box.least_emission(), 0.0);
    EXPECT_THROW(ManufacturedBox(size, 0.9, ManufacturedBox::waves(size, 1.0, 0.9, 1.0), 1e-4), UsageError);
}

TEST(ManufacturedBox, BadParametersAreRefused) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto one = [](const Vec3&, const Vec3&) { return 1.0; };
    EXPECT_THROW(ManufacturedBox(Vec3(1, 0, 1), 0.5, one), UsageError);
    EXPECT_THROW(ManufacturedBox(Vec3(1, nan, 1), 0.5, one), UsageError);
    EXPECT_THROW(ManufacturedBox(Vec3(1, 1, 1), 1.5, one), UsageError);
    EXPECT_THROW(ManufacturedBox(Vec3(1, 1, 1), 0.5, one, 1e-13), UsageError);
    EXPECT_THROW(ManufacturedBox(Vec3(1, 1, 1), 0.5, [nan](const Vec3&, const Vec3&) { return nan; }), UsageError);
    EXPECT_THROW(
        ManufacturedBox(Vec3(1, 1, 1), 0.1, [](const Vec3& x, const Vec3&) { return x.x() > 0.3 ? 2.0 : 1.0; }),
        NotConverged);
    const ManufacturedBox box(Vec3(1, 2, 3), 0.5, one, 1e-3);
    EXPECT_THROW(box.at(Vec3(0.5, 0.5, 0.5), Vec3::UnitZ()), UsageError);
    EXPECT_THROW(box.at(Vec3(0.5, 0.5, 0.0), -Vec3::UnitZ()), UsageError);
    EXPECT_THROW(box.at(Vec3(nan, 0.5, 0.0), Vec3::UnitZ()), UsageError);
    EXPECT_NO_THROW(box.at(Vec3(1.0000001, 0.5, -1e-7), Vec3::UnitZ()));
}

} // namespace
} // namespace difusa::references_manufactured_test
