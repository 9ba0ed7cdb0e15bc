#include <difusa/discretisation/sampler.h>

#include <difusa/discretisation/predict_sites.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace difusa {

double spacing_for_count(const Sampler& sampler, const Mesh& mesh, const Visibility* visibility, std::size_t count,
                         std::uint64_t seed, const Execution& execution) {
    DIFUSA_REQUIRE(count > 0);
    const auto wanted = static_cast<double>(count);
    // Maximal Poisson-disk samplings have about 0.7 sites per D². After that: count ~ D^-p through the last two tries.
    double spacing = std::sqrt(0.7 * mesh.area / wanted), power = 2.0;
    double best = spacing, best_miss = std::numeric_limits<double>::infinity();
    double last_spacing = 0.0, last_count = 0.0;
    for (int attempt = 0; attempt < 6; ++attempt) {
        const std::size_t limit = 64 * count + 1024 + mesh.region_count;
        const auto [found, exact] = expected_sites(sampler, mesh, visibility, spacing, limit, seed, execution);
        const double miss = std::abs(std::log(found / wanted));
        if (miss < best_miss) {
            best_miss = miss;
            best = spacing;
        }
        if (miss <= std::log(exact ? 1.05 : 1.03)) { // a prediction may be off by another 2 %
            break;
        }
        if (last_count > 0.0 && found != last_count) {
            power = std::clamp(-std::log(found / last_count) / std::log(spacing / last_spacing), 0.3, 3.0);
        }
        last_spacing = spacing;
        last_count = found;
        spacing *= std::clamp(std::pow(found / wanted, 1.0 / power), 0.05, 20.0);
    }
    return best;
}

} // namespace difusa
