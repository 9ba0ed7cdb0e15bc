// Form factors with far triangles in groups against those of all pairs.
#include <difusa/core/error.h>
#include <difusa/form_factors/form_factors.h>
#include <difusa/form_factors/grouped.h>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include <meshes.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace difusa::grouped_form_factors_test {
namespace {

GroupedFormFactors grouped(const Mesh& mesh, double tolerance, unsigned threads = 1) {
    return grouped_form_factors(mesh, {tolerance}, Execution{threads});
}

FormFactors single(const Mesh& mesh, double tolerance) {
    return form_factors(mesh, surfaces_by_face(mesh), {tolerance}, Execution{});
}

/// F_ij from a link, i in a and j in b, or the other way round.
double factor(const GroupedFormFactors& F, const GroupedFormFactors::Link& link, bool from_a, Index i, Index j) {
    const Index in_a = from_a ? i : j, in_b = from_a ? j : i;
    return F.area[j] * link.kernel * (1.0 + link.gradient_a.dot(F.centroid[in_a] - F.groups[link.a].centre)) *
           (1.0 + link.gradient_b.dot(F.centroid[in_b] - F.groups[link.b].centre));
}

/// Calls `visit(link, from_a, i, j)` for each pair of triangles of each link, both ways.
template <class Visit> void for_pairs(const GroupedFormFactors& F, const Visit& visit) {
    for (const GroupedFormFactors::Link& link : F.links) {
        const auto &a = F.groups[link.a], &b = F.groups[link.b];
        for (Index k = a.first; k < a.last; ++k) {
            for (Index l = b.first; l < b.last; ++l) {
                visit(link, true, F.order[k], F.order[l]);
                visit(link, false, F.order[l], F.order[k]);
            }
        }
    }
}

Eigen::MatrixXd matrix_of(const GroupedFormFactors& F) {
    const auto n = static_cast<Eigen::Index>(F.area.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    for_pairs(F, [&](const GroupedFormFactors::Link& link, bool from_a, Index i, Index j) {
        EXPECT_EQ(matrix(i, j), 0.0) << "linked twice: " << i << ", " << j;
        matrix(i, j) += factor(F, link, from_a, i, j);
    });
    return matrix;
}

Eigen::MatrixXd matrix_of(const FormFactors& F) {
    const auto n = static_cast<Eigen::Index>(F.size());
    Eigen::MatrixXd matrix(n, n);
    for (Index i = 0; i < F.size(); ++i) {
        for (Index j = 0; j < F.size(); ++j) {
            matrix(i, j) = F.at(i, j);
        }
    }
    return matrix;
}

Mesh room() {
    return test::box({3, 1, 2}, 6, true);
}

/// The box [-1,1]³ seen from inside around the cube [-1/2,1/2]³ seen from outside.
Mesh room_with_cube(int n) {
    return test::together(test::moved(test::box({2, 2, 2}, n, true), 1.0, Vec3::Constant(-1.0)),
                          test::moved(test::box({1, 1, 1}, n), 1.0, Vec3::Constant(-0.5)));
}

/// Every pair that sees each other is in one link, and no factor is negative. What a triangle has from a group is
/// within the tolerance of the sum of what it has from its triangles.
TEST(GroupedFormFactors, AreThoseOfAllPairsWithinTheTolerance) {
    for (const Mesh& mesh : {room(), room_with_cube(6)}) {
        const Eigen::MatrixXd exact = matrix_of(single(mesh, 1e-5));
        for (const double tolerance : {3e-2, 3e-3}) {
            const GroupedFormFactors F = grouped(mesh, tolerance);
            const Eigen::MatrixXd near = matrix_of(F);
            EXPECT_GE(near.minCoeff(), -1e-15);
            EXPECT_LT((near - exact).cwiseAbs().maxCoeff(), tolerance);
            std::vector<double> off(F.area.size(), 0.0);
            for (const GroupedFormFactors::Link& link : F.links) {
                for (const auto& [from, to] : {std::pair(link.a, link.b), std::pair(link.b, link.a)}) {
                    const auto &a = F.groups[from], &b = F.groups[to];
                    for (Index k = a.first; k < a.last; ++k) {
                        double sum = 0.0;
                        for (Index l = b.first; l < b.last; ++l) {
                            sum += near(F.order[k], F.order[l]) - exact(F.order[k], F.order[l]);
                        }
                        EXPECT_LT(std::abs(sum), tolerance);
                    }
                }
            }
            EXPECT_LT(F.links.size() * 2, static_cast<std::size_t>((exact.array() > 0.0).count()));
        }
    }
}

TEST(GroupedFormFactors, AreReciprocal) {
    const GroupedFormFactors F = grouped(room_with_cube(4), 1e-2);
    const Eigen::MatrixXd near = matrix_of(F);
    const Eigen::Map<const Eigen::VectorXd> area(F.area.data(), near.rows());
    const Eigen::MatrixXd exchange = area.asDiagonal() * near;
    EXPECT_LE((exchange - exchange.transpose()).cwiseAbs().maxCoeff(), 1e-15 * exchange.maxCoeff());
}

TEST(GroupedFormFactors, SumsOfRowsAreThoseOfTheMatrix) {
    const GroupedFormFactors F = grouped(room_with_cube(4), 1e-2);
    const Eigen::VectorXd expected = matrix_of(F).rowwise().sum();
    const std::vector<double> sums = F.row_sums();
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(expected.size());
    for (const GroupedFormFactors::Link& link : F.links) {
        for (const Index g : {link.a, link.b}) {
            for (Index k = F.groups[g].first; k < F.groups[g].last; ++k) {
                errors[F.order[k]] += link.error;
            }
        }
    }
    const std::vector<double> stated = F.row_errors();
    for (Eigen::Index i = 0; i < expected.size(); ++i) {
        EXPECT_NEAR(sums[static_cast<std::size_t>(i)], expected[i], 1e-13);
        EXPECT_NEAR(stated[static_cast<std::size_t>(i)], errors[i], 1e-12);
        EXPECT_LE(std::abs(expected[i] - 1.0), errors[i]);
    }
}

/// Where no group is accurate enough, pairs of triangles are left, whose factors are those of `form_factors`: both
/// integrate each pair in the same way, but perhaps in the other order.
TEST(GroupedFormFactors, OfATightToleranceAreThoseOfPairs) {
    const Mesh mesh = room_with_cube(2);
    const GroupedFormFactors F = grouped(mesh, 1e-5);
    for (const GroupedFormFactors::Link& link : F.links) {
        EXPECT_EQ(F.groups[link.a].right, none);
        EXPECT_EQ(F.groups[link.b].right, none);
    }
    EXPECT_LE((matrix_of(F) - matrix_of(single(mesh, 1e-5))).cwiseAbs().maxCoeff(), 2e-5);
}

/// Four times as many triangles have less than four times as many links: for any accuracy there are groups that need no
/// division, and only those near edges and shadows go on to be divided.
TEST(GroupedFormFactors, AreFewerThanPairs) {
    const auto links = [](int n) { return static_cast<double>(grouped(room_with_cube(n), 3e-2).links.size()); };
    EXPECT_LT(std::log(links(16) / links(8)) / std::log(4.0), 1.0);
}

TEST(GroupedFormFactors, SameBitsForAnyNumberOfThreads) {
    const Mesh mesh = room_with_cube(4);
    const GroupedFormFactors one = grouped(mesh, 1e-2), three = grouped(mesh, 1e-2, 3);
    ASSERT_EQ(one.links.size(), three.links.size());
    for (std::size_t k = 0; k < one.links.size(); ++k) {
        EXPECT_EQ(one.links[k].a, three.links[k].a);
        EXPECT_EQ(one.links[k].b, three.links[k].b);
        EXPECT_EQ(one.links[k].kernel, three.links[k].kernel);
        EXPECT_EQ(one.links[k].gradient_a, three.links[k].gradient_a);
        EXPECT_EQ(one.links[k].error, three.links[k].error);
    }
}

TEST(GroupedFormFactors, OfOnePlateAreNone) {
    EXPECT_TRUE(grouped(test::grid(3, 3, 1.0, 1.0), 1e-3).links.empty());
    EXPECT_THROW(grouped(test::grid(1, 1, 1.0, 1.0), 0.0), UsageError);
}

} // namespace
} // namespace difusa::grouped_form_factors_test
