#include <difusa/core/random.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

namespace difusa::random_test {
namespace {

/// Pearson's statistic of equally likely bins has mean k-1 and variance 2 (k-1); a fair generator exceeds the mean by
/// 6 standard deviations in fewer than one of a million tests, and seeds here are fixed.
void expect_fair(const std::vector<int>& counts, int draws) {
    const double expected = static_cast<double>(draws) / static_cast<double>(counts.size());
    double statistic = 0.0;
    for (const int count : counts) {
        statistic += (count - expected) * (count - expected) / expected;
    }
    const double freedom = static_cast<double>(counts.size()) - 1.0;
    EXPECT_LT(statistic, freedom + 6.0 * std::sqrt(2.0 * freedom));
    EXPECT_GT(statistic, freedom - 6.0 * std::sqrt(2.0 * freedom));
}

TEST(Random, AStreamIsNamedBySeedPurposeAndIndex) {
    RandomStream a(5, "sites", 3), b(5, "sites", 3);
    for (int i = 0; i < 100; ++i) {
        EXPECT_EQ(a.bits(), b.bits());
    }
    std::set<std::uint64_t> first;
    std::size_t streams = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        for (const char* purpose : {"", "a", "b", "ab", "ba", "sites", "site"}) {
            for (std::uint64_t index = 0; index < 50; ++index) {
                first.insert(RandomStream(seed, purpose, index).bits());
                ++streams;
            }
        }
    }
    EXPECT_EQ(first.size(), streams);
}

TEST(Random, UniformIsFairAndInTheHalfOpenInterval) {
    RandomStream random(1, "test");
    constexpr int draws = 100'000;
    std::vector<int> counts(64, 0);
    for (int i = 0; i < draws; ++i) {
        const double x = random.uniform();
        ASSERT_GE(x, 0.0);
        ASSERT_LT(x, 1.0);
        ASSERT_EQ(x * 0x1p53, std::floor(x * 0x1p53));
        ++counts[static_cast<std::size_t>(64.0 * x)];
    }
    expect_fair(counts, draws);
}

TEST(Random, BelowIsFairForAnyCount) {
    for (const std::uint64_t count : {1ULL, 2ULL, 3ULL, 7ULL, 100ULL}) {
        RandomStream random(2, "test", count);
        constexpr int draws = 50'000;
        std::vector<int> counts(count, 0);
        for (int i = 0; i < draws; ++i) {
            const std::uint64_t x = random.below(count);
            ASSERT_LT(x, count);
            ++counts[x];
        }
        if (count > 1) {
            expect_fair(counts, draws);
        }
    }
    // A count that does not divide 2^64 by far: without rejection the lower third would come twice as often.
    constexpr std::uint64_t large = (std::uint64_t{1} << 63U) + (std::uint64_t{1} << 62U);
    RandomStream random(3, "test");
    std::vector<int> thirds(3, 0);
    for (int i = 0; i < 30'000; ++i) {
        const std::uint64_t x = random.below(large);
        ASSERT_LT(x, large);
        ++thirds[x / (large / 3)];
    }
    expect_fair(thirds, 30'000);
}

TEST(Random, NeighbouringStreamsAreNotCorrelated) {
    // Products of independent centred uniforms have mean 0 and variance 1/144.
    double sum = 0.0;
    constexpr int pairs = 40'000;
    for (std::uint64_t i = 0; i < pairs; ++i) {
        RandomStream a(1, "test", i), b(1, "test", i + 1);
        sum += (a.uniform() - 0.5) * (b.uniform() - 0.5);
    }
    EXPECT_LT(std::abs(sum), 6.0 * std::sqrt(pairs / 144.0));
}

TEST(Random, MixingLosesNothing) {
    std::set<std::uint64_t> images;
    for (std::uint64_t x = 0; x < 1U << 14U; ++x) {
        images.insert(mix_bits(x));
        images.insert(mix_bits(x << 50U | 1U << 20U));
    }
    EXPECT_EQ(images.size(), (std::size_t{2} << 14U));
}

} // namespace
} // namespace difusa::random_test
