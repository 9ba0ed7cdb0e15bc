#include <difusa/rays/ring_cells.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace difusa {

DirectionSet through_ring_cells(std::span<const double> border, std::span<const std::size_t> sectors,
                                RandomStream* stream) {
    DIFUSA_REQUIRE(border.size() == sectors.size() + 1 && border.front() == 0.0 && border.back() == 1.0);
    DirectionSet set;
    const auto share = [&] { return stream != nullptr ? stream->uniform() : 0.5; };
    for (std::size_t k = 0; k < sectors.size(); ++k) {
        const auto n = static_cast<double>(sectors[k]);
        for (std::size_t i = 0; i < sectors[k]; ++i) {
            // Strictly inside the disc, so that the direction is strictly above the horizon.
            const double area = std::min(border[k] + share() * (border[k + 1] - border[k]), 1.0 - 0x1p-33);
            const double angle = 2.0 * std::numbers::pi * (static_cast<double>(i) + share()) / n;
            const double radius = std::sqrt(area);
            set.direction.emplace_back(radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1.0 - area));
            set.weight.push_back((border[k + 1] - border[k]) / n);
        }
    }
    return set;
}

} // namespace difusa
