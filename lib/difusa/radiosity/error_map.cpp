#include <difusa/radiosity/error_map.h>

#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/mesh/point_tree.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/field.h>
#include <difusa/radiosity/gathering_noise.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace difusa {

namespace {

/// The variance of the noise of N low-discrepancy rays falls as N to this power (measured; integrands have jumps).
constexpr double variance_decline = -1.5;

bool is_piecewise_constant(const std::vector<BasisRow>& rows) {
    return std::all_of(rows.begin(), rows.end(), [](const BasisRow& row) { return row.element.size() <= 1; });
}

/// Mean squares of the differences to the nearest elements of the region, as many as a patch has sides; those of all
/// others where a region has one element alone. #S by #channels.
Values variation_among_neighbours(const SiteSet& sites, const Values& coefficients, const Execution& execution) {
    constexpr std::size_t sides = 3;
    std::map<Index, std::vector<Index>> members; // of regions
    for (Index i = 0; i < sites.size(); ++i) {
        members[sites.region[i]].push_back(i);
    }
    std::map<Index, PointTree> trees;
    for (auto& [region, of_region] : members) {
        trees.emplace(region, PointTree(sites.points, std::move(of_region)));
    }
    Values variation = Values::Zero(coefficients.rows(), coefficients.cols());
    parallel_for(sites.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        std::array<Index, sides + 1> near{}; // the element itself is the nearest
        std::array<double, sides + 1> squared{};
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t found = trees.at(sites.region[i]).nearest(sites.points[i].position, near, squared);
            const auto own = static_cast<Eigen::Index>(i);
            for (std::size_t k = 0; k < found; ++k) {
                const Eigen::RowVectorXd miss =
                    coefficients.row(static_cast<Eigen::Index>(near[k])) - coefficients.row(own);
                variation.row(own) += miss.cwiseAbs2() / std::max(1.0, static_cast<double>(found) - 1.0);
            }
        }
    });
    std::vector<Eigen::Index> alone;
    for (Index i = 0; i < sites.size(); ++i) {
        if (trees.at(sites.region[i]).size() == 1) {
            alone.push_back(static_cast<Eigen::Index>(i)); // their rows are 0
        }
    }
    const auto others = static_cast<double>(std::max<std::size_t>(1, sites.size() - alone.size()));
    const Eigen::RowVectorXd mean = variation.colwise().sum() / others;
    for (const Eigen::Index i : alone) {
        variation.row(i) = mean;
    }
    return variation;
}

} // namespace

/// Sums of squares at a point over the channels, W²/m⁴.
struct ErrorMap::Local {
    struct Squares {
        double noise = 0.0, variation = 0.0;
        double carried = 0.0, cut_off = 0.0; ///< carried: with what is cut off, which has the same sign
        double light = 0.0, of_a_ray = 0.0;  ///< the light; the variance of what single rays bring
        double sum(double factor) const { return noise + factor * variation + carried; }
        void add(double factor, const Squares& other) {
            noise += factor * other.noise;
            variation += factor * other.variation;
            carried += factor * other.carried;
            cut_off += factor * other.cut_off;
            light += factor * other.light;
            of_a_ray += factor * other.of_a_ray;
        }
        /// The variance of the mean of two gathers with so many rays each.
        double of_gathers(double rays) const { return 0.5 * lattice_variance(light, of_a_ray / rays); }
    };
    Squares judged, irradiance;
};

ErrorsAt::ErrorsAt(std::size_t points)
    : noise(Values::Zero(static_cast<Eigen::Index>(points), 1)), discretisation(noise), error(noise),
      irradiance(noise) {}

