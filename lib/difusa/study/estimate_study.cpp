#include <difusa/study/estimate_study.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/error_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numeric>
#include <string_view>

namespace difusa {

namespace {

double median(std::vector<double> values) {
    if (values.empty()) {
        return NAN;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return values.size() % 2 == 1 ? *middle : 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

/// The places for means over the area: those that are denser where errors may be large, if there are any.
std::size_t first_for_the_mean(const KnownLight& light) {
    return light.even < light.places.size() ? light.even : 0;
}

/// Over the area, without the noise of what is known.
double rms(const KnownLight& light, const Values& difference, double noise) {
    double squares = 0.0;
    for (std::size_t i = first_for_the_mean(light); i < light.places.size(); ++i) {
        squares += light.weight[i] * difference.row(static_cast<Eigen::Index>(i)).squaredNorm();
    }
    return std::sqrt(std::max(0.0, squares / light.scene.mesh.area - noise * noise));
}

/// Ranks from 0; equal values share their mean rank.
std::vector<double> ranks(const Eigen::VectorXd& values) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
    std::vector<double> rank(order.size());
    for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
        while (last < order.size() && values[order[last]] == values[order[first]]) {
            ++last;
        }
        for (std::size_t i = first; i < last; ++i) {
            rank[static_cast<std::size_t>(order[i])] = 0.5 * static_cast<double>(first + last - 1);
        }
    }
    return rank;
}

double rank_correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const std::vector<double> x = ranks(a), y = ranks(b);
    const double mean = 0.5 * static_cast<double>(x.size() - 1);
    double xy = 0.0, xx = 0.0, yy = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        xy += (x[i] - mean) * (y[i] - mean);
        xx += (x[i] - mean) * (x[i] - mean);
        yy += (y[i] - mean) * (y[i] - mean);
    }
    return xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
}

double processor_seconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Processor time until the field and its error estimate are there, and what estimates take of it.
class EstimateClock final : public SubordinateProgress {
  public:
    using SubordinateProgress::SubordinateProgress;

    void phase(std::string_view name) override {
        const double now = processor_seconds();
        estimates += estimating_ ? now - phase_began_ : 0.0;
        phase_began_ = now;
        estimating_ = name.ends_with("estimate error"); // of an attempt, perhaps
        if (name == "refine output") {
            total = now - began_;
        }
    }
    double total = 0.0, estimates = 0.0;

  private:
    double began_ = processor_seconds(), phase_began_ = began_;
    bool estimating_ = false;
};

/// What the estimate judges (judged_weights): radiosity, or of thermal scenes the irradiation; and its indirect part.
Values judged_of(const Scene& scene, const PointValues& values, Eigen::Index channels) {
    return scene.thermal ? values.H.leftCols(channels) : values.B.leftCols(channels);
}

Values judged_indirect_of(const Scene& scene, const PointValues& values, Eigen::Index channels) {
    return scene.thermal ? Values(values.H_indirect.leftCols(channels))
                         : Values(values.rho.cwiseProduct(values.H_indirect).leftCols(channels));
}

EstimateTrial compare(const KnownLight& light, const BakeResult& result, const Execution& execution) {
    const ErrorEstimate& error = *result.error;
    EstimateTrial trial;
    trial.reflected = error.reflected;
    trial.total_estimate = error.total;
    trial.indirect_estimate = error.indirect;
    const PointValues got = result.field().at(light.places, 0, result.options.seed, "judged", execution);
    const Eigen::Index channels = light.B.cols();
    const Values miss = judged_of(*result.scene, got, channels) - light.B;
    trial.total = rms(light, miss, light.noise);
    if (light.indirect.rows() > 0) {
        trial.indirect =
            rms(light, judged_indirect_of(*result.scene, got, channels) - light.indirect, light.noise_of_indirect);
    }
    const ErrorMap map(result.solution, error, execution);
    const Eigen::VectorXd expected =
        map.of(light.places, got, execution).error.col(0).head(static_cast<Eigen::Index>(light.even));
    const Eigen::VectorXd size =
        miss.topRows(expected.size()).rowwise().norm() / std::sqrt(static_cast<double>(channels));
    trial.rank_correlation = rank_correlation(size, expected);
    trial.covered = (size.array() <= 2.0 * expected.array()).cast<double>().mean();
    return trial;
}

} // namespace

