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

double LightShares::known_strength() const {
    double sum = 0.0;
    for (const Share& share : shares_) {
        sum += share.known.abs().sum();
    }
    return sum;
}

double LightShares::unblocked_strength() const {
    double sum = 0.0;
    for (const Share& share : shares_) {
        sum += share.unblocked.abs().sum();
    }
    return sum;
}

LightShares::Sampled LightShares::sum(const std::vector<Share>& shares, Sampled Share::*of) {
    Sampled sum;
    for (const Share& share : shares) {
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
    const Sampled all = sum(shares_, &Share::batch);
    noise_.add(LightSeen{all.seen.sum(), all.all.sum()});
    const Rgb mean = mean_part(&Share::batch);
    Rgb light = Rgb::Zero();
    for (Share& share : shares_) {
        light += share.unblocked * part(share.batch, mean);
        share.total.add(share.batch);
        share.batch = {};
    }
    noise_of_light_.add(light);
}

} // namespace difusa
