#include <difusa/algebra/sparse_rows.h>
#include <difusa/core/error.h>
#include <difusa/core/random.h>

#include <gtest/gtest.h>

#include <cmath>

namespace difusa::sparse_rows_test {
namespace {

TEST(SparseRows, MultipliesLikeADenseMatrixWithTheSameBitsForAnyThreads) {
    RandomStream random(2, "test");
    constexpr Eigen::Index rows = 301, columns = 77;
    SparseRows A(rows, columns);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(rows, columns);
    std::size_t nonzeros = 0;
    for (Eigen::Index i = 0; i < rows; ++i) {
        for (Eigen::Index j = 0; j < columns; ++j) {
            if (i != 5 && random.uniform() < 0.3) {
                dense(i, j) = random.uniform() - 0.5;
                A.row(static_cast<std::size_t>(i)).column.push_back(static_cast<Index>(j));
                A.row(static_cast<std::size_t>(i)).value.push_back(dense(i, j));
                ++nonzeros;
            }
        }
    }
    EXPECT_EQ(A.nonzeros(), nonzeros);
    EXPECT_EQ(A.rows(), 301U);
    EXPECT_EQ(A.columns(), 77U);
    for (const Eigen::Index channels : {1, 3}) {
        Values x(columns, channels);
        for (double& value : x.reshaped()) {
            value = random.uniform() - 0.5;
        }
        Values y;
        A.apply(x, y, Execution{});
        EXPECT_LT((y - dense * x).cwiseAbs().maxCoeff(), 1e-14);
        EXPECT_EQ(y.row(5).norm(), 0.0) << "an empty row";
        for (const unsigned threads : {2U, 3U, 8U}) {
            Values z;
            A.apply(x, z, Execution{threads, nullptr});
            EXPECT_EQ(y, z);
        }
        Values w(rows, channels), adjoint;
        for (double& value : w.reshaped()) {
            value = random.uniform() - 0.5;
        }
        A.apply_transpose(w, adjoint, Execution{});
        EXPECT_LT((adjoint - dense.transpose() * w).cwiseAbs().maxCoeff(), 1e-14);
        for (const unsigned threads : {2U, 3U, 8U}) {
            Values z;
            A.apply_transpose(w, z, Execution{threads, nullptr});
            EXPECT_EQ(adjoint, z);
        }
    }
}

TEST(SparseRows, ComeBackFromTheirPackedFormUnlessItIsUnsound) {
    SparseRows A(3, 5);
    A.row(0) = {{0, 4}, {1.5, -2.0}};
    A.row(2) = {{3}, {0.25}};
    const SparseRows::Packed packed = A.packed();
    const SparseRows B(packed);
    EXPECT_EQ(B.rows(), 3U);
    EXPECT_EQ(B.columns(), 5U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(A.row(i).column, B.row(i).column);
        EXPECT_EQ(A.row(i).value, B.row(i).value);
    }
    const auto refused = [&](const auto& damage) {
        SparseRows::Packed damaged = packed;
        damage(damaged);
        EXPECT_THROW(SparseRows{damaged}, InputError);
    };
    refused([](SparseRows::Packed& p) { p.column[1] = 0; });
    refused([](SparseRows::Packed& p) { p.column[2] = 5; });
    refused([](SparseRows::Packed& p) { p.value[0] = NAN; });
    refused([](SparseRows::Packed& p) { p.value.pop_back(); });
    refused([](SparseRows::Packed& p) { p.row_entries[1] = 1; });
}

} // namespace
} // namespace difusa::sparse_rows_test