KnownLight known_light(const Judge& judge) {
    KnownLight light;
    light.name = judge.reference.name;
    light.scene = judge.reference.scene;
    light.places = judge.places;
    light.even = judge.places.size();
    light.weight.assign(judge.places.size(), light.scene.mesh.area / static_cast<double>(judge.places.size()));
    const auto count = static_cast<Eigen::Index>(judge.places.size());
    light.B.resize(count, 1);
    const bool split = judge.H_direct.size() == judge.places.size();
    light.indirect.resize(split ? count : 0, 1);
    for (std::size_t i = 0; i < judge.places.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        light.B(row, 0) = light.scene.emission(judge.places[i])[0] + judge.rho[i] * judge.H[i];
        if (split) {
            light.indirect(row, 0) = judge.rho[i] * (judge.H[i] - judge.H_direct[i]);
        }
    }
    return light;
}

BakeOptions finer(const BakeOptions& options) {
    BakeOptions fine = options;
    fine.target.reset();
    fine.rays *= 4;
    if (fine.spacing > 0.0) {
        fine.spacing /= 2.0;
    } else {
        fine.sites = 4 * (fine.sites > 0 ? fine.sites : default_sites);
    }
    fine.seed = options.seed + 1000003;
    fine.error_points = 0;
    fine.output_spacing = 1e30;
    return fine;
}

namespace {

KnownLight at_even_places(const BakeResult& result, const std::string& name, std::size_t places) {
    KnownLight light;
    light.name = name;
    light.scene = *result.scene;
    light.even = places;
    light.places = even_points(result.scene->mesh, places, RandomStream(result.options.seed, "places"));
    light.weight.assign(places, result.scene->mesh.area / static_cast<double>(places));
    return light;
}

void look_up(const BakeResult& result, std::size_t rays, const Execution& execution, KnownLight& light) {
    const Field& field = result.field();
    Irradiance first, second;
    field.gather_twice(light.places, rays, result.options.seed, "known", execution, first, second);
    const auto judged = [&](const Irradiance& H) {
        const Values sum = H.direct + H.indirect;
        return light.scene.thermal ? sum_of_parts(sum, result.channels) : field.radiosity(light.places, sum);
    };
    const auto judged_indirect = [&](const Irradiance& H) {
        Values indirect = sum_of_parts(H.indirect, result.channels);
        for (Eigen::Index i = 0; i < indirect.rows(); ++i) {
            const Rgb weight = judged_weight(light.scene, light.places[static_cast<std::size_t>(i)]);
            indirect.row(i).array() *= weight.head(result.channels).transpose();
        }
        return indirect;
    };
    const auto combine = [&](const Values& one, const Values& other, Values& mean) {
        mean = 0.5 * (one + other);
        return rms(light, 0.5 * (one - other), 0.0);
    };
    light.noise = combine(judged(first), judged(second), light.B);
    light.noise_of_indirect = combine(judged_indirect(first), judged_indirect(second), light.indirect);
}

} // namespace

KnownLight known_light(const BakeResult& result, const std::string& name, std::size_t places,
                       const Execution& execution) {
    KnownLight light = at_even_places(result, name, places);
    const ErrorPoints dense = ErrorPointSampler(result.solution, execution).draw(places, result.options.seed + 1);
    light.places.insert(light.places.end(), dense.place.begin(), dense.place.end());
    light.weight.insert(light.weight.end(), dense.weight.begin(), dense.weight.end());
    look_up(result, 8192, execution, light);
    return light;
}

KnownLight evenly_known_light(const BakeResult& result, const std::string& name, std::size_t places, std::size_t rays,
                              const Execution& execution) {
    KnownLight light = at_even_places(result, name, 2 * places);
    look_up(result, rays, execution, light);
    return light;
}