ErrorMap::ErrorMap(const Solution& solution, const ErrorEstimate& estimate, const Execution& execution)
    : solution_(solution), estimate_(estimate),
      coefficients_(sum_of_parts(solution.field->parts().smooth, solution.field->channels())) {
    const Discretisation& discretisation = solution.field->parts().system->discretisation();
    noise_ = estimate.at.variance.topRows(static_cast<Eigen::Index>(discretisation.sites->size()));
    Values carried = Values::Zero(coefficients_.rows(), coefficients_.cols());
    for (const Values* const part : {&estimate.carried, &estimate.cut_off_light}) {
        if (part->rows() > 0) {
            carried += part->cwiseAbs();
        }
    }
    for (Eigen::Index c = 0; c < carried.cols(); ++c) {
        carried_[c] = discretisation.sites->mean(Values(carried.col(c).cwiseAbs2()));
    }
    std::vector<BasisRow> rows(estimate.at.size());
    discretisation.basis->evaluate(estimate.at.place, rows);
    if (is_piecewise_constant(rows)) {
        variation_ = variation_among_neighbours(*discretisation.sites, coefficients_, execution);
    }
    if (!estimate.of_irradiance) {
        noise_ *= of_rays(estimate, rows) * passed_on(estimate, rows, execution);
        judged_ = fit(estimate, rows, false);
        return;
    }
    const ErrorEstimate& other = *estimate.of_irradiance;
    std::vector<BasisRow> others(other.at.size());
    discretisation.basis->evaluate(other.at.place, others);
    noise_ *= of_rays(other, others) * passed_on(other, others, execution);
    judged_ = fit(estimate, rows, false);
    irradiance_ = fit(other, others, true);
}

/// The variance of the noise of a point of the system, over that of the light that its rays meet.
double ErrorMap::of_rays(const ErrorEstimate& told, const std::vector<BasisRow>& rows) const {
    const LightTransport& transport = solution_.field->parts().system->transport();
    const double rays =
        static_cast<double>(transport.rays) / static_cast<double>(std::max<std::size_t>(1, transport.points()));
    double measured = 0.0, expected = 0.0;
    for (std::size_t p = 0; p < rows.size(); ++p) {
        double here = 0.0;
        for (std::size_t k = 0; k < rows[p].element.size(); ++k) {
            const auto site = static_cast<Eigen::Index>(rows[p].element[k]);
            here += rows[p].weight[k] * told.at.variance_of_fresh.row(site).sum();
        }
        const auto gathered = static_cast<double>(std::max<std::size_t>(1, told.rays_per_gather[p]));
        measured += told.at.weight[p] * told.spread[p] * std::pow(rays / gathered, variance_decline);
        expected += told.at.weight[p] * std::max(0.0, here);
    }
    return expected > 0.0 ? measured / expected : 0.0;
}

/// What the projection makes of noise: the variance of the field at the error points if the light at the points is off
/// by random signs times its standard deviation, over what `local` expects of coefficients that are the light itself.
double ErrorMap::passed_on(const ErrorEstimate& told, const std::vector<BasisRow>& rows,
                           const Execution& execution) const {
    const Values& variance = told.at.variance;
    constexpr Eigen::Index probes = 4;
    const Discretisation& discretisation = solution_.field->parts().system->discretisation();
    Values probe(variance.rows(), probes);
    for (Eigen::Index i = 0; i < probe.rows(); ++i) {
        RandomStream stream(0, "signs", static_cast<std::uint64_t>(i));
        const double deviation = std::sqrt(variance.row(i).sum());
        for (Eigen::Index k = 0; k < probes; ++k) {
            probe(i, k) = stream.below(2) == 0 ? deviation : -deviation;
        }
    }
    const Values field = evaluate(*discretisation.basis, discretisation.evaluation->coefficients(probe, execution),
                                  told.at.place, execution);
    double got = 0.0, plain = 0.0;
    for (std::size_t p = 0; p < rows.size(); ++p) {
        const BasisRow& row = rows[p];
        double here = 0.0;
        for (std::size_t k = 0; k < row.element.size(); ++k) {
            here += row.weight[k] * row.weight[k] * variance.row(static_cast<Eigen::Index>(row.element[k])).sum();
        }
        got += told.at.weight[p] * field.row(static_cast<Eigen::Index>(p)).squaredNorm() / probes;
        plain += told.at.weight[p] * here;
    }
    return plain > 0.0 ? got / plain : 0.0;
}

