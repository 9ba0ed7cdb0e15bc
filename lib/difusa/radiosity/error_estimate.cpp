#include <difusa/radiosity/error_estimate.h>

#include <difusa/core/frame.h>
#include <difusa/core/parallel.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/radiosity/exact_correction.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

namespace difusa {

namespace {

constexpr auto groups = static_cast<Eigen::Index>(ErrorPoints::groups); ///< p is known from each by itself

/// Irradiance at the error points that the solution has, and twice what it should be according to fresh rays: columns
/// are channels.
struct Measured {
    Values own, first, second;

    /// One measurement of weight (fresh - own), W/m².
    Values residual(const Values& fresh, const Values& weight) const { return (fresh - own).cwiseProduct(weight); }
};

/// The noise of light that is evaluated directly where it is displayed: it is independent of all else, takes few rays,
/// and is large in few places, penumbras. So it is measured at more points than the rest.
class NoiseOfDirect {
  public:
    NoiseOfDirect(const Solution& solution, std::uint64_t seed, const Execution& execution)
        : solution_(solution), seed_(seed), execution_(execution) {}

    bool any() const {
        const FieldParts& field = solution_.field->parts();
        return !field.direct_in_basis && field.direct->any();
    }

    /// Measures at points that are independent of those so far, drawn likewise.
    void add(const ErrorPoints& at) {
        if (!any()) {
            return;
        }
        const Field& field = *solution_.field;
        const std::string purpose = "error of direct light, from " + std::to_string(squares_.size());
        DirectLight::Effort effort;
        const auto once = [&](const char* which) {
            return sum_of_parts(field.sharp(at.place, seed_, purpose + which, execution_, effort), field.channels());
        };
        const Values own = once(", own"), first = once(", first") - own, second = once(", second") - own;
        segments_ += effort.segments;
        const double before = static_cast<double>(squares_.size()), added = static_cast<double>(at.size());
        for (double& weight : weight_) {
            weight *= before / (before + added);
        }
        for (std::size_t p = 0; p < at.size(); ++p) {
            const auto row = static_cast<Eigen::Index>(p);
            const Eigen::RowVectorXd weights =
                judged_weight(*field.parts().scene, at.place[p]).head(field.channels()).square().matrix().transpose();
            squares_.push_back(weights.dot(first.row(row).cwiseProduct(second.row(row))));
            weight_.push_back(at.weight[p] * added / (before + added));
        }
    }

    std::size_t points() const { return squares_.size(); }
    std::size_t segments() const { return segments_; }

    /// The mean square over the area, W²/m⁴.
    AreaMean mean() const {
        return squares_.empty() ? AreaMean{} : mean_over(solution_.field->parts().scene->mesh.area, weight_, squares_);
    }

  private:
    const Solution& solution_;
    std::uint64_t seed_;
    const Execution& execution_;
    std::vector<double> weight_, squares_; ///< #points; empty if there is no such light
    std::size_t segments_ = 0;
};

class Estimation {
  public:
    Estimation(const Solution& solution, ErrorPoints points, std::uint64_t seed, std::string purpose,
               const Execution& execution)
        : solution_(solution), field_(*solution.field), scene_(*field_.parts().scene), seed_(seed),
          purpose_(std::move(purpose)), execution_(execution) {
        result_.at = std::move(points);
        result_.points = result_.at.size();
        result_.largest_reflectance = largest_reflectance(scene_, field_.channels());
        rho_.resize(static_cast<Eigen::Index>(result_.points), field_.channels());
        weight_ = rho_;
        for (std::size_t p = 0; p < result_.points; ++p) {
            rho_.row(static_cast<Eigen::Index>(p)) =
                scene_.reflectance(result_.at.place[p]).head(field_.channels()).matrix().transpose();
            weight_.row(static_cast<Eigen::Index>(p)) =
                judged_weight(scene_, result_.at.place[p]).head(field_.channels()).matrix().transpose();
        }
    }

