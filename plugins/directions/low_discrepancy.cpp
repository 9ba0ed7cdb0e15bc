// Directions `low-discrepancy`: the first two dimensions of Sobol's sequence, scrambled after Owen, on the unit square,
// then mapped to the disc by the concentric map of Shirley and Chiu (1997) and lifted to the hemisphere: equal weights
// under the cosine (the Nusselt analogue). Powers of two are best: each of their sets puts one direction into every
// elementary interval of its size.
#include <difusa/plugin/plugin.h>
#include <difusa/rays/directions.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace {

/// Owen's nested uniform scrambling: the bit at each depth is flipped or not by a coin that belongs to the bits above.
std::uint32_t scramble(std::uint32_t x, std::uint64_t key) {
    std::uint32_t result = x;
    for (unsigned depth = 0; depth < 32; ++depth) {
        const std::uint64_t above = depth == 0 ? 0 : x >> (32U - depth);
        const std::uint64_t coin = difusa::mix_bits(key ^ difusa::mix_bits((above << 6U) + depth + 1));
        result ^= static_cast<std::uint32_t>(coin & 1U) << (31U - depth);
    }
    return result;
}

/// The centre of the 2^-32 interval: strictly inside (0,1).
double to_unit(std::uint32_t x) {
    return (static_cast<double>(x) + 0.5) * 0x1p-32;
}

difusa::Vec3 lift(double u, double v) {
    const double a = 2.0 * u - 1.0, b = 2.0 * v - 1.0;
    const bool wide = std::abs(a) > std::abs(b);
    const double radius = wide ? a : b;
    const double angle = radius == 0.0 ? 0.0
                         : wide        ? 0.25 * std::numbers::pi * (b / a)
                                       : 0.5 * std::numbers::pi - 0.25 * std::numbers::pi * (a / b);
    const double x = radius * std::cos(angle), y = radius * std::sin(angle);
    return {x, y, std::sqrt(std::max(1.0 - radius * radius, 0.0))};
}

class LowDiscrepancy final : public difusa::Directions {
  public:
    explicit LowDiscrepancy(const difusa::Parameters& /*parameters*/) {
        std::uint32_t v = 1U << 31U;
        for (std::size_t bit = 0; bit < 32; ++bit) {
            first_[bit] = 1U << (31U - bit);
            second_[bit] = v;
            v ^= v >> 1U;
        }
    }

    difusa::DirectionSet make(std::size_t count, difusa::RandomStream stream) const override {
        const std::uint64_t key_u = stream.bits(), key_v = stream.bits();
        difusa::DirectionSet set;
        set.weight.assign(count, 1.0 / static_cast<double>(count));
        set.direction.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            std::uint32_t u = 0, v = 0;
            for (std::size_t bit = 0, rest = i; rest != 0; ++bit, rest >>= 1U) {
                if ((rest & 1U) != 0) {
                    u ^= first_[bit];
                    v ^= second_[bit];
                }
            }
            set.direction.push_back(lift(to_unit(scramble(u, key_u)), to_unit(scramble(v, key_v))));
        }
        return set;
    }

  private:
    std::array<std::uint32_t, 32> first_{}, second_{};
};

} // namespace

DIFUSA_PLUGIN(directions, "low-discrepancy", LowDiscrepancy,
              "Owen-scrambled Sobol points, cosine-weighted; powers of two are best.", {})
