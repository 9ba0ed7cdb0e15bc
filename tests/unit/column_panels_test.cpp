#include <difusa/algebra/column_panels.h>

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace {

using namespace difusa;

/// Where panels begin, and how wide they are.
using Panels = std::vector<std::pair<Eigen::Index, int>>;

Panels panels_of(Eigen::Index width) {
    Panels panels;
    for_panels<24, 8, 3, 1>(width, [&](auto size, Eigen::Index first) { panels.emplace_back(first, size); });
    return panels;
}

TEST(ColumnPanels, CoverAllColumnsInOrder) {
    for (Eigen::Index width = 0; width < 200; ++width) {
        Eigen::Index covered = 0;
        for (const auto& [first, size] : panels_of(width)) {
            EXPECT_GE(first, 0);
            EXPECT_LE(first, covered) << width;
            EXPECT_GT(first + size, covered) << width;
            covered = first + size;
        }
        EXPECT_EQ(covered, width);
    }
}

TEST(ColumnPanels, AreAsWideAsTheyFit) {
    EXPECT_EQ(panels_of(59), (Panels{{0, 24}, {24, 24}, {48, 8}, {56, 3}}));
    EXPECT_EQ(panels_of(13), (Panels{{0, 8}, {5, 8}}));
    EXPECT_EQ(panels_of(4), (Panels{{0, 3}, {3, 1}}));
}

/// Instead of 8, 3 and 1 after three of 24.
TEST(ColumnPanels, TakeTheRestAtOnceIfItFillsHalfOfOne) {
    EXPECT_EQ(panels_of(72 + 13), (Panels{{0, 24}, {24, 24}, {48, 24}, {61, 24}}));
    EXPECT_EQ(panels_of(24 + 12), (Panels{{0, 24}, {12, 24}}));
    EXPECT_EQ(panels_of(24 + 4), (Panels{{0, 24}, {20, 8}}));
    EXPECT_EQ(panels_of(24 + 9), (Panels{{0, 24}, {24, 8}, {32, 1}}));
}

} // namespace
