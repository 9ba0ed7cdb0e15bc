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
#include <string>

namespace difusa {

namespace {

constexpr auto groups = static_cast<Eigen::Index>(ErrorPoints::groups); ///< p is known from each by itself

/// The mean of `values` over the area, its standard error, how many points of equal values would leave as much doubt
/// (Kish 1965), and by how much a point raises the mean at most.
struct Mean {
    double value = 0.0, deviation = 0.0, effective = 1.0, largest = 0.0;
};

/// The weights sum to a known area, so that only the deviations from the mean leave doubt.
Mean mean_over(const ErrorPoints& at, double area, const std::vector<double>& values) {
    const auto n = static_cast<double>(at.size());
    double weights = 0.0, sum = 0.0;
    for (std::size_t p = 0; p < at.size(); ++p) {
        weights += at.weight[p];
        sum += at.weight[p] * values[p];
    }
    Mean mean;
    mean.value = sum / area;
    double squares = 0.0, deviations = 0.0;
    for (std::size_t p = 0; p < at.size(); ++p) {
        const double share = at.weight[p] / area * values[p];
        const double deviation = at.weight[p] / area * (values[p] - sum / weights);
        squares += share * share;
        deviations += deviation * deviation;
        mean.largest = std::max(mean.largest, deviation);
    }
    mean.deviation = std::sqrt(deviations * n / std::max(1.0, n - 1.0));
    mean.effective = squares > 0.0 ? mean.value * mean.value / squares : n;
    return mean;
}

/// The 97.5 % quantile of Student's t, to 1 % for 4 degrees of freedom and more (Fisher and Cornish 1960).
double quantile(double freedom) {
    freedom = std::max(freedom, 4.0);
    return 1.95996 + 2.37227 / freedom + 2.82250 / (freedom * freedom) + 2.5556 / (freedom * freedom * freedom);
}

/// With a confidence of 97.5 %, no more than this many of n points would fall where none has (e^-3.69 = 2.5 %).
constexpr double unseen_points = 3.69;

/// The root of a mean of squares. Where the mean is known well enough, the interval is one of its logarithm: a few
/// large values make the distribution of means a skew one. Squared errors have heavy tails, of which the points may
/// have missed a part; the upper end allows for as many points as may have been missed, with the largest share that was
/// seen.
RmsEstimate root_of(const Mean& mean) {
    const auto root = [](double square) { return std::sqrt(std::max(0.0, square)); };
    const double reach = quantile(mean.effective - 1.0) * mean.deviation;
    const double unseen = unseen_points * mean.largest;
    if (mean.value > 3.0 * mean.deviation) {
        const double factor = std::exp(reach / mean.value);
        return {root(mean.value), root(mean.value / factor), root(mean.value * factor + unseen)};
    }
    return {root(mean.value), root(mean.value - reach), root(mean.value + reach + unseen)};
}

/// Irradiance at the error points that the solution has, and twice what it should be according to fresh rays: columns
/// are channels.
struct Measured {
    Values own, first, second;

