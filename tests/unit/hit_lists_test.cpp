#include <difusa/algebra/hit_lists.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace difusa::hit_lists_test {
namespace {

using Rows = std::vector<std::vector<Index>>;

HitLists lists_of(const Rows& rows, std::size_t columns, std::size_t rays, std::size_t rows_per_block = 4) {
    HitLists lists(rows.size(), columns, rays, rows_per_block);
    for (std::size_t j = 0; j < rows.size(); ++j) {
        std::vector<Index> bins = rows[j];
        lists.set(j, bins);
        if ((j + 1) % rows_per_block == 0 || j + 1 == rows.size()) {
            lists.close_block(j / rows_per_block * rows_per_block);
        }
    }
    return lists;
}

void expect_same(const HitLists& lists, const Rows& rows) {
    ASSERT_EQ(lists.rows(), rows.size());
    std::vector<Index> got;
    for (std::size_t j = 0; j < rows.size(); ++j) {
        std::vector<Index> expected = rows[j];
        std::sort(expected.begin(), expected.end());
        lists.row(j, got);
        ASSERT_EQ(got, expected) << "row " << j;
    }
}

/// Up to `rays` bins a row below `columns`, some rows with many equal ones.
Rows random_rows(std::size_t count, std::size_t columns, std::size_t rays, RandomStream& random) {
    Rows rows(count);
    for (std::vector<Index>& row : rows) {
        const std::size_t size = random.below(rays + 1);
        const std::size_t different = 1 + random.below(columns);
        for (std::size_t k = 0; k < size; ++k) {
            row.push_back(static_cast<Index>(random.below(different)));
        }
    }
    return rows;
}

constexpr std::size_t most_columns = none - 1;

TEST(HitLists, RowsComeBackAsSortedLists) {
    constexpr auto last = static_cast<Index>(most_columns - 1);
    Rows rows{{},        {0},
              {last},    {0, last},
              {last, 0}, std::vector<Index>(64, 7),
              {},        std::vector<Index>(64, last),
              {5, 4, 3}, {0, 0, 0, last, last}};
    // Next to nothing between the bins, and then a gap that takes an escape code.
    rows.emplace_back();
    for (Index k = 0; k < 62; ++k) {
        rows.back().push_back(k);
    }
    rows.back().push_back(last - 1);
    rows.back().push_back(last);
    // Gaps of one below, of and one above each power of two.
    rows.emplace_back();
    for (unsigned bit = 1, at = 0; bit < 31; bit += 2) {
        at += (1U << bit) - 1;
        rows.back().push_back(at);
    }
    for (unsigned bit = 0; bit < 32; ++bit) {
        rows.push_back({(1U << bit) - 1, 1U << bit, (1U << bit) + 1});
    }
    for (const std::size_t block : {1U, 3U, 64U, 1000U}) {
        expect_same(lists_of(rows, most_columns, 64, block), rows);
    }
}

TEST(HitLists, RandomRowsComeBack) {
    RandomStream random(1, "rows");
    for (const std::size_t columns : {std::size_t{1}, std::size_t{2}, std::size_t{1000}, std::size_t{1} << 20U,
                                      std::size_t{1} << 31U, most_columns}) {
        for (const std::size_t rays : {1U, 16U, 500U}) {
            const Rows rows = random_rows(70, columns, rays, random);
            expect_same(lists_of(rows, columns, rays), rows);
        }
    }
}

Values random_values(std::size_t rows, Eigen::Index columns, RandomStream& random) {
    Values x(static_cast<Eigen::Index>(rows), columns);
    for (double& value : x.reshaped()) {
        value = random.uniform() - 0.5;
    }
    return x;
}

TEST(HitLists, MultiplyLikeADenseMatrixWithTheSameBitsForAnyThreads) {
    constexpr std::size_t count = 301, columns = 77, rays = 50;
    RandomStream random(2, "rows");
    const Rows rows = random_rows(count, columns, rays, random);
    const HitLists W = lists_of(rows, columns, rays, 16);
    EXPECT_EQ(W.columns(), columns);
    EXPECT_EQ(W.rays(), rays);
    EXPECT_EQ(W.entries(), nullptr);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(count, columns);
    for (std::size_t j = 0; j < count; ++j) {
        for (const Index bin : rows[j]) {
            dense(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(bin)) += 1.0 / rays;
        }
    }
    for (const Eigen::Index width : {1, 2, 3, 7, 9, 21, 24, 46, 61, 148, 340}) {
        const Values x = random_values(columns, width, random), y = random_values(count, width, random);
        Values Wx, Wty;
        W.apply(x, Wx, Execution{});
        W.apply_transpose(y, Wty, Execution{});
        // Sums of at most 50 terms of 1/100 each, and of as many as there are rays in a column: 15050/77, and many more
        // in the first ones.
        EXPECT_LT((Wx - dense * x).cwiseAbs().maxCoeff(), 50 * 0x1p-53);
        EXPECT_LT((Wty - dense.transpose() * y).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_NEAR(y.cwiseProduct(Wx).sum(), Wty.cwiseProduct(x).sum(), 1e-12 * static_cast<double>(width));
        for (Eigen::Index c = 0; c < width; ++c) { // whatever columns are beside it
            Values alone;
            W.apply(x.col(c), alone, Execution{});
            EXPECT_EQ(alone, Wx.col(c));
        }
        for (const unsigned threads : {2U, 3U, 8U}) {
            Values z;
            W.apply(x, z, Execution{threads});
            EXPECT_EQ(z, Wx);
            W.apply_transpose(y, z, Execution{threads});
            EXPECT_EQ(z, Wty);
        }
    }
}

/// Runs of eight hits of a row are added up in single precision: with seven additions, each with a relative error of at
/// most 2^-24, which makes less than 8 2^-24 times the largest number in the mean over the rays. Neither threads, and
/// with them blocks, nor other columns change a bit.
TEST(HitLists, SinglePrecisionIsThatOfShortSums) {
    constexpr std::size_t count = 301, columns = 7777, rays = 300;
    RandomStream random(6, "single");
    const HitLists W = lists_of(random_rows(count, columns, rays, random), columns, rays, 16);
    EXPECT_TRUE(W.prefers_single());
    for (const Eigen::Index width : {1, 3, 24, 47, 48, 61, 192, 340}) {
        const SingleValues x = random_values(columns, width, random).cast<float>();
        Values expected, y, z;
        W.apply(x.cast<double>(), expected, Execution{});
        W.apply_single(x, y, Execution{});
        EXPECT_LE((y - expected).cwiseAbs().maxCoeff(), 8 * 0x1p-24 * x.cwiseAbs().maxCoeff()) << width;
        for (const unsigned threads : {2U, 3U, 8U}) {
            W.apply_single(x, z, Execution{threads});
            EXPECT_EQ(z, y) << width;
        }
        W.apply_single(x.col(0), z, Execution{});
        EXPECT_EQ(z, y.col(0)) << width;
    }
}

/// 2^14 times this number needs more digits than single precision has, eight times it does not.
TEST(HitLists, SinglePrecisionEndsAtRuns) {
    constexpr std::size_t rays = std::size_t{1} << 14U;
    const float value = 1.0F + 0x1p-20F;
    for (const Eigen::Index width : {1, 48}) {
        Values y;
        lists_of({std::vector<Index>(rays, Index{5})}, 8, rays)
            .apply_single(SingleValues::Constant(8, width, value), y, Execution{});
        EXPECT_EQ(y, Values::Constant(1, width, static_cast<double>(value)));
    }
}

/// Whole numbers of rays: constants come through exactly where all rays of a point ended in bins.
TEST(HitLists, ConstantsComeThroughExactly) {
    RandomStream random(3, "rows");
    constexpr std::size_t rays = 1024;
    Rows rows(20);
    for (std::vector<Index>& row : rows) {
        for (std::size_t k = 0; k < rays; ++k) {
            row.push_back(static_cast<Index>(random.below(5000)));
        }
    }
    Values h;
    lists_of(rows, 5000, rays).apply(Values::Constant(5000, 3, 0.75), h, Execution{});
    EXPECT_EQ(h, Values::Constant(20, 3, 0.75));
}

/// Rays that end in bins at random leave gaps that are distributed geometrically, with the mean m = columns / rays. A
/// Rice code of parameter r takes 1 + r bits and one more for each 2^r in the gap; with 2^r between 0.69 m and 1.38 m
/// that is less than log2(m) + 1.9 bits (1 + log2 x + 1 / (e^x - 1) for x = 2^r / m), and never less than the entropy,
/// log2(m) + 1.44.
TEST(HitLists, TakeLittleMoreThanTheEntropyOfTheirGaps) {
    RandomStream random(4, "rows");
    constexpr std::size_t rays = 512, count = 64;
    for (const std::size_t columns : {std::size_t{2048}, std::size_t{20'000}, std::size_t{700'000}, most_columns}) {
        Rows rows(count);
        for (std::vector<Index>& row : rows) {
            for (std::size_t k = 0; k < rays; ++k) {
                row.push_back(static_cast<Index>(random.below(columns)));
            }
        }
        const HitLists lists = lists_of(rows, columns, rays, 16);
        const double m = static_cast<double>(columns) / rays;
        // A row has 5 bytes of its own, 4 more to find it and up to one that is not full; a block 64 and 8 of slack.
        const double overhead = count * 10.0 + 4 * (64.0 + 8.0);
        const double bytes = static_cast<double>(lists.bytes()) - overhead;
        EXPECT_LE(bytes, count * rays * (std::log2(m) + 1.9) / 8.0) << columns;
        EXPECT_GE(bytes, count * rays * (std::log2(m) + 1.3) / 8.0) << columns;
    }
}

TEST(HitLists, EmptyOnesAreNoSpecialCase) {
    const HitLists nothing(0, 10, 1, 4);
    Values y;
    nothing.apply(Values::Ones(10, 3), y, Execution{});
    EXPECT_EQ(y.rows(), 0);
    nothing.apply_transpose(Values(0, 3), y, Execution{});
    EXPECT_EQ(y, Values::Zero(10, 3));
}

TEST(HitLists, ComeBackFromTheirPackedForm) {
    RandomStream random(5, "packed");
    for (const std::size_t columns : {std::size_t{1}, std::size_t{300}, most_columns}) {
        for (const std::size_t count : {0, 1, 4, 37}) {
            const HitLists lists = lists_of(random_rows(count, columns, 48, random), columns, 48);
            const HitLists::Packed packed = lists.packed();
            EXPECT_EQ(packed.codes.size(), lists.code_bytes());
            const HitLists again(packed, Execution{2, nullptr, nullptr});
            EXPECT_EQ(again.columns(), lists.columns());
            EXPECT_EQ(again.rays(), lists.rays());
            ASSERT_EQ(again.rows(), lists.rows());
            std::vector<Index> bins, others;
            for (std::size_t j = 0; j < lists.rows(); ++j) {
                lists.row(j, bins);
                again.row(j, others);
                EXPECT_EQ(bins, others);
            }
            EXPECT_EQ(again.packed().codes, packed.codes);
            EXPECT_EQ(again.packed().row_bytes, packed.row_bytes);
        }
    }
}

/// Whatever the bytes are: either they are refused, or the rows are lists of bins that exist.
TEST(HitLists, DamagedCodesAreRefusedOrSound) {
    RandomStream random(6, "damaged");
    constexpr std::size_t columns = 500, rays = 32;
    const HitLists::Packed packed = lists_of(random_rows(20, columns, rays, random), columns, rays).packed();
    std::size_t refused = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        HitLists::Packed damaged = packed;
        for (std::uint64_t k = 0; k <= random.below(3); ++k) {
            damaged.codes[random.below(damaged.codes.size())] = static_cast<std::uint8_t>(random.below(256));
        }
        if (trial % 4 == 0) { // one byte of a row given to the next one
            const std::size_t j = random.below(19);
            --damaged.row_bytes[j];
            ++damaged.row_bytes[j + 1];
        }
        try {
            const HitLists lists(damaged, Execution{});
            std::vector<Index> bins;
            for (std::size_t j = 0; j < lists.rows(); ++j) {
                lists.row(j, bins);
                ASSERT_LE(bins.size(), rays);
                ASSERT_TRUE(std::is_sorted(bins.begin(), bins.end()));
                ASSERT_TRUE(bins.empty() || bins.back() < columns);
            }
        } catch (const InputError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 500U);
}

TEST(HitLists, SizesThatDoNotAddUpAreRefused) {
    const HitLists::Packed packed = lists_of({{1, 2}, {3}}, 9, 4).packed();
    const auto refused = [&](const auto& damage) {
        HitLists::Packed damaged = packed;
        damage(damaged);
        EXPECT_THROW(HitLists(damaged, Execution{}), InputError);
    };
    refused([](HitLists::Packed& p) { p.rays = 0; });
    refused([](HitLists::Packed& p) { p.rays = 1; });
    refused([](HitLists::Packed& p) { p.columns = 3; });
    refused([](HitLists::Packed& p) { p.columns = none; });
    refused([](HitLists::Packed& p) { p.rows_per_block = 0; });
    refused([](HitLists::Packed& p) { p.codes.pop_back(); });
    refused([](HitLists::Packed& p) { p.row_bytes.push_back(1); });
    refused([](HitLists::Packed& p) { p.codes[4] = 32; });
}

} // namespace
} // namespace difusa::hit_lists_test