ErrorMap::Local ErrorMap::local(const SurfacePoint& x, const BasisRow& row) const {
    const Eigen::Index channels = coefficients_.cols();
    Local local;
    const Rgb weights = judged_weight(*solution_.field->parts().scene, x);
    for (Eigen::Index c = 0; c < channels; ++c) {
        double f = 0.0, p = 0.0, noise = 0.0, variation = 0.0, all = 0.0, of_a_ray = 0.0, lost = 0.0;
        for (std::size_t k = 0; k < row.element.size(); ++k) {
            const auto i = static_cast<Eigen::Index>(row.element[k]);
            f += row.weight[k] * coefficients_(i, c);
            noise += row.weight[k] * row.weight[k] * noise_(i, c);
            of_a_ray += row.weight[k] * estimate_.at.variance_of_fresh(i, c);
            p += estimate_.carried.rows() > 0 ? row.weight[k] * estimate_.carried(i, c) : 0.0;
            lost += estimate_.cut_off_light.rows() > 0 ? row.weight[k] * estimate_.cut_off_light(i, c) : 0.0;
        }
        for (std::size_t k = 0; k < row.element.size(); ++k) {
            const double miss = coefficients_(static_cast<Eigen::Index>(row.element[k]), c) - f;
            variation +=
                std::abs(row.weight[k]) *
                (variation_.size() > 0 ? variation_(static_cast<Eigen::Index>(row.element[k]), c) : miss * miss);
            all += std::abs(row.weight[k]);
        }
        lost = std::max(0.0, lost);
        const double mean_variation = all > 0.0 ? variation / all : 0.0, carried = std::abs(p) + lost;
        const Local::Squares here{noise,       mean_variation, carried * carried,
                                  lost * lost, f * f,          std::max(0.0, of_a_ray)};
        local.judged.add(weights[c] * weights[c], here);
        local.irradiance.add(1.0, here);
    }
    return local;
}

ErrorMap::Fit ErrorMap::fit(const ErrorEstimate& told, const std::vector<BasisRow>& rows, bool of_irradiance) const {
    Fit fit;
    fit.ratio.assign(static_cast<std::size_t>(noise_.rows()), 0.0);
    fit.seen = fit.ratio;
    for (std::size_t p = 0; p < rows.size(); ++p) {
        const BasisRow& row = rows[p];
        const Local all = local(told.at.place[p], row);
        const Local::Squares& here = of_irradiance ? all.irradiance : all.judged;
        const double weight = told.at.weight[p];
        const double rest = weight * (told.squared[p] - here.noise - here.cut_off), variation = weight * here.variation;
        fit.mean_ratio += rest;
        fit.mean_seen += variation;
        for (std::size_t k = 0; k < row.element.size(); ++k) {
            fit.ratio[row.element[k]] += std::abs(row.weight[k]) * rest;
            fit.seen[row.element[k]] += std::abs(row.weight[k]) * variation;
        }
    }
    return fit;
}

/// Of the variation at a point.
double ErrorMap::Fit::factor(const BasisRow& row) const {
    double ratio_here = 0.0, seen_here = 0.0;
    for (std::size_t k = 0; k < row.element.size(); ++k) {
        ratio_here += std::abs(row.weight[k]) * ratio[row.element[k]];
        seen_here += std::abs(row.weight[k]) * seen[row.element[k]];
    }
    // Few points are around: their ratio is drawn towards that of all.
    const double mean = mean_seen > 0.0 ? std::max(0.0, mean_ratio / mean_seen) : 0.0;
    const double prior = 4.0 * mean_seen / static_cast<double>(ratio.size());
    return seen_here + prior > 0.0 ? std::max(0.0, (ratio_here + prior * mean) / (seen_here + prior)) : 0.0;
}

double ErrorMap::over_channels(double squares) const {
    return std::sqrt(squares / static_cast<double>(coefficients_.cols()));
}

void ErrorMap::put(const SurfacePoint& x, const BasisRow& row, std::size_t i, ErrorsAt& errors) const {
    const Local here = local(x, row);
    const double factor = judged_.factor(row),
                 of_irradiance = estimate_.of_irradiance ? irradiance_.factor(row) : factor;
    const auto at = static_cast<Eigen::Index>(i);
    errors.noise(at, 0) = over_channels(here.judged.noise);
    errors.discretisation(at, 0) = over_channels(factor * here.judged.variation);
    errors.error(at, 0) = over_channels(here.judged.sum(factor));
    errors.irradiance(at, 0) = over_channels(here.irradiance.sum(of_irradiance));
}

