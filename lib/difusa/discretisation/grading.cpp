#include <difusa/discretisation/grading.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t sites_at_once = 256;
constexpr double finest = 0.25;       ///< of the spacing there is
constexpr double least_others = 0.05; ///< weight of the other sites at one, below which they do not predict its value

constexpr double least_error = 0x1p-900; ///< relative to the largest; what is below asks for no finer sites

/// That of the largest error, rounded down to a multiple of 4; 0 if there is none.
int exponent_of_errors(const std::vector<double>& error) {
    const double largest = *std::max_element(error.begin(), error.end());
    if (!(largest > 0.0) || !std::isfinite(largest)) {
        return 0;
    }
    const int exponent = std::ilogb(largest);
    return exponent - ((exponent % 4) + 4) % 4;
}

} // namespace

Values leave_one_out(const Basis& basis, const SiteSet& sites, const Values& values, const Execution& execution) {
    const auto n = static_cast<Eigen::Index>(sites.size());
    DIFUSA_REQUIRE(values.rows() >= n);
    Values residual(n, values.cols());
    parallel_for(sites.size(), sites_at_once, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t i = begin; i < end; ++i) {
            basis.evaluate(sites.points[i], row);
            Eigen::RowVectorXd all = Eigen::RowVectorXd::Zero(values.cols());
            double own = 0.0;
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                all += row.weight[k] * values.row(static_cast<Eigen::Index>(row.element[k]));
                own += row.element[k] == i ? row.weight[k] : 0.0;
            }
            const auto value = values.row(static_cast<Eigen::Index>(i));
            if (1.0 - own >= least_others) {
                residual.row(static_cast<Eigen::Index>(i)) = (value - all) / (1.0 - own);
            } else {
                residual.row(static_cast<Eigen::Index>(i)) = value;
            }
        }
    });
    return residual;
}

double gain_of_grading(const std::vector<double>& error) {
    double largest = 0.0;
    for (const double each : error) {
        largest = std::max(largest, each);
    }
    if (!(largest > 0.0)) {
        return 1.0;
    }
    double sum = 0.0, squares = 0.0;
    for (const double each : error) {
        const double scaled = each / largest;
        sum += scaled;
        squares += scaled * scaled;
    }
    return squares * static_cast<double>(error.size()) / (sum * sum);
}

SizeField graded_spacing(const SiteSet& sites, const std::vector<double>& own, const std::vector<double>& error,
                         double largest, double wanted, Index region_count, const Execution& execution) {
    const std::size_t n = sites.size();
    DIFUSA_REQUIRE(n > 0 && own.size() == n && error.size() == n);
    // Errors relative to a power of two near the largest: small ones would overflow the quotient. Its exponent is a
    // multiple of 4, so that it passes through both roots below without rounding.
    const int exponent = exponent_of_errors(error);
    const auto unscaled = [&](std::size_t i) {
        return std::sqrt(own[i] / std::max(std::scalbn(error[i], -exponent), least_error));
    };
    SizeField field(sites.points, sites.region, std::vector<double>(n, largest), largest, region_count);
    const auto scale = [&](double factor) {
        std::vector<double> sizes(n);
        for (std::size_t i = 0; i < n; ++i) {
            const double least = finest * own[i];
            sizes[i] = error[i] > 0.0 ? std::clamp(factor * unscaled(i), least, std::max(least, largest)) : largest;
        }
        field.assign(std::move(sizes));
    };
    // Each of the sites stands for as many new ones as the squares of the spacings say.
    std::vector<double> share(n);
    const auto sites_with = [&](double factor) {
        scale(factor);
        parallel_for(n, sites_at_once, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
            for (std::size_t i = begin; i < end; ++i) {
                const double ratio = own[i] / field.placed_at(sites.points[i].position, sites.region[i]);
                share[i] = ratio * ratio;
            }
        });
        double sum = 0.0;
        for (const double each : share) {
            sum += each;
        }
        return sum;
    };
    // The number of sites falls as the factor grows; beyond `high` nothing is refined, below `low` everything is.
    double low = std::numeric_limits<double>::infinity(), high = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        if (error[i] > 0.0) {
            low = std::min(low, finest * own[i] / unscaled(i));
            high = std::max(high, largest / unscaled(i));
        }
    }
    if (!(high > 0.0)) {
        return field;
    }
    while (high > 1.01 * low) {
        const double middle = std::sqrt(low) * std::sqrt(high);
        if (!(low < middle && middle < high)) {
            break;
        }
        (sites_with(middle) > wanted ? low : high) = middle;
    }
    scale(high);
    return field;
}

} // namespace difusa
