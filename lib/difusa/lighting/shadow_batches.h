// How many shadow rays a light with an extent gets.
#pragma once

#include <difusa/core/colour.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

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

/// How far the values that independent batches of rays give for one quantity differ.
class BatchNoise {
  public:
    void add(double value) {
        ++batches_;
        sum_ += value;
        squares_ += value * value;
    }
    /// The share of the light of a batch, if there is any.
    void add(const LightSeen& light) {
        if (light.all > 0.0) {
            add(light.share());
        }
    }

    double variance_of_one() const {
        const auto n = static_cast<double>(batches_);
        return batches_ < 2 ? 0.0 : std::max(0.0, squares_ - sum_ * sum_ / n) / (n - 1.0);
    }
    double variance_of_mean() const { return variance_of_one() / std::max(1.0, static_cast<double>(batches_)); }

  private:
    std::size_t batches_ = 0;
    double sum_ = 0.0, squares_ = 0.0;
};

/// The same of the light of three channels.
class RgbBatchNoise {
  public:
    void add(const Rgb& light) {
        for (std::size_t c = 0; c < channels_.size(); ++c) {
            channels_[c].add(light[static_cast<Eigen::Index>(c)]);
        }
    }
    Rgb variance_of_mean() const {
        return {channels_[0].variance_of_mean(), channels_[1].variance_of_mean(), channels_[2].variance_of_mean()};
    }

  private:
    std::array<BatchNoise, 3> channels_;
};

/// Calls `act(part, s)` for samples s = 0, 1, ... of `count`, spread evenly over `parts` by the running sums
/// Part::below: each goes to the part that holds the share (s + shift) / count of the last sum. `shift`: in [0, 1).
template <class Part, class Act>
void for_even_samples(const std::vector<Part>& parts, std::size_t count, double shift, const Act& act) {
    auto part = parts.begin();
    for (std::size_t s = 0; s < count; ++s) {
        const double share = parts.back().below * (static_cast<double>(s) + shift) / static_cast<double>(count);
        while (part + 1 != parts.end() && part->below <= share) {
            ++part;
        }
        act(*part, s);
    }
}

/// Shadow rays are cast in batches, each evenly over the light and independent of the others, so that their differences
/// tell the noise: first pilots, which decide how many rays the batches that follow have, then these, which alone
/// count. Were pilots counted, or rays cast until some batches agree, the visible share would be biased: where a small
/// part of the light is in sight, batches that see nothing agree.
class ShadowBatches {
  public:
    static constexpr std::size_t batches = 4; ///< pilots, and as many that count

    /// `samples`: AreaLights::irradiance; the pilots have this part of them together; `most`: how many times larger
    /// batches are that count.
    ShadowBatches(std::size_t samples, std::size_t part, std::size_t most)
        : settled_(0.002 * std::pow(64.0 / static_cast<double>(samples), 0.75)),
          rays_(std::max<std::size_t>(4, samples / part / batches)), most_(most) {}

    std::size_t rays_of_pilot() const { return rays_; }

    /// The rays of each batch that counts, so that the standard error of the visible share, times `weight`, is 0.002
    /// for 64 samples and falls with their number to the power -3/4, as that of even rays does (measured: integrands
    /// have jumps).
    std::size_t rays_after(const BatchNoise& pilots, double weight = 1.0) const {
        const double excess = pilots.variance_of_mean() * weight * weight / (settled_ * settled_);
        const double larger = std::ceil(std::pow(excess, 2.0 / 3.0));
        return rays_ * static_cast<std::size_t>(std::clamp(larger, 1.0, static_cast<double>(most_)));
    }

    std::size_t most_rays() const { return rays_ * most_; } ///< of a batch

    /// All rays, outside or inside of penumbras.
    std::size_t all_rays(bool penumbra) const { return batches * rays_ * (1 + (penumbra ? most_ : 1)); }

  private:
    double settled_;
    std::size_t rays_, most_;
};

} // namespace difusa
