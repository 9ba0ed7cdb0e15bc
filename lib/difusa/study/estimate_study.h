// Does the error estimate hold, and how close is it? Many bakes of one scene with different seeds, each compared with a
// solution that shares no random numbers with them.
#pragma once

#include <difusa/bake.h>
#include <difusa/study/measure.h>

#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// The light at surface points as it should be. Columns are channels.
struct KnownLight {
    std::string name;
    Scene scene;
    std::vector<SurfacePoint> places;
    Values B;                                    ///< radiosity, W/m²
    Values indirect;                             ///< rho H_indirect, W/m²; no rows if unknown
    std::vector<double> weight;                  ///< area that each place stands for
    double noise = 0.0, noise_of_indirect = 0.0; ///< rms over the area of the noise of B and `indirect`, W/m²
    std::size_t even = 0; ///< the first places, drawn evenly, for statistics per place; the others are denser where
                          ///< errors may be large, for the mean over the area
};

/// A case whose solution is known, at the judge's places.
KnownLight known_light(const Judge& judge);

/// Options of a bake that judges those with `options`: four times the sites and rays, and another seed.
BakeOptions finer(const BakeOptions& options);

/// Light according to a finer bake, at twice `places` points, half of them where that bake's own errors may be large:
/// 8192 rays gathered from each. For bakes like it.
KnownLight known_light(const BakeResult& finer, const std::string& name, std::size_t places,
                       const Execution& execution);

/// The same at as many points that are all drawn evenly, for methods with errors elsewhere: so many rays from each.
KnownLight evenly_known_light(const BakeResult& finer, const std::string& name, std::size_t places, std::size_t rays,
                              const Execution& execution);

/// One bake.
struct EstimateTrial {
    double total = 0.0, indirect = 0.0; ///< true rms errors at the places, all channels, W/m²; indirect: 0 if unknown
    double reflected = 0.0;             ///< ErrorEstimate::reflected
    RmsEstimate total_estimate, indirect_estimate;
    double rank_correlation = 0.0; ///< Spearman's, of the estimate and the true error per place
    double covered = 0.0;          ///< share of the places whose error is below twice the estimate there
    double share_of_time = 0.0;    ///< of `seconds`, for the estimate
    double seconds = 0.0;          ///< the bake's processor time up to the field and the estimate
    std::size_t sites = 0, transport_bytes = 0;
    std::size_t rays = 0;      ///< of the transport, those of pilot bakes included
    std::size_t unknowns = 0;  ///< of the linear system: the sites, or the patches that they are parts of
    bool above_target = false; ///< the true error exceeds BakeOptions::target

    /// The error of the total light relative to the reflected light.
    double relative_error() const { return reflected > 0.0 ? total / reflected : 0.0; }
    /// Processor time up to the field.
    double field_seconds() const { return seconds * (1.0 - share_of_time); }
};

/// Bakes with seeds options.seed, options.seed + 1, ... `tell` is called with each.
std::vector<EstimateTrial> try_estimate(const Registry& registry, const KnownLight& light, const BakeOptions& options,
                                        std::size_t bakes, const Execution& execution,
                                        const std::function<void(const EstimateTrial&)>& tell);

/// A row of a Markdown table, and its header: bakes, misses of the 97.5 % end, its ratio to the true error (median,
/// largest), that of the estimate (median), for the total and indirect light; rank correlation, share covered, share of
/// time, processor time (medians); bakes above their target.
std::string estimate_header();
std::string estimate_row(const std::string& name, const std::vector<EstimateTrial>& trials);

/// One row per bake, and the header; W/m².
std::string estimate_csv_header();
std::string estimate_csv_row(const std::string& name, const EstimateTrial& trial);

} // namespace difusa