    /// Adds two measurements with so many rays each to those there are.
    void measure(std::size_t rays) {
        if (measured_rays_ == 0.0) {
            evaluate_solution();
        }
        if (const auto all = static_cast<std::size_t>(measured_rays_) + rays;
            field_.parts().sent && (!exact_ || all > exact_rays_)) {
            exact_rays_ = exact_ ? 2 * all : rays_of_exact * all;
            exact_ = std::make_unique<ExactCorrection>(field_.parts(), result_.at.place, exact_rays_, execution_);
        }
        measure_once(rays, purpose_ + ", first", &Measured::first);
        measure_once(rays, purpose_ + ", second", &Measured::second);
        if (measured_rays_ == 0.0) {
            result_.rays_per_gather.assign(result_.points, result_.rays / (2 * result_.points));
            for (Eigen::Index row = 0; row < smooth_.own.rows(); ++row) {
                result_.spread.push_back(0.5 * (smooth_.first.row(row) - smooth_.second.row(row)).squaredNorm());
            }
        }
        measured_rays_ += static_cast<double>(rays);
        purpose_ += ", more";
    }

    /// Adds other points, measured with as many rays.
    void join(const Estimation& other) {
        DIFUSA_REQUIRE(other.measured_rays_ == measured_rays_);
        const auto own = static_cast<double>(result_.points), others = static_cast<double>(other.result_.points);
        const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
        append(result_.at.place, other.result_.at.place);
        append(result_.at.weight, other.result_.at.weight);
        append(result_.at.surfel, other.result_.at.surfel);
        append(result_.at.group, other.result_.at.group);
        for (std::size_t p = 0; p < result_.at.size(); ++p) {
            result_.at.weight[p] *= (p < result_.points ? own : others) / (own + others);
        }
        append(result_.spread, other.result_.spread);
        append(result_.rays_per_gather, other.result_.rays_per_gather);
        result_.points += other.result_.points;
        result_.rays += other.result_.rays;
        result_.segments += other.result_.segments;
        const auto stack = [](Values& upper, const Values& lower) {
            Values both(upper.rows() + lower.rows(), upper.cols());
            both << upper, lower;
            upper = std::move(both);
        };
        stack(rho_, other.rho_);
        stack(weight_, other.weight_);
        if (cut_off_.rows() > 0) {
            stack(cut_off_, other.cut_off_);
        }
        for (Measured Estimation::*const each : {&Estimation::indirect_, &Estimation::smooth_, &Estimation::shown_}) {
            for (Values Measured::*const which : {&Measured::own, &Measured::first, &Measured::second}) {
                stack(this->*each.*which, other.*each.*which);
            }
        }
        stack(all_light_, other.all_light_);
        exact_.reset();
    }

    /// The mean square of the noise of r over that of r; infinite where r cannot be told from 0.
    double noise_over_residual() const {
        const double noise = rms_of(0.5 * (shown_.first - shown_.second).cwiseProduct(weight_));
        if (noise <= rounding * rms_of(all_light_.cwiseProduct(weight_))) {
            return 0.0;
        }
        const double residual = mean_over(scene_.mesh.area, result_.at.weight, squares(shown_, false)).value;
        return residual > 0.0 ? noise * noise / residual : std::numeric_limits<double>::infinity();
    }

    /// Estimates the error from all measurements.
    void conclude(const NoiseOfDirect& direct) {
        carry();
        judge(direct.mean());
    }
    /// The same, after more has been learnt of directly evaluated light alone.
    void conclude_again(const NoiseOfDirect& direct) { judge(direct.mean()); }

    /// What has been measured of the irradiance itself, for ErrorEstimate::of_irradiance.
    ErrorEstimate of_irradiance() {
        weight_.setOnes();
        result_.squared = squares(shown_, false);
        return result_;
    }

    /// The standard error of the mean square without directly evaluated light, W²/m⁴.
    double doubt() const { return doubt_; }

