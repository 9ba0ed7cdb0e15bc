#include <difusa/bake/error_target.h>

#include <difusa/bake/cost.h>
#include <difusa/bake/evaluation.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/radiosity/error_map.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace difusa {

namespace {

constexpr double margin = 0.85; ///< of the target, which the next attempt's interval should end at
constexpr double least_interval = 1.25, most_interval = 1.7; ///< predictions of its upper end over the estimate are
                                                             ///< kept between these
constexpr double wide_interval = 2.2;                        ///< the same ratio: more points would help
constexpr double of_basis = 0.75; ///< squared error of the basis: sites to this power, inverted
constexpr double of_noise = 1.5;  ///< squared noise: rays to this power, inverted
constexpr double basis_part =
    of_noise / (of_basis + of_noise); ///< of the squared error, for the least sites times rays
constexpr double hopeless = 2.0;      ///< times the target: what the basis alone is predicted to miss with all sites
constexpr double worthwhile = 1.5;    ///< time of an attempt cut down to what there is, over that of the last
constexpr double most_of_shadow_rays = 0.5; ///< of the time of an attempt, where there are to be more of them
constexpr double shadow_part = 0.1;         ///< of the squared error, left to shadow rays
constexpr std::size_t least_rays = 64, most_rays = std::size_t{1} << 16U;
constexpr std::size_t most_error_points = std::size_t{1} << 16U;
constexpr std::size_t first_goal_samples = 1024, most_goal_samples = std::size_t{1} << 24U; // of a goal

std::size_t scaled(std::size_t count, double factor) {
    return static_cast<std::size_t>(std::llround(static_cast<double>(count) * factor));
}

/// Tells the attempt in the names of phases; remarks of attempts that may be replaced are not reported.
class AttemptProgress final : public SubordinateProgress {
  public:
    AttemptProgress(Progress* whole, std::size_t number) : SubordinateProgress(whole), number_(number) {}

    void phase(std::string_view name) override {
        if (whole() != nullptr) {
            whole()->phase("attempt " + std::to_string(number_) + ", " + std::string(name));
        }
    }
    void advance(double fraction) override {
        if (whole() != nullptr) {
            whole()->advance(fraction);
        }
    }

