// Which part of the light of each material gets through to a point, as batches of shadow rays tell it.
#pragma once

#include <difusa/core/colour.h>
#include <difusa/core/types.h>
#include <difusa/lighting/shadow_batches.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace difusa {

/// The lights that a point may see, by material.
class LightShares {
  public:
    /// Of samples: what got through, and the total.
    struct Sampled {
        Rgb seen = Rgb::Zero(), all = Rgb::Zero();
        void add(const Sampled& other) {
            seen += other.seen;
            all += other.all;
        }
    };
    struct Share {
        Index material = none;
        Rgb known = Rgb::Zero();     ///< irradiance that needs no shadow rays, W/m²
        Rgb unblocked = Rgb::Zero(); ///< the rest of it, if nothing is in the way
        double light = 0.0;          ///< sum of Part::light
        Sampled batch, total;        ///< of this batch, and of those before it
    };

    void clear() { shares_.clear(); }
    Share& operator[](std::size_t share) { return shares_[share]; }

    /// The number of the share of a material, made if there is none.
    std::size_t of(Index material);

    /// Divides shadow rays among lights: half of them in proportion to the light, so that noise is low, and half evenly
    /// over the lights, or over the materials if not every light would get one of so many samples, so that no dim light
    /// is lost behind a bright one that is hidden. To be called once. Reads Part::light (strength of the unblocked
    /// light) and Part::share (its number); sets Part::below, the running sum of the chances of being chosen, and
    /// Part::factor, the share of the light over the chance, by which the light of each ray is to be multiplied.
    template <class Part> void divide(std::vector<Part>& parts, std::size_t samples) {
        double all = 0.0;
        for (const Part& part : parts) {
            all += part.light;
            shares_[part.share].light += part.light;
        }
        const auto lit = static_cast<double>(
            std::count_if(shares_.begin(), shares_.end(), [](const Share& share) { return share.light > 0.0; }));
        const auto count = static_cast<double>(parts.size());
        const bool evenly = 2 * parts.size() <= samples;
        double below = 0.0;
        for (Part& part : parts) {
            const double own = part.light / all;
            const double even = evenly ? 1.0 / count : part.light / (lit * shares_[part.share].light);
            const double chance = 0.5 * (own + even);
            below += chance;
            part.below = below;
            part.factor = own / chance;
        }
    }

    /// Forgets all samples, then calls `cast()`, which adds to Share::batch, for each batch.
    template <class Cast> void cast_batches(const Cast& cast) {
        begin_batches();
        for (std::size_t batch = 0; batch < ShadowBatches::batches; ++batch) {
            cast();
            end_batch();
        }
    }

    bool sees_some() const { return (sum(&Share::total).seen > 0.0).any(); }
    const BatchNoise& noise_of_visible_part() const { return noise_; }

    double strength(Rgb Share::*of) const; ///< of all materials and channels

    /// Irradiance, with what is known, and the part of the rest that the samples of the last batches got through. If
    /// no sample of a material is above the horizon, which happens where it grazes, it is taken for as visible as the
    /// others.
    template <class Add> void for_each_visible(const Add& add) const { // add(material, irradiance)
        const Rgb mean = part(sum(&Share::total), Rgb::Ones());
        for (const Share& share : shares_) {
            add(share.material, share.known + share.unblocked * part(share.total, mean));
        }
    }

    /// Of all irradiance, as the differences between the last batches tell it, W²/m⁴.
    Rgb variance() const { return noise_of_light_.variance_of_mean(); }

  private:
    void begin_batches();
    void end_batch();
    Sampled sum(Sampled Share::*of) const;
    /// What got through. All samples of a material have the same sign.
    static Rgb part(const Sampled& sampled, const Rgb& without_samples) {
        const Rgb all = sampled.all.abs();
        return (all > 0.0).select(sampled.seen.abs() / all.max(std::numeric_limits<double>::min()), without_samples);
    }

    std::vector<Share> shares_;
    BatchNoise noise_;
    RgbBatchNoise noise_of_light_;
};

} // namespace difusa
