#include <difusa/lighting/light_shares.h>

namespace difusa {

std::size_t LightShares::of(Index material) {
    const auto known =
        std::find_if(shares_.begin(), shares_.end(), [&](const Share& share) { return share.material == material; });
    const auto number = static_cast<std::size_t>(known - shares_.begin());
    if (known == shares_.end()) {
        shares_.emplace_back().material = material;
    }
    return number;
}

double LightShares::strength(Rgb Share::*of) const {
    double sum = 0.0;
    for (const Share& share : shares_) {
        sum += (share.*of).abs().sum();
    }
    return sum;
}

LightShares::Sampled LightShares::sum(Sampled Share::*of) const {
    Sampled sum;
    for (const Share& share : shares_) {
        sum.add({(share.*of).seen.abs(), (share.*of).all.abs()});
    }
    return sum;
}

void LightShares::begin_batches() {
    for (Share& share : shares_) {
        share.batch = share.total = {};
    }
    noise_ = {};
    noise_of_light_ = {};
}

void LightShares::end_batch() {
    const Sampled all = sum(&Share::batch);
    noise_.add(LightSeen{all.seen.sum(), all.all.sum()});
    const Rgb mean = part(all, Rgb::Ones());
    Rgb light = Rgb::Zero();
    for (Share& share : shares_) {
        light += share.unblocked * part(share.batch, mean);
        share.total.add(share.batch);
        share.batch = {};
    }
    noise_of_light_.add(light);
}

} // namespace difusa