  private:
    std::size_t number_;
};

std::string percent_text(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g %%", 100.0 * value);
    return text.data();
}

/// Half the width of the interval of a mean, relative to it, in the channel where it is largest; infinite where the
/// mean is not above 0 but in doubt.
double relative_half_width(const GoalEstimate& goal) {
    double largest = 0.0;
    for (int c = 0; c < 3; ++c) {
        if (const double half = 0.5 * (goal.high[c] - goal.low[c]); half > 0.0) {
            largest =
                std::max(largest, goal.mean[c] > 0.0 ? half / goal.mean[c] : std::numeric_limits<double>::infinity());
        }
    }
    return largest;
}

std::size_t error_points_for(std::size_t sites, std::size_t least) {
    return std::max(least, error_points(BakeOptions(), sites));
}

/// What the upper end over the estimate of an attempt's error will be from so many points: the logarithm falls with the
/// root of their number. Kept between least_interval and most_interval.
double interval_from(const Attempt& attempt, std::size_t points) {
    if (!(attempt.rms > 0.0)) {
        return most_interval;
    }
    const double fewer = static_cast<double>(attempt.effort.error_points) / static_cast<double>(points);
    return std::clamp(std::pow(attempt.high / attempt.rms, std::sqrt(fewer)), least_interval, most_interval);
}

/// For an error of the field whose square is smaller by the factor `excess`.
void add_sites_and_rays(const Attempt& attempt, double excess, Effort& next) {
    const double more_sites = std::pow(excess * (1.0 - attempt.noise_share) / basis_part, 1.0 / of_basis);
    const double more_rays = std::pow(excess * attempt.noise_share / (1.0 - basis_part), 1.0 / of_noise);
    next.sites = scaled(next.sites, std::clamp(more_sites, 1.0, 8.0));
    next.rays = std::clamp(scaled(next.rays, std::clamp(more_rays, 0.5, 4.0)), least_rays, most_rays);
    if (next.sites < scaled(attempt.effort.sites, 1.2) && next.rays < scaled(attempt.effort.rays, 1.2)) {
        next.sites = scaled(attempt.effort.sites, 1.5); // what is predicted to suffice did not
    }
}

/// So that the noise of shadow rays has its part of a squared error of `wanted`². True if there are more of them.
bool add_shadow_rays(const Attempt& attempt, double rms, double wanted, Effort& next) {
    const double excess = attempt.shadow_noise_share * rms * rms / (shadow_part * wanted * wanted);
    if (excess > 1.0) {
        const double more = std::clamp(std::pow(excess, 1.0 / of_noise), 1.5, 16.0);
        next.shadow_rays = std::min(most_shadow_rays, scaled(attempt.effort.shadow_rays, more));
    }
    return next.shadow_rays > attempt.effort.shadow_rays;
}

void next_for_goals(const Attempt& attempt, const ErrorTarget& target, std::size_t goals, Effort& next) {
    const double wanted_of_field = margin * 0.5 * std::sqrt(target.relative);
    if (attempt.rms > wanted_of_field) {
        add_sites_and_rays(attempt, std::pow(attempt.rms / wanted_of_field, 2), next);
    }
    const double excess = std::pow(*attempt.goals / (margin * target.relative), 2);
    if (excess <= 1.0) {
        return;
    }
    const double grown = static_cast<double>(next.sites) / static_cast<double>(attempt.effort.sites);
    const double more = std::clamp(excess / std::pow(grown, of_basis), 1.2, 16.0);
    // As many rays from samples as from sites at most: beyond, both grow.
    const double samples = more * static_cast<double>(goals * next.goal_samples) / static_cast<double>(next.sites);
    const double more_sites = std::clamp(std::pow(samples, 1.0 / (1.0 + of_basis)), 1.0, 8.0);
    next.sites = scaled(next.sites, more_sites);
    next.goal_samples = std::min(most_goal_samples, scaled(next.goal_samples, more / std::pow(more_sites, of_basis)));
}

class TargetSearch {
  public:
    TargetSearch(BakeResult& result, const std::function<void(BakeResult&, const Execution&)>& solve,
                 const Execution& execution)
        : scene_(result), best_(result), solve_(solve), execution_(execution), target_(*result.options.target),
          goals_(result.options.goals.size()) {}

    void run() {
        if (execution_.journal != nullptr) {
            execution_.journal->end(); // attempts have times of their own
        }
        Effort effort = first_effort(target_, goals_, best_.options.shadow_rays);
        while (attempts_.empty() || error_of(attempts_.back()) > target_.relative) {
            if (!attempts_.empty()) {
                effort = next_effort(attempts_.back(), target_, goals_);
                std::string reason = limit_to(effort);
                if (reason.empty() && !fit_into_time(effort)) {
                    reason = "the next attempt would take about " + text_of(std::ceil(seconds_of(effort))) + " s";
                }
                if (!reason.empty()) {
                    miss(reason);
                    break;
                }
            }
            const std::string refused = attempt(effort);
            bool fits = refused.empty();
            while (!fits && target_.best_effort && halve(effort) &&
                   seconds_of(effort) <= target_.most_seconds - spent_) {
                fits = attempt(effort).empty();
            }
            if (!refused.empty() && (!fits || error_of(attempts_.back()) > target_.relative)) {
                miss(refused);
                break;
            }
        }
        best_.attempts = attempts_;
        if (execution_.journal != nullptr) {
            execution_.journal->append(best_journal_);
        }
        if (execution_.progress != nullptr) {
            for (const std::string& note : best_journal_.notes()) {
                execution_.progress->remark(note);
            }
        }
        if (!missed_.empty()) {
            execution_.note(missed_);
        }
    }

