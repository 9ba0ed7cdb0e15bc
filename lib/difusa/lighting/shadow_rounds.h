// How many rounds of shadow rays a light with an extent gets.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace difusa {

/// What got through of the light of some shadow rays.
struct LightSeen {
    double seen = 0.0, all = 0.0;
    double share() const { return all > 0.0 ? seen / all : 0.0; }
    void add(const LightSeen& other) {
        seen += other.seen;
        all += other.all;
    }
};

/// How far shares that rounds of equal size saw differ. Rounds continue one even sequence, so that the variance of
/// their mean falls as their number to the power -1.5 (measured: integrands have jumps).
class ShareNoise {
  public:
    void add(double share) {
        ++rounds_;
        sum_ += share;
        squares_ += share * share;
    }

    /// Of so many rounds as one: also of more or less than there are. 0 if fewer than two are known.
    double variance_of(double rounds) const {
        const auto n = static_cast<double>(rounds_);
        return rounds_ < 2 ? 0.0 : std::max(0.0, squares_ - sum_ * sum_ / n) / (n - 1.0) * std::pow(rounds, of_rounds);
    }

    /// Of the mean of them all; of a single round, that of as many independent rays.
    double variance(std::size_t rays_per_round) const {
        return rounds_ < 2 ? sum_ * (1.0 - sum_) / static_cast<double>(rays_per_round)
                           : variance_of(static_cast<double>(rounds_));
    }

    static constexpr double of_rounds = -1.5;

  private:
    std::size_t rounds_ = 0;
    double sum_ = 0.0, squares_ = 0.0;
};

/// Shadow rays are cast in rounds, each evenly over the light: first small pilots, which decide how many rounds follow,
/// then these, of which alone the visible share is the mean. Were pilots counted, or the rounds ended as soon as some
/// agree, the mean would be biased: where a small part of the light is in sight, rounds that see nothing agree.
class ShadowRounds {
  public:
    static constexpr std::size_t pilots = 4;
    static constexpr std::size_t most = 15; ///< that follow

    /// `samples`: AreaLights::irradiance; a round has this part of them, but at least eight rays; `least` follow in any
    /// case.
    ShadowRounds(std::size_t samples, std::size_t part, std::size_t least)
        : settled_(0.002 * std::pow(64.0 / static_cast<double>(samples), 0.75)),
          rays_(std::max<std::size_t>(8, samples / part)), least_(least) {}

    std::size_t rays() const { return rays_; } ///< of a round

    /// Pilots have as many rays together as the rounds that follow in any case.
    std::size_t rays_of_pilot() const { return rays_ * least_ / pilots; }

    /// How many follow so that the standard error of the visible share is 0.002 for 64 samples, and falls with their
    /// number as that of even rays does.
    std::size_t after(const ShareNoise& of_pilots) const {
        const double times_larger = static_cast<double>(rays_) / static_cast<double>(rays_of_pilot());
        const double excess = of_pilots.variance_of(times_larger) / (settled_ * settled_);
        const double wanted = std::ceil(std::pow(excess, -1.0 / ShareNoise::of_rounds));
        return static_cast<std::size_t>(std::clamp(wanted, static_cast<double>(least_), static_cast<double>(most)));
    }

    /// All rays, outside or inside of penumbras.
    std::size_t all_rays(bool penumbra) const { return pilots * rays_of_pilot() + rays_ * (penumbra ? most : least_); }

  private:
    double settled_;
    std::size_t rays_, least_;
};

} // namespace difusa