    /// `wanted`: FurtherRounds::limit.
    bool is_undecided(double wanted) const {
        if (wanted > 0.0) {
            const double limit = wanted * result_.reflected;
            return result_.total.high > limit && 0.5 * (result_.total.rms + result_.total.high) < limit;
        }
        const auto is_wide = [&](const RmsEstimate& error) {
            return error.high > std::max(too_much * error.rms, rounding * result_.reflected);
        };
        const bool matters = result_.indirect.high > part_of_total * result_.total.rms;
        // The mean square may be mostly noise, or a few large values: then its upper end says little.
        const bool is_chance = result_.total.low == 0.0 && result_.total.high > rounding * result_.reflected;
        return is_chance || is_wide(result_.total) || (matters && is_wide(result_.indirect));
    }

    const ErrorEstimate& result() const { return result_; }

  private:
    static constexpr double too_much = 2.1;      ///< of the upper end, over the estimate
    static constexpr double part_of_total = 0.5; ///< of the indirect error, below which it need not be told closer
    static constexpr double rounding = 1e-9;     ///< of errors, over the light
    static constexpr std::size_t places_around = 64;
    static constexpr std::size_t rays_of_exact = 8; ///< over those of the first measurement

    /// The root of the mean over the area of the squares of all channels.
    double rms_of(const Values& values) const {
        double sum = 0.0;
        for (std::size_t p = 0; p < result_.points; ++p) {
            sum += result_.at.weight[p] * values.row(static_cast<Eigen::Index>(p)).squaredNorm();
        }
        return std::sqrt(sum / scene_.mesh.area);
    }

    Values sum(const Values& H) const { return sum_of_parts(H, field_.channels()); }

    void evaluate_solution() {
        const std::vector<SurfacePoint>& x = result_.at.place;
        const Irradiance own = field_.evaluate_smooth(x, execution_);
        const Irradiance shown = field_.evaluate_smooth(x, execution_, true); // what is judged
        indirect_.own = sum(shown.indirect);
        smooth_.own = sum(own.direct) + sum(own.indirect);
        shown_.own = sum(shown.direct) + sum(shown.indirect);
        all_light_ = shown_.own;
        result_.cut_off_light = cut_off_coefficients(solution_, execution_);
        if (result_.cut_off_light.rows() > 0) {
            const Basis& basis = *field_.parts().system->discretisation().basis;
            cut_off_ = evaluate(basis, result_.cut_off_light, x, execution_).cwiseMax(0.0);
        }
        if (!field_.parts().direct_in_basis) {
            DirectLight::Effort effort;
            all_light_ += sum(field_.sharp(x, seed_, purpose_ + ", own", execution_, effort));
            result_.segments += effort.segments;
        }
        field_.parts().system->discretisation().averages->apply(field_.parts().smooth, means_.smooth, execution_);
        means_.first_bounce = solution_.light.first_bounce();
        means_.even = solution_.light.even;
    }

    void measure_once(std::size_t rays, const std::string& purpose, Values Measured::*which) {
        const std::vector<SurfacePoint>& x = result_.at.place;
        DirectLight::Effort effort;
        const Irradiance fresh = field_.gather_by_surfels(x, means_, exact_.get(), rays, seed_, purpose, execution_);
        const double share = static_cast<double>(rays) / (measured_rays_ + static_cast<double>(rays));
        const auto add = [share, which](Measured& to, const Values& value) {
            Values& mean = to.*which;
            mean = mean.size() == 0 ? value : Values((1.0 - share) * mean + share * value);
        };
        Values indirect = sum(fresh.indirect);
        if (cut_off_.rows() > 0) {
            indirect += cut_off_;
        }
        Values smooth = indirect + sum(fresh.direct);
        if (field_.parts().direct_in_basis) {
            smooth += sum(field_.sharp(x, seed_, purpose, execution_, effort));
        }
        result_.rays += fresh.rays;
        result_.segments += fresh.segments + effort.segments;
        add(indirect_, indirect);
        add(smooth_, smooth);
        add(shown_, smooth);
    }