  private:
    /// Why this effort is beyond a limit; empty if it is not.
    std::string limit_to(const Effort& effort) const {
        const Attempt& last = attempts_.back();
        const auto is_no_more = [](const Effort& a, const Effort& b) {
            return a.sites <= b.sites && a.rays <= b.rays && a.error_points <= b.error_points &&
                   a.goal_samples <= b.goal_samples && a.shadow_rays <= b.shadow_rays;
        };
        if (is_no_more(effort, last.effort)) {
            return last.effort.sites < scaled(target_.most_sites, 0.9)
                       ? "more rays, samples or error points are needed than there may be"
                       : "more than " + std::to_string(target_.most_sites) + " sites are needed";
        }
        if (!last.goals && last.cut_off > margin * target_.relative) {
            return "light that is not followed to its end leaves an error of " + percent_text(last.cut_off) +
                   (best_.scene->mesh.repetition.any() ? ", far away in a series of periods or symmetry planes"
                                                       : ", between mirrors: give a larger --mirror-depth");
        }
        const double of_shadow_rays = last.rms * std::sqrt(last.shadow_noise_share);
        if (!last.goals && last.effort.shadow_rays >= most_shadow_rays && of_shadow_rays > margin * target_.relative) {
            return "shadow rays leave an error of " + percent_text(of_shadow_rays) + ", with as many as there may be";
        }
        if (attempts_.size() > 1 && is_no_more(last.effort, attempts_[attempts_.size() - 2].effort)) {
            return "no further sites are found where they would help";
        }
        const double of_basis_alone =
            last.rms * std::sqrt((1.0 - last.noise_share) * (1.0 - last.shadow_noise_share)) *
            std::pow(static_cast<double>(last.effort.sites) / static_cast<double>(target_.most_sites), 0.5 * of_basis);
        const bool fills_the_time = target_.best_effort && std::isfinite(target_.most_seconds);
        if (!fills_the_time &&
            of_basis_alone > hopeless * (last.goals ? 0.5 * std::sqrt(target_.relative) : target_.relative)) {
            return "probably more than " + std::to_string(target_.most_sites) + " sites are needed";
        }
        return "";
    }

    double seconds_of(const Effort& effort) const {
        const Attempt& last = attempts_.back();
        const double shadow_rays =
            static_cast<double>(effort.shadow_rays) / static_cast<double>(last.effort.shadow_rays);
        return last.seconds * std::max(1.0, rays_of(effort, goals_) / rays_of(last.effort, goals_)) *
               (1.0 + most_of_shadow_rays * (std::max(1.0, shadow_rays) - 1.0));
    }

    /// False if it would take longer than there is time. If the best that can be reached is wanted, as much of it as
    /// there is time for, unless that hardly improves on the last attempt.
    bool fit_into_time(Effort& effort) const {
        const Attempt& last = attempts_.back();
        const double left = target_.most_seconds - spent_;
        const double next = seconds_of(effort);
        if (next <= left) {
            return true;
        }
        const double more = next / last.seconds, less = left / last.seconds;
        if (!target_.best_effort || less < worthwhile) {
            return false;
        }
        effort = part_of_the_way(effort, std::log(less) / std::log(more));
        return true;
    }

    /// Half of the way, for what memory may suffice; false if that is hardly more than the last.
    bool halve(Effort& effort) const {
        const Effort half = part_of_the_way(effort, 0.5);
        if (seconds_of(half) < worthwhile * attempts_.back().seconds) {
            return false;
        }
        effort = half;
        return true;
    }

    /// From the last effort to this one, by a share of the growth on a logarithmic scale.
    Effort part_of_the_way(Effort effort, double share) const {
        const Effort& last = attempts_.back().effort;
        const auto grown = [&](std::size_t from, std::size_t to) {
            return from == 0 ? 0 : scaled(from, std::pow(static_cast<double>(to) / static_cast<double>(from), share));
        };
        effort.sites = grown(last.sites, effort.sites);
        effort.rays = grown(last.rays, effort.rays);
        effort.goal_samples = grown(last.goal_samples, effort.goal_samples);
        effort.shadow_rays = grown(last.shadow_rays, effort.shadow_rays);
        effort.error_points = error_points_for(effort.sites, last.error_points);
        return effort;
    }

