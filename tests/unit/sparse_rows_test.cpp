#include <difusa/algebra/sparse_rows.h>
#include <difusa/core/random.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace difusa {
namespace {

TEST(RowAccumulator, GivesSumsSortedAndStartsAnew) {
    RandomStream random(1, "test");
    for (const std::size_t columns : {1U, 63U, 64U, 65U, 5000U}) {
        RowAccumulator sums(columns);
        for (int round = 0; round < 4; ++round) {
            std::map<Index, double> expected;
            for (int i = 0; i < 200; ++i) {
                const auto column = static_cast<Index>(random.below(columns));
                const double value = static_cast<double>(random.below(64)) - 20.0; // sums are exact
                expected[column] += value;
                sums.add(column, value);
            }
            std::erase_if(expected, [](const auto& entry) { return entry.second == 0.0; }); // sums of 0 are no entries
            SparseRows::Row row;
            sums.take(row);
            ASSERT_EQ(row.column.size(), expected.size());
            ASSERT_EQ(row.value.size(), expected.size());
            std::size_t k = 0;
            for (const auto& [column, value] : expected) {
                EXPECT_EQ(row.column[k], column);
                EXPECT_EQ(row.value[k], value);
                ++k;
            }
            sums.take(row);
            EXPECT_TRUE(row.column.empty() && row.value.empty());
        }
    }
}

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
        A.multiply(x, y, Execution{});
        EXPECT_LT((y - dense * x).cwiseAbs().maxCoeff(), 1e-14);
        EXPECT_EQ(y.row(5).norm(), 0.0) << "an empty row";
        for (const unsigned threads : {2U, 3U, 8U}) {
            Values z;
            A.multiply(x, z, Execution{threads, nullptr});
            EXPECT_EQ(y, z);
        }
    }
    EXPECT_NEAR(A.row_sum(7), dense.row(7).sum(), 1e-14);
}

} // namespace
} // namespace difusa