    /// The surfels at places spread over a disc of the area that point p stands for, as far as it is on the face of p.
    /// All of its residual on a single small surfel would be a spike of light on what is close by, as across the edge
    /// of a wall, and one such spike could outweigh all other points.
    void surfels_around(std::size_t p, std::vector<Index>& around) const {
        const Surfels& surfels = *field_.parts().system->discretisation().surfels;
        const SurfacePoint& x = result_.at.place[p];
        around.assign(1, result_.at.surfel[p]);
        if (result_.at.weight[p] <= surfels.area(around.front())) {
            return;
        }
        const auto [a, b, c] = scene_.mesh.corners(x.face);
        Eigen::Matrix<double, 3, 2> sides;
        sides << b - a, c - a;
        Vec3 s, t;
        tangents(scene_.mesh.normals[x.face], s, t);
        const Eigen::Matrix2d to_uv = (sides.transpose() * sides).inverse() * sides.transpose() *
                                      (Eigen::Matrix<double, 3, 2>() << s, t).finished();
        const double radius = std::sqrt(result_.at.weight[p] / std::numbers::pi);
        for (std::size_t k = 1; k < places_around; ++k) {
            // A spiral that is even over the disc.
            const double r = radius * std::sqrt(static_cast<double>(k) / static_cast<double>(places_around)),
                         angle = static_cast<double>(k) * std::numbers::pi * (3.0 - std::sqrt(5.0));
            const Eigen::Vector2d uv =
                Eigen::Vector2d(x.u, x.v) + to_uv * Eigen::Vector2d(r * std::cos(angle), r * std::sin(angle));
            if (uv.minCoeff() < 0.0 || uv.sum() > 1.0) {
                continue;
            }
            if (const Index other = surfels.at(x.face, uv[0], uv[1]); surfels.area(other) > 0.0) {
                around.push_back(other);
            }
        }
    }

    /// p from each group of points by itself, with the residuals spread over the surfels around the points.
    void carry() {
        const Discretisation& discretisation = field_.parts().system->discretisation();
        const Surfels& surfels = *discretisation.surfels;
        const Eigen::Index channels = field_.channels();
        const Values residual = 0.5 * (smooth_.residual(smooth_.first, rho_) + smooth_.residual(smooth_.second, rho_));
        Values b = Values::Zero(static_cast<Eigen::Index>(surfels.size()), channels * groups);
        std::vector<Index> around;
        for (std::size_t p = 0; p < result_.points; ++p) {
            surfels_around(p, around);
            const double power =
                static_cast<double>(groups) * result_.at.weight[p] / static_cast<double>(around.size());
            for (const Index s : around) {
                b.row(s).segment(group_of(p) * channels, channels) +=
                    power / surfels.area(s) * residual.row(static_cast<Eigen::Index>(p));
            }
        }
        const SolveOptions solve{.tolerance = 0.05, .max_iterations = 50, .confirm = false};
        const Values h = field_.parts().system->respond(solution_.light.reflectance, b, solve, execution_.silent());
        const Values c = discretisation.evaluation->coefficients(h, execution_);
        result_.carried = sum_of_parts(c, static_cast<int>(channels)) / static_cast<double>(groups);
        carried_ = evaluate(*discretisation.basis, c, result_.at.place, execution_);
    }

    Eigen::Index group_of(std::size_t p) const { return static_cast<Eigen::Index>(result_.at.group[p]); }

    /// p at point number `p`, from group `g`.
    Eigen::RowVectorXd carried(std::size_t p, Eigen::Index g) const {
        const auto row = static_cast<Eigen::Index>(p);
        return carried_.row(row).segment(g * field_.channels(), field_.channels()).cwiseProduct(weight_.row(row));
    }

    /// The same from one half of the other groups: 0 or 1.
    Eigen::RowVectorXd carried_by_half(std::size_t p, Eigen::Index half) const {
        constexpr Eigen::Index count = (groups - 1) / 2;
        Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(field_.channels());
        for (Eigen::Index k = 0; k < count; ++k) {
            sum += carried(p, (group_of(p) + 1 + half * count + k) % groups);
        }
        return sum / static_cast<double>(count);
    }