    void miss(const std::string& reason) {
        const Attempt& reached = attempts_[best_number_];
        missed_ = std::string(reached.goals ? "the error of the goals" : "the error") + " is not below " +
                  percent_text(target_.relative) + ": below " + percent_text(error_of(reached)) +
                  " was reached, with " + std::to_string(reached.effort.sites) + " sites and " +
                  std::to_string(reached.effort.rays) + " rays from each, and " +
                  std::to_string(reached.effort.shadow_rays) + " shadow rays; " + reason;
        if (!target_.best_effort) {
            throw NotConverged(missed_ + ". Ask for a larger --error, raise the limit, or accept what was reached with "
                                         "--best-effort");
        }
        best_.target_missed = true;
    }

    /// Why memory does not suffice for it; empty if it does.
    std::string attempt(const Effort& effort) {
        const auto since = [began = std::chrono::steady_clock::now()] {
            return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
        };
        const bool judge_again = !attempts_.empty() && best_number_ + 1 == attempts_.size() &&
                                 effort.sites == attempts_.back().effort.sites &&
                                 effort.rays == attempts_.back().effort.rays &&
                                 effort.shadow_rays == attempts_.back().effort.shadow_rays;
        AttemptProgress progress(execution_.progress, attempts_.size() + 1);
        Journal journal;
        const Execution own = execution_.with(&progress, &journal);
        BakeResult next = judge_again ? best_ : scene_;
        next.options.error_points = effort.error_points;
        if (goals_ > 0) {
            next.options.goal_samples = effort.goal_samples;
            next.goal_estimates.clear();
        }
        try {
            if (!judge_again) {
                next.options.sites = effort.sites;
                next.options.rays = effort.rays;
                next.options.shadow_rays = effort.shadow_rays;
                next.options.adaptive = true;
                solve_(next, own);
            } else if (effort.error_points != attempts_.back().effort.error_points) {
                estimate_error_of(next, own);
            }
            estimate_goals_of(next, own);
        } catch (const ResourceError& error) {
            if (attempts_.empty()) {
                throw;
            }
            spent_ += since();
            journal.end();
            if (execution_.journal != nullptr) {
                execution_.journal->append_effort(journal);
            }
            return error.what();
        }
        attempts_.push_back(judged(next, since(), own));
        spent_ += attempts_.back().seconds;
        journal.end();
        if (attempts_.size() == 1 || judge_again || error_of(attempts_.back()) < error_of(attempts_[best_number_])) {
            keep(std::move(next), std::move(journal), judge_again);
        } else if (execution_.journal != nullptr) {
            execution_.journal->append_effort(journal);
        }
        return "";
    }

    void keep(BakeResult next, Journal journal, bool judged_again) {
        if (judged_again) {
            best_journal_.append(journal);
        } else {
            if (execution_.journal != nullptr) {
                execution_.journal->append_effort(best_journal_);
            }
            best_journal_ = std::move(journal);
        }
        best_ = std::move(next);
        best_number_ = attempts_.size() - 1;
    }

    const BakeResult scene_; ///< before any attempt
    BakeResult& best_;
    const std::function<void(BakeResult&, const Execution&)>& solve_;
    const Execution& execution_;
    const ErrorTarget target_;
    const std::size_t goals_;
    std::vector<Attempt> attempts_;
    double spent_ = 0.0; ///< seconds, on attempts that memory did not suffice for, too
    std::size_t best_number_ = 0;
    Journal best_journal_;
    std::string missed_;
};

} // namespace

Effort first_effort(const ErrorTarget& target, std::size_t goals, std::size_t shadow_rays) {
    return {std::min<std::size_t>(1000, target.most_sites), 128, 768, goals > 0 ? first_goal_samples : 0, shadow_rays};
}

