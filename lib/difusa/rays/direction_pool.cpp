#include <difusa/rays/direction_pool.h>

#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace difusa {

namespace {

constexpr std::size_t pool_size = 32;

/// Interleaves the bits of the cell of (x, y) in a 32 by 32 grid over the unit disc: neighbours in this order are
/// neighbours in direction, and traverse the same parts of a search tree.
unsigned morton(const Vec3& direction) {
    const auto cell = [](double x) { return static_cast<unsigned>(std::clamp(16.0 * (x + 1.0), 0.0, 31.0)); };
    unsigned code = 0;
    for (unsigned bit = 0; bit < 5; ++bit) {
        code |= ((cell(direction[0]) >> bit) & 1U) << (2 * bit);
        code |= ((cell(direction[1]) >> bit) & 1U) << (2 * bit + 1);
    }
    return code;
}

DirectionSet sorted(const DirectionSet& set) {
    std::vector<std::size_t> order(set.direction.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return morton(set.direction[a]) < morton(set.direction[b]); });
    DirectionSet result;
    for (const std::size_t d : order) {
        result.direction.push_back(set.direction[d]);
        result.weight.push_back(set.weight[d]);
    }
    return result;
}

/// To multiples of 2^-52 that sum to exactly 1: the largest takes the rounding errors of all.
void round_weights(std::vector<double>& weight) {
    double missing = 1.0;
    for (double& each : weight) {
        each = 0x1p-52 * std::nearbyint(0x1p52 * each);
        missing -= each; // exact
    }
    *std::max_element(weight.begin(), weight.end()) += missing;
}

/// Refuses what a plugin must not give: all that is computed from it would be wrong, and the error estimates, too.
void check_directions(const DirectionSet& set) {
    DIFUSA_REQUIRE(!set.direction.empty() && set.weight.size() == set.direction.size(),
                   "a directions plugin gave a set without directions, or not with a weight for each");
    double sum = 0.0;
    for (std::size_t d = 0; d < set.direction.size(); ++d) {
        const Vec3& w = set.direction[d];
        DIFUSA_REQUIRE(w.z() > 0.0 && std::abs(w.norm() - 1.0) <= 1e-6 && set.weight[d] > 0.0,
                       "a directions plugin gave the direction " + coordinates(w) + " of weight " +
                           text_of(set.weight[d]) + ": it must be a unit vector with z > 0, and its weight positive");
        sum += set.weight[d];
    }
    DIFUSA_REQUIRE(std::abs(sum - 1.0) <= 1e-6,
                   "a directions plugin gave weights that sum to " + text_of(sum) + " instead of 1");
}

} // namespace

DirectionPool::DirectionPool(const Directions& directions, std::size_t count, std::uint64_t seed)
    : seed_(seed), turned_(!directions.is_fixed()) {
    for (std::size_t k = 0; k < (turned_ ? pool_size : 1); ++k) {
        sets_.push_back(sorted(directions.make(count, RandomStream(seed, "direction set", k))));
        check_directions(sets_[k]);
        DIFUSA_REQUIRE(sets_[k].direction.size() == sets_[0].direction.size(),
                       "a directions plugin gave sets of different sizes");
        const double equal = 1.0 / static_cast<double>(sets_[k].weight.size());
        equal_weights_ = equal_weights_ && std::all_of(sets_[k].weight.begin(), sets_[k].weight.end(),
                                                       [&](double weight) { return weight == equal; });
    }
    if (!equal_weights_) {
        for (DirectionSet& set : sets_) {
            round_weights(set.weight);
        }
    }
}

std::span<const double> DirectionPool::rays(const SurfacePoint& x, std::size_t site, std::span<Ray> rays) const {
    RandomStream stream(seed_, "directions of site", site);
    const DirectionSet& set = sets_[stream.below(sets_.size())];
    const double angle = turned_ ? 2.0 * std::numbers::pi * stream.uniform() : 0.0;
    Vec3 t, b;
    tangents(x.normal, t, b);
    const Vec3 t_turned = std::cos(angle) * t + std::sin(angle) * b;
    const Vec3 b_turned = std::cos(angle) * b - std::sin(angle) * t;
    for (std::size_t d = 0; d < set.direction.size(); ++d) {
        const Vec3& w = set.direction[d];
        rays[d].origin = x.position;
        rays[d].direction = w[0] * t_turned + w[1] * b_turned + w[2] * x.normal;
        rays[d].face = x.face;
    }
    return set.weight;
}

} // namespace difusa