    /// |e|² at each point if e = r + p, from two measurements of r and from p as the two halves of the other groups
    /// know it.
    std::vector<double> squares(const Measured& measured, bool with_carried) const {
        const Values r_1 = measured.residual(measured.first, weight_),
                     r_2 = measured.residual(measured.second, weight_);
        std::vector<double> squares(result_.points);
        for (std::size_t p = 0; p < result_.points; ++p) {
            const auto row = static_cast<Eigen::Index>(p);
            Eigen::RowVectorXd e_1 = r_1.row(row), e_2 = r_2.row(row);
            if (with_carried) {
                e_1 += carried_by_half(p, 0);
                e_2 += carried_by_half(p, 1);
            }
            squares[p] = e_1.dot(e_2);
        }
        return squares;
    }

    /// |p|² at each point, likewise.
    std::vector<double> carried_squares() const {
        std::vector<double> squares(result_.points);
        for (std::size_t p = 0; p < result_.points; ++p) {
            squares[p] = carried_by_half(p, 0).dot(carried_by_half(p, 1));
        }
        return squares;
    }

    /// Adds to the standard error of the mean of |r + p|² that of p, which all points share: of 2 <r + p, p>, from the
    /// differences between the groups, each at the points of the others. Without `measured`, r = 0.
    AreaMean with_doubt_of_carried(AreaMean mean, const Measured* measured) const {
        std::array<double, ErrorPoints::groups> overlap{};
        const Values r = measured == nullptr ? Values(Values::Zero(rho_.rows(), rho_.cols()))
                                             : Values(0.5 * (measured->residual(measured->first, weight_) +
                                                             measured->residual(measured->second, weight_)));
        for (std::size_t p = 0; p < result_.points; ++p) {
            // Without its own group: what it sends on may be a spike where it is.
            constexpr auto others = static_cast<double>(groups - 1);
            const double share = (others + 1.0) / others * result_.at.weight[p] / scene_.mesh.area;
            const Eigen::RowVectorXd sum = 0.5 * others * (carried_by_half(p, 0) + carried_by_half(p, 1));
            for (Eigen::Index k = 1; k < groups; ++k) {
                const Eigen::Index g = (group_of(p) + k) % groups;
                const Eigen::RowVectorXd one = carried(p, g), rest = (sum - one) / (others - 1.0);
                overlap[static_cast<std::size_t>(g)] += share * (r.row(static_cast<Eigen::Index>(p)) + rest).dot(one);
            }
        }
        double centre = 0.0, squares = 0.0;
        for (const double each : overlap) {
            centre += each / static_cast<double>(groups);
        }
        for (const double each : overlap) {
            squares += (each - centre) * (each - centre) / static_cast<double>(groups - 1);
        }
        mean.deviation = std::hypot(mean.deviation, 2.0 * std::sqrt(squares / static_cast<double>(groups)));
        return mean;
    }

    void judge(const AreaMean& noise_of_direct) {
        const double area = scene_.mesh.area;
        const ErrorPoints& at = result_.at;
        result_.squared = squares(shown_, false);
        result_.noise_of_direct = std::sqrt(std::max(0.0, noise_of_direct.value));
        result_.cut_off = cut_off_.rows() > 0 ? rms_of(cut_off_.cwiseProduct(weight_)) : 0.0;
        const auto displayed = [&](const AreaMean& smooth) { return root_of(sum_of(smooth, noise_of_direct)); };
        result_.residual = displayed(mean_over(area, at.weight, squares(shown_, false)));
        const AreaMean shown = with_doubt_of_carried(mean_over(area, at.weight, squares(shown_, true)), &shown_);
        doubt_ = shown.deviation;
        result_.total = displayed(shown);
        result_.indirect =
            root_of(with_doubt_of_carried(mean_over(area, at.weight, squares(indirect_, true)), &indirect_));
        result_.carried_rms = root_of(with_doubt_of_carried(mean_over(area, at.weight, carried_squares()), nullptr));
        std::vector<double> reflected(result_.points);
        for (std::size_t p = 0; p < result_.points; ++p) {
            const auto row = static_cast<Eigen::Index>(p);
            reflected[p] = all_light_.row(row).cwiseProduct(weight_.row(row)).squaredNorm();
        }
        result_.reflected = std::sqrt(mean_over(area, at.weight, reflected).value);
        const double rho = result_.largest_reflectance;
        result_.bound = result_.residual.high == 0.0 ? 0.0
                        : rho < 1.0                  ? result_.residual.high / (1.0 - rho)
                                                     : std::numeric_limits<double>::infinity();
        // What is carried on is known from few points, and may come out larger than the residual allows.
        if (rho < 1.0) {
            result_.total.rms = std::min(result_.total.rms, result_.residual.rms / (1.0 - rho));
            result_.total.low = std::min(result_.total.low, result_.total.rms);
            result_.total.high = std::min(result_.total.high, result_.bound);
        }
    }