Attempt judged(const BakeResult& result, double seconds, const Execution& execution) {
    const ErrorEstimate& error = *result.error;
    Attempt attempt;
    attempt.effort = {result.sites->size(), result.options.rays, error.points, 0, result.options.shadow_rays};
    attempt.seconds = seconds;
    if (!result.goal_estimates.empty()) {
        attempt.effort.goal_samples = result.options.goal_samples;
        attempt.goals = 0.0;
        for (const GoalEstimate& goal : result.goal_estimates) {
            attempt.goals = std::max(*attempt.goals, relative_half_width(goal));
        }
    }
    if (!(error.reflected > 0.0)) {
        return attempt; // nothing is reflected: there is no error
    }
    attempt.rms = error.total.rms / error.reflected;
    attempt.high = error.total.high / error.reflected;
    if (error.total.rms > 0.0) {
        attempt.shadow_noise_share = std::min(1.0, std::pow(error.noise_of_direct / error.total.rms, 2));
    }
    // Bounces carry it on as they do all of the residual.
    const double carried = error.residual.rms > 0.0 ? std::max(1.0, error.total.rms / error.residual.rms) : 1.0;
    attempt.cut_off = carried * error.cut_off / error.reflected;
    const ErrorsAt at = ErrorMap(result.solution, error, execution).at(error.at.place, execution);
    double noise = 0.0, basis = 0.0;
    for (std::size_t p = 0; p < error.points; ++p) {
        const auto row = static_cast<Eigen::Index>(p);
        noise += error.at.weight[p] * at.noise(row, 0) * at.noise(row, 0);
        basis += error.at.weight[p] * at.discretisation(row, 0) * at.discretisation(row, 0);
    }
    attempt.noise_share = noise + basis > 0.0 ? noise / (noise + basis) : 0.5;
    return attempt;
}

double error_of(const Attempt& attempt) {
    return attempt.goals ? std::max(*attempt.goals, 4.0 * attempt.rms * attempt.rms) : attempt.high;
}

double rays_of(const Effort& effort, std::size_t goals) {
    const auto product = [](std::size_t a, std::size_t b) { return static_cast<double>(a) * static_cast<double>(b); };
    return product(effort.sites, effort.rays) + product(goals * effort.goal_samples, effort.rays);
}

Effort next_effort(const Attempt& attempt, const ErrorTarget& target, std::size_t goals) {
    Effort next = attempt.effort;
    if (attempt.goals) {
        next_for_goals(attempt, target, goals, next);
    } else {
        const double wanted = margin * target.relative;
        const std::size_t twice = std::min(most_error_points, 2 * next.error_points);
        const bool wide = attempt.high > wide_interval * attempt.rms && next.error_points < next.sites;
        if ((wide || attempt.rms * interval_from(attempt, twice) <= wanted) && twice > next.error_points) {
            next.error_points = twice;
            return next;
        }
        const double rms = std::max(attempt.rms, attempt.high / 2.0 / most_interval);
        for (int pass = 0; pass < 10; ++pass) { // more sites are judged at more points, and need fewer more
            const double interval = interval_from(attempt, error_points_for(next.sites, attempt.effort.error_points));
            next = attempt.effort;
            const bool more_shadow_rays = add_shadow_rays(attempt, rms, wanted / interval, next);
            const double of_field = more_shadow_rays ? (1.0 - attempt.shadow_noise_share) / (1.0 - shadow_part) : 1.0;
            const double excess = of_field * std::pow(rms * interval / wanted, 2);
            if (!more_shadow_rays || excess > 1.0) {
                add_sites_and_rays(attempt, excess, next);
            }
        }
    }
    next.sites = std::min(next.sites, std::max(target.most_sites, attempt.effort.sites));
    next.error_points = error_points_for(next.sites, next.error_points);
    return next;
}

void reach_target(BakeResult& result, const std::function<void(BakeResult& attempt, const Execution& own)>& solve,
                  const Execution& execution) {
    TargetSearch(result, solve, execution).run();
}

} // namespace difusa