    /// One measurement of weight (fresh - own), W/m².
    Values residual(const Values& fresh, const Values& weight) const { return (fresh - own).cwiseProduct(weight); }
};

class Estimation {
  public:
    Estimation(const Solution& solution, std::size_t points, std::uint64_t seed, const Execution& execution)
        : solution_(solution), field_(*solution.field), scene_(*field_.parts().scene), seed_(seed),
          execution_(execution) {
        result_.at = draw_error_points(solution, points, seed, execution);
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

    ErrorEstimate run(std::size_t rays, const FurtherRounds& further) {
        if (result_.points == 0) {
            return std::move(result_);
        }
        evaluate_solution();
        if (field_.parts().sent) {
            exact_ =
                std::make_unique<ExactCorrection>(field_.parts(), result_.at.place, rays_of_exact * rays, execution_);
        }
        measure(rays, "error");
        result_.rays_per_gather = result_.rays / (2 * result_.points);
        for (std::size_t p = 0; p < result_.points; ++p) {
            const auto row = static_cast<Eigen::Index>(p);
            result_.spread.push_back(0.5 * (smooth_.first.row(row) - smooth_.second.row(row)).squaredNorm());
        }
        carry();
        judge();
        for (std::size_t round = 1; round <= further.most && is_undecided(further.limit); ++round) {
            rays *= 2;
            measure(rays, "error, round " + std::to_string(round));
            carry();
            judge();
        }
        return std::move(result_);
    }

  private:
    static constexpr double too_much = 2.0;  ///< of the upper end, over the estimate
    static constexpr double rounding = 1e-9; ///< of errors, over the light
    static constexpr std::size_t places_around = 64;
    static constexpr std::size_t rays_of_exact = 8; ///< over those of the first round: more than all rounds have

    /// `wanted`: FurtherRounds::limit.
    bool is_undecided(double wanted) const {
        if (wanted > 0.0) {
            const double limit = wanted * result_.reflected;
            return result_.total.high > limit && 0.5 * (result_.total.rms + result_.total.high) < limit;
        }
        const auto is_wide = [&](const RmsEstimate& error) {
            return error.high > std::max(too_much * error.rms, rounding * result_.reflected);
        };
        return is_wide(result_.total) || is_wide(result_.indirect);
    }

    Values sum(const Values& H) const { return sum_of_parts(H, field_.channels()); }

    void evaluate_solution() {
        const std::vector<SurfacePoint>& x = result_.at.place;
        const Irradiance own = field_.evaluate_smooth(x, execution_);
        const Irradiance shown = field_.evaluate_smooth(x, execution_, true); // what is judged
        indirect_.own = sum(shown.indirect);
        smooth_.own = sum(own.direct) + sum(own.indirect);
        total_.own = sum(shown.direct) + sum(shown.indirect);
        if (!field_.parts().direct_in_basis) {
            DirectLight::Effort effort;
            total_.own += sum(field_.sharp(x, seed_, "error, own", execution_, effort));
            result_.segments += effort.segments;
        }
        const RadiositySystem& system = *field_.parts().system;
        system.discretisation().averages->apply(field_.parts().smooth, means_, execution_);
    }

    /// Adds two measurements to those there are.
    void measure(std::size_t rays, const std::string& purpose) {
        measure_once(rays, purpose + ", first", &Measured::first);
        measure_once(rays, purpose + ", second", &Measured::second);
        measured_rays_ += static_cast<double>(rays);
    }

    void measure_once(std::size_t rays, const std::string& purpose, Values Measured::*which) {
        const std::vector<SurfacePoint>& x = result_.at.place;
        DirectLight::Effort effort;
        const Irradiance fresh = field_.gather_by_surfels(x, means_, exact_.get(), rays, seed_, purpose, execution_);
        const Values sharp = sum(field_.sharp(x, seed_, purpose, execution_, effort));
        result_.rays += fresh.rays;
        result_.segments += fresh.segments + effort.segments;
        const double share = static_cast<double>(rays) / (measured_rays_ + static_cast<double>(rays));
        const auto add = [share, which](Measured& to, const Values& value) {
            Values& mean = to.*which;
            mean = mean.size() == 0 ? value : Values((1.0 - share) * mean + share * value);
        };
        const Values indirect = sum(fresh.indirect), smooth = indirect + sum(fresh.direct), total = smooth + sharp;
        add(indirect_, indirect);
        add(smooth_, field_.parts().direct_in_basis ? total : smooth);
        add(total_, total);
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
        SolveOptions solve;
        solve.tolerance = 0.05;
        solve.max_iterations = 50;
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
    Mean with_doubt_of_carried(Mean mean, const Measured* measured) const {
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

    void judge() {
        const double area = scene_.mesh.area;
        const ErrorPoints& at = result_.at;
        result_.squared = squares(total_, false);
        result_.residual = root_of(mean_over(at, area, result_.squared));
        result_.total = root_of(with_doubt_of_carried(mean_over(at, area, squares(total_, true)), &total_));
        result_.indirect = root_of(with_doubt_of_carried(mean_over(at, area, squares(indirect_, true)), &indirect_));
        result_.carried_rms = root_of(with_doubt_of_carried(mean_over(at, area, carried_squares()), nullptr));
        std::vector<double> reflected(result_.points);
        for (std::size_t p = 0; p < result_.points; ++p) {
            const auto row = static_cast<Eigen::Index>(p);
            reflected[p] = total_.own.row(row).cwiseProduct(weight_.row(row)).squaredNorm();
        }
        result_.reflected = std::sqrt(mean_over(at, area, reflected).value);
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
    const Execution& execution_;
    Values rho_, weight_;                          ///< #points by #channels, as all below; weight_: judged_weight
    std::unique_ptr<const ExactCorrection> exact_; ///< null: there are no exact form factors
    Values means_; ///< #surfels by the channels of each set in turn: Field::gather_by_surfels
    Measured indirect_, smooth_, total_;
    double measured_rays_ = 0.0; ///< in each measurement, for each point
    Values carried_;             ///< #points by #groups #channels: p / rho
    ErrorEstimate result_;
};

} // namespace

double largest_reflectance(const Scene& scene, int channels) {
    const Mesh& mesh = scene.mesh;
    double largest = 0.0;
    const auto add = [&](const Rgb& rho, const Rgb& specular) {
        const Rgb product =
            (rho > 0.0).select(rho / (1.0 - specular).max(rho), 0.0); // at most 1, whatever the rounding
        largest = std::max(largest, channels == 1 ? product[0] : product.maxCoeff());
    };
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Material& material = scene.materials[mesh.material[t]];
        const Rgb factor = material.reflectance_texture ? material.reflectance_texture->brightest() : Rgb(Rgb::Ones());
        if (material.vertex_colours) {
            for (const Rgb& rho : mesh.corner_reflectance[t]) {
                add(factor * rho, material.specular());
            }
        } else {
            add(factor * material.reflectance, material.specular());
        }
    }
    return largest;
}

ErrorEstimate estimate_error(const Solution& solution, std::size_t points, std::size_t rays, std::uint64_t seed,
                             const FurtherRounds& further, const Execution& execution) {
    return Estimation(solution, points, seed, execution).run(rays, further);
}

void judge_gathered(ErrorEstimate& estimate, double noise) {
    const auto with_noise = [&](double carried) { return std::hypot(carried, noise); };
    const RmsEstimate& carried = estimate.carried_rms;
    estimate.total = {with_noise(carried.rms), with_noise(carried.low), with_noise(carried.high)};
    estimate.indirect = estimate.total;
    estimate.noise = noise;
    const double rho = estimate.largest_reflectance;
    estimate.bound = rho > 0.0 ? rho * estimate.bound + noise : noise;
}

} // namespace difusa