    const Solution& solution_;
    const Field& field_;
    const Scene& scene_;
    std::uint64_t seed_;
    std::string purpose_; ///< of the next rays: each has random numbers of its own
    const Execution& execution_;
    Values rho_, weight_;                          ///< #points by #channels, as all below; weight_: judged_weight
    std::unique_ptr<const ExactCorrection> exact_; ///< null: there are no exact form factors
    std::size_t exact_rays_ = 0;                   ///< for which it is exact enough
    Field::SurfelMeans means_;
    /// Indirect light; that of which the residuals are carried on; and that which the basis displays.
    Measured indirect_, smooth_, shown_;
    Values all_light_; ///< of the solution
    double doubt_ = 0.0;
    double measured_rays_ = 0.0; ///< in each measurement, for each point
    Values cut_off_;             ///< ErrorEstimate::cut_off_light there; no rows: none
    Values carried_;             ///< #points by #groups #channels: p / rho
    ErrorEstimate result_;
};

/// Chooses how many points are measured with how many rays.
class Measurements {
  public:
    Measurements(const Solution& solution, std::uint64_t seed, const Execution& execution)
        : solution_(solution), seed_(seed), execution_(execution), sampler_(solution, execution) {}

    ErrorEstimate run(std::size_t points, std::size_t rays, const FurtherRounds& further) {
        ErrorPoints drawn = sampler_.draw(points, seed_);
        if (drawn.size() == 0) {
            return Estimation(solution_, std::move(drawn), seed_, "", execution_).result();
        }
        const std::size_t asked = rays;
        NoiseOfDirect direct(solution_, seed_, execution_);
        direct.add(drawn);
        Estimation estimation =
            further.most > 0 && further.limit == 0.0 ? balanced(drawn, rays) : measured(drawn, rays, "error");
        estimation.conclude(direct);
        for (std::size_t round = 1; round <= further.most && estimation.is_undecided(further.limit); ++round) {
            const std::string purpose = "error, round " + std::to_string(round);
            const auto other_points = [&](std::size_t count) {
                return sampler_.draw(count, RandomStream(seed_, purpose).bits());
            };
            if (direct.mean().deviation > estimation.doubt()) {
                direct.add(other_points(direct.points()));
                estimation.conclude_again(direct);
                continue;
            }
            if (const std::size_t count = estimation.result().points;
                further.limit > 0.0 || count > most_points || estimation.noise_over_residual() > balanced_noise) {
                rays *= 2;
                add_rays(estimation, rays);
            } else {
                estimation.join(measured(other_points(count), all_rays_, purpose));
            }
            estimation.conclude(direct);
        }
        ErrorEstimate result = estimation.result();
        result.rays += replaced_rays_;
        result.segments += replaced_segments_ + direct.segments();
        return with_irradiance(std::move(result), asked);
    }

  private:
    static constexpr std::size_t most_points = std::size_t{1} << 16U;
    /// The mean square of noise, over that of the residual, that leaves as much doubt as the number of points. The
    /// relative variance of a mean of n products is (2 k + 4 q + 4 q²) / n with this ratio q, where k is 1 if residuals
    /// are normally distributed, and about 2 with their heavy tails.
    static constexpr double balanced_noise = 0.6;
    static constexpr double most_rays = 8.0; ///< of each point, over those asked for, before further rounds
    static constexpr double of_noise = 1.5;  ///< squared noise falls with the rays to this power

    static std::size_t scaled(std::size_t count, double factor) {
        return static_cast<std::size_t>(std::llround(static_cast<double>(count) * factor));
    }