ErrorsAt ErrorMap::at(std::span<const SurfacePoint> x, const Execution& execution) const {
    const FieldParts& field = solution_.field->parts();
    ErrorsAt errors(x.size());
    parallel_for(x.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t i = begin; i < end; ++i) {
            field.system->discretisation().basis->evaluate(inset(field.scene->mesh, x[i]), row);
            put(x[i], row, i, errors);
        }
    });
    return errors;
}

ErrorsAt ErrorMap::gathered_at(std::span<const SurfacePoint> x, std::size_t rays, const Values& noise,
                               const Values& noise_of_irradiance, const Execution& execution) const {
    const Basis& basis = *solution_.field->parts().system->discretisation().basis;
    const double half = 0.5 * static_cast<double>(rays);
    ErrorsAt errors(x.size());
    parallel_for(x.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t i = begin; i < end; ++i) {
            basis.evaluate(inset(solution_.field->parts().scene->mesh, x[i]), row);
            Local here = local(x[i], row);
            if (row.element.empty()) { // what bounces carry on to it is not known: as much as elsewhere
                const Rgb weights = judged_weight(*solution_.field->parts().scene, x[i]);
                for (int c = 0; c < coefficients_.cols(); ++c) {
                    here.judged.carried += weights[c] * weights[c] * carried_[c];
                    here.irradiance.carried += carried_[c];
                }
            }
            const auto at = static_cast<Eigen::Index>(i);
            errors.noise(at, 0) = std::max(noise(at, 0), over_channels(here.judged.of_gathers(half)));
            errors.discretisation(at, 0) = over_channels(here.judged.carried);
            errors.error(at, 0) = std::hypot(errors.noise(at, 0), errors.discretisation(at, 0));
            errors.irradiance(at, 0) =
                std::hypot(std::max(noise_of_irradiance(at, 0), over_channels(here.irradiance.of_gathers(half))),
                           over_channels(here.irradiance.carried));
        }
    });
    return errors;
}

ErrorsAt ErrorMap::of(std::span<const SurfacePoint> x, const PointValues& values, const Execution& execution) const {
    if (values.gathered.size() == x.size()) { // after a final gather, mostly
        return gathered_at(x, values.rays_of_each, values.noise, values.noise_of_irradiance, execution);
    }
    ErrorsAt errors = at(x, execution);
    complete(x, values, errors, execution);
    return errors;
}

void ErrorMap::complete(std::span<const SurfacePoint> x, const PointValues& values, ErrorsAt& errors,
                        const Execution& execution) const {
    put_gathered(x, values, errors, execution);
    add_sharp(x, values.variance_of_sharp, errors);
}

void ErrorMap::add_sharp(std::span<const SurfacePoint> x, const Values& variance, ErrorsAt& errors) const {
    for (Eigen::Index i = 0; i < variance.rows(); ++i) {
        const double of_irradiance = variance.row(i).sum();
        if (!(of_irradiance > 0.0)) {
            continue;
        }
        const Rgb weights = judged_weight(*solution_.field->parts().scene, x[static_cast<std::size_t>(i)]);
        const Rgb squared = weights.square();
        double judged = 0.0;
        for (Eigen::Index c = 0; c < variance.cols(); ++c) {
            judged += squared[c] * variance(i, c);
        }
        for (Values* const error : {&errors.noise, &errors.error}) {
            (*error)(i, 0) = std::hypot((*error)(i, 0), over_channels(judged));
        }
        errors.irradiance(i, 0) = std::hypot(errors.irradiance(i, 0), over_channels(of_irradiance));
    }
}

void ErrorMap::put_gathered(std::span<const SurfacePoint> x, const PointValues& values, ErrorsAt& errors,
                            const Execution& execution) const {
    std::vector<SurfacePoint> points;
    for (const std::size_t i : values.gathered) {
        points.push_back(x[i]);
    }
    const ErrorsAt found =
        gathered_at(points, values.rays_of_each, values.noise, values.noise_of_irradiance, execution);
    for (std::size_t k = 0; k < points.size(); ++k) {
        const auto from = static_cast<Eigen::Index>(k), to = static_cast<Eigen::Index>(values.gathered[k]);
        errors.noise.row(to) = found.noise.row(from);
        errors.discretisation.row(to) = found.discretisation.row(from);
        errors.error.row(to) = found.error.row(from);
        errors.irradiance.row(to) = found.irradiance.row(from);
    }
}

} // namespace difusa
