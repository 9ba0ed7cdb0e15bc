#include <difusa/discretisation/sampler.h>

#include <difusa/discretisation/predict_sites.h>
#include <difusa/discretisation/region_trees.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace difusa {

namespace {

constexpr double sites_per_square = 0.7; ///< sites per D² of a maximal Poisson-disk sampling, about
constexpr double most_unseen = 50.0;     ///< surface that a sampler may leave out, as a multiple of the rest
constexpr double few_regions = 1.0 / 32; ///< of the wanted sites: single sites on them take less than half

/// The largest D at which `wanted` sites could cover the surface: along a region that extends s in the direction of an
/// axis there are at least s / 2D of them. Regions shorter than 2D do not count.
double widest_spacing(const Mesh& mesh, double wanted) {
    std::vector<double> extent;
    extent.reserve(mesh.region_count);
    for (const Eigen::AlignedBox3d& each : region_boxes(mesh)) {
        extent.push_back(each.isEmpty() ? 0.0 : each.sizes().maxCoeff());
    }
    std::sort(extent.begin(), extent.end(), std::greater<>());
    double sum = 0.0, widest = 0.0;
    for (const double s : extent) {
        sum += s;
        const double spacing = sum / (2.0 * wanted);
        widest = s > 2.0 * spacing ? std::max(widest, spacing) : widest;
    }
    return widest;
}

/// Finer spacings need not be tried: long and narrow regions have too many sites even now, or the sampler sees next to
/// nothing of the surface, all of which is divided at this spacing.
double least_spacing(const Sampler& sampler, const Mesh& mesh, double wanted) {
    if (!sampler.needs_visibility()) {
        return widest_spacing(mesh, wanted);
    }
    const double everywhere = most_unseen * wanted;
    return std::max(std::sqrt(sites_per_square * mesh.area / everywhere), widest_spacing(mesh, everywhere));
}

double nearest_spacing(const Sampler& sampler, const Mesh& mesh, const Visibility* visibility, std::size_t count,
                       std::uint64_t seed, const Execution& execution) {
    const auto wanted = static_cast<double>(count);
    const double least = least_spacing(sampler, mesh, wanted);
    // The first try is right for a compact surface. After that: count ~ D^-p through the last two tries.
    double spacing = std::max(least, std::sqrt(sites_per_square * mesh.area / wanted)), power = 2.0;
    double best_miss = std::numeric_limits<double>::infinity();
    double best = spacing, last_spacing = 0.0, last_count = 0.0;
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
        spacing = std::max(least, spacing * std::clamp(std::pow(found / wanted, 1.0 / power), 0.05, 20.0));
        if (spacing == last_spacing) {
            break;
        }
    }
    return best;
}

} // namespace

double spacing_for_count(const Sampler& sampler, const Mesh& mesh, const Visibility* visibility, std::size_t count,
                         std::uint64_t seed, const Execution& execution) {
    DIFUSA_REQUIRE(count > 0);
    std::size_t wanted = count;
    if (!sampler.needs_visibility() &&
        static_cast<double>(mesh.region_count) > few_regions * static_cast<double>(count)) {
        const std::size_t most = std::numeric_limits<std::uint32_t>::max();
        const ExpectedSites single = expected_sites(sampler, mesh, visibility, mesh.diameter(), most, seed, execution);
        wanted = std::max(count, static_cast<std::size_t>(single.count) + count / 2);
    }
    return nearest_spacing(sampler, mesh, visibility, wanted, seed, execution);
}

} // namespace difusa
