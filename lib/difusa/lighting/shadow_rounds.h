// How many rounds of shadow rays a light with an extent gets.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace difusa {

/// Shadow rays are cast in rounds, each evenly over the light: first pilots, which decide how many rounds follow, then
/// these, of which alone the visible share is the mean. Were pilots counted, or the rounds stopped as soon as some agree,
/// the mean would be biased: where a small part of the light is in sight, rounds that see nothing agree.
struct ShadowRounds {
    static constexpr std::size_t most = 15; ///< that follow

    /// `penumbra`: whether the pilots saw some of the light but not all; `least`: rounds that follow in any case.
    static std::size_t after(bool penumbra, std::size_t least) { return penumbra ? most : least; }

    /// What got through of the light of a round, or of all that count.
    struct Seen {
        double seen = 0.0, all = 0.0;
        bool is_penumbra() const { return seen > 0.0 && seen < all; }
        double share() const { return all > 0.0 ? seen / all : 0.0; }
    };
};

/// How far the share that is the mean of rounds may be off.
class ShareNoise {
  public:
    void add(double share) {
        ++rounds_;
        sum_ += share;
        squares_ += share * share;
    }

    /// The variance of the mean. Rounds continue one even sequence, so that it falls as their number to the power -1.5
    /// (measured: integrands have jumps); of a single round it is that of independent rays.
    double variance(std::size_t rays_per_round) const {
        const auto n = static_cast<double>(rounds_);
        if (rounds_ < 2) {
            return sum_ * (1.0 - sum_) / static_cast<double>(rays_per_round);
        }
        return std::max(0.0, squares_ - sum_ * sum_ / n) / (n - 1.0) * std::pow(n, -1.5);
    }

  private:
    std::size_t rounds_ = 0;
    double sum_ = 0.0, squares_ = 0.0;
};

} // namespace difusa