std::vector<EstimateTrial> try_estimate(const Registry& registry, const KnownLight& light, const BakeOptions& options,
                                        std::size_t bakes, const Execution& execution,
                                        const std::function<void(const EstimateTrial&)>& tell) {
    if (options.error_points && *options.error_points == 0) {
        throw UsageError("a study of the error estimate needs one: error_points must not be 0");
    }
    std::vector<EstimateTrial> trials;
    for (std::size_t i = 0; i < bakes; ++i) {
        execution.check();
        BakeOptions own = options;
        own.seed = options.seed + i;
        own.output_spacing = 1e30;
        EstimateClock clock(execution.progress);
        const BakeResult result = bake(registry, light.scene, light.name, own, execution.with(&clock, nullptr));
        trials.push_back(compare(light, result, execution));
        trials.back().share_of_time = clock.estimates / clock.total;
        trials.back().seconds = clock.total;
        trials.back().sites = result.sites->size();
        trials.back().transport_bytes = result.system->transport().bytes;
        trials.back().rays = result.journal.count_of("rays");
        const bool as_a_whole = result.system->discretisation().projection->is_mean() &&
                                !result.system->discretisation().projection->is_identity();
        trials.back().unknowns = as_a_whole ? substructure_of(result)->patches() : result.sites->size();
        trials.back().above_target = own.target && trials.back().total > own.target->relative * trials.back().reflected;
        tell(trials.back());
    }
    return trials;
}

std::string estimate_header() {
    return "| scene | bakes | error | below it: total | indirect | 97.5 % end / error: median | largest | indirect | "
           "largest | estimate / error | indirect | rank correlation | covered | time | bake, s | above the target |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
}

std::string estimate_row(const std::string& name, const std::vector<EstimateTrial>& trials) {
    std::vector<double> error, high, high_indirect, mid, mid_indirect, rank, covered, time, seconds;
    std::size_t missed = 0, missed_indirect = 0, above = 0;
    for (const EstimateTrial& t : trials) {
        error.push_back(100.0 * t.total / t.reflected);
        missed += t.total_estimate.high < t.total ? 1 : 0;
        if (t.total > 0.0) { // else it is below the noise of what is known
            high.push_back(t.total_estimate.high / t.total);
            mid.push_back(t.total_estimate.rms / t.total);
        }
        if (t.indirect > 0.0) {
            missed_indirect += t.indirect_estimate.high < t.indirect ? 1 : 0;
            high_indirect.push_back(t.indirect_estimate.high / t.indirect);
            mid_indirect.push_back(t.indirect_estimate.rms / t.indirect);
        }
        rank.push_back(t.rank_correlation);
        covered.push_back(100.0 * t.covered);
        time.push_back(100.0 * t.share_of_time);
        seconds.push_back(t.seconds);
        above += t.above_target ? 1 : 0;
    }
    const auto largest = [](const std::vector<double>& values) {
        return values.empty() ? NAN : *std::max_element(values.begin(), values.end());
    };
    std::array<char, 512> row{};
    std::snprintf(row.data(), row.size(),
                  " | %zu | %.2g %% | %zu | %zu | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.0f %% | %.0f %% | "
                  "%.2g | %zu |\n",
                  trials.size(), median(error), missed, missed_indirect, median(high), largest(high),
                  median(high_indirect), largest(high_indirect), median(mid), median(mid_indirect), median(rank),
                  median(covered), median(time), median(seconds), above);
    std::string text = row.data();
    for (const std::string_view none : {"-nan", "nan"}) {
        for (std::size_t at = 0; (at = text.find(none, at)) != std::string::npos;) {
            text.replace(at, none.size(), "–");
        }
    }
    return "| " + name + text;
}

std::string estimate_csv_header() {
    return "scene,error,estimate,low,high,error_indirect,estimate_indirect,low_indirect,high_indirect,reflected,"
           "rank_correlation,covered,share_of_time,seconds,above_target\n";
}

std::string estimate_csv_row(const std::string& name, const EstimateTrial& t) {
    std::string row = csv_quoted(name);
    for (const double value : {t.total, t.total_estimate.rms, t.total_estimate.low, t.total_estimate.high, t.indirect,
                               t.indirect_estimate.rms, t.indirect_estimate.low, t.indirect_estimate.high, t.reflected,
                               t.rank_correlation, t.covered, t.share_of_time, t.seconds, t.above_target ? 1.0 : 0.0}) {
        row += "," + text_of(value);
    }
    return row + "\n";
}

} // namespace difusa