    /// With how many times as many rays the noise is balanced, at most `most_rays`.
    static double more_rays(const Estimation& estimation) {
        return std::clamp(std::pow(estimation.noise_over_residual() / balanced_noise, 1.0 / of_noise), 1.0, most_rays);
    }

    /// Measures some points first. Where their noise is much larger than their residuals, fewer points with more rays
    /// each tell more: the doubt that noise leaves falls with the rays to the power 1.5, that of the points with the
    /// root of their number. `rays`: of each point; then half of them all, so that the first further round doubles
    /// them.
    Estimation balanced(const ErrorPoints& drawn, std::size_t& rays) {
        RandomStream stream(seed_, "fewer error points");
        const bool are_few = drawn.size() < 2 * few_error_points;
        std::optional<Estimation> chosen(
            measured(are_few ? drawn : fewer_points(drawn, few_error_points, stream), rays, "error"));
        const double more = more_rays(*chosen);
        const std::size_t of_each = scaled(rays, more), points = scaled(drawn.size(), 1.0 / more);
        if (points > chosen->result().points) {
            replaced_rays_ = chosen->result().rays;
            replaced_segments_ = chosen->result().segments;
            chosen.emplace(measured(fewer_points(drawn, points, stream), of_each, "error, all"));
        } else if (of_each > rays) {
            add_rays(*chosen, of_each - rays);
        }
        // Large residuals by chance, which hide the noise, would otherwise be believed.
        for (int check = 0; check < 2 && chosen->noise_over_residual() > balanced_noise; ++check) {
            const double most = most_rays * static_cast<double>(rays) / static_cast<double>(all_rays_);
            if (const std::size_t added = scaled(all_rays_, std::min(most, std::max(1.25, more_rays(*chosen))) - 1.0);
                added > 0) {
                add_rays(*chosen, added);
            }
        }
        rays = (all_rays_ + 1) / 2;
        return std::move(*chosen);
    }

    void add_rays(Estimation& estimation, std::size_t rays) {
        estimation.measure(rays);
        all_rays_ += rays;
    }

    ErrorEstimate with_irradiance(ErrorEstimate result, std::size_t rays) const {
        if (sampler_.is_blind()) {
            const ErrorPointSampler all(solution_, execution_, ErrorPointSampler::Of::irradiance);
            Estimation estimation(solution_, all.draw(2 * few_error_points, seed_), seed_, "irradiance", execution_);
            estimation.measure(rays);
            result.of_irradiance = std::make_shared<const ErrorEstimate>(estimation.of_irradiance());
            result.rays += result.of_irradiance->rays;
            result.segments += result.of_irradiance->segments;
        }
        return result;
    }

    Estimation measured(ErrorPoints points, std::size_t rays, const std::string& purpose) {
        Estimation estimation(solution_, std::move(points), seed_, purpose, execution_);
        estimation.measure(rays);
        all_rays_ = rays;
        return estimation;
    }

    const Solution& solution_;
    std::uint64_t seed_;
    const Execution& execution_;
    ErrorPointSampler sampler_;
    std::size_t all_rays_ = 0;                              ///< of each measurement of each point
    std::size_t replaced_rays_ = 0, replaced_segments_ = 0; ///< cast for points that have been replaced
};

} // namespace

ErrorEstimate estimate_error(const Solution& solution, std::size_t points, std::size_t rays, std::uint64_t seed,
                             const FurtherRounds& further, const Execution& execution) {
    return Measurements(solution, seed, execution).run(points, rays, further);
}

void judge_gathered(ErrorEstimate& estimate, double noise) {
    const auto with_noise = [&](double carried) { return std::hypot(carried, noise); };
    const RmsEstimate& carried = estimate.carried_rms;
    const double cut_off = estimate.cut_off; // of the rays that gather; it has the sign of what bounces carry on
    estimate.total = {with_noise(carried.rms + cut_off), with_noise(carried.low + cut_off),
                      with_noise(carried.high + cut_off)};
    estimate.indirect = estimate.total;
    estimate.noise = noise;
    const double rho = estimate.largest_reflectance;
    estimate.bound = rho > 0.0 ? rho * estimate.bound + noise : noise;
}

} // namespace difusa
