#include <difusa/study/metrics.h>

#include <difusa/core/colour.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace difusa {

namespace {

/// Compensated summation (Neumaier 1974): signed errors cancel.
class Sum {
  public:
    void add(double term) {
        const double sum = sum_ + term;
        carried_ += std::abs(sum_) >= std::abs(term) ? (sum_ - sum) + term : (term - sum) + sum_;
        sum_ = sum;
    }
    double value() const { return sum_ + carried_; }

  private:
    double sum_ = 0.0, carried_ = 0.0;
};

/// One function over the surface.
struct Measures {
    double l1 = 0.0, l2 = 0.0, linf = 0.0, percentile95 = 0.0, percentile99 = 0.0, mean = 0.0;
};

/// `share`: weights over their sum, or empty if there is no area.
Measures measure(std::vector<double>& value, std::span<const double> share) {
    Measures result;
    for (const double v : value) {
        result.linf = std::max(result.linf, std::abs(v));
    }
    if (result.linf == 0.0 || share.empty()) {
        return result;
    }
    // In units of a power of two near the largest value squares and sums neither over- nor underflow.
    const int exponent = std::ilogb(result.linf);
    Sum mean, absolute, square;
    for (std::size_t i = 0; i < value.size(); ++i) {
        const double scaled = std::scalbn(value[i], -exponent);
        mean.add(share[i] * scaled);
        absolute.add(share[i] * std::abs(scaled));
        square.add(share[i] * scaled * scaled);
        value[i] = std::abs(scaled);
    }
    result.mean = std::scalbn(mean.value(), exponent);
    result.l1 = std::scalbn(absolute.value(), exponent);
    result.l2 = std::scalbn(std::sqrt(square.value()), exponent);

    std::vector<std::size_t> order(value.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return value[a] < value[b]; });
    const auto quantile = [&](double q) {
        // Shares and their sum are rounded: a sum within that rounding of q counts as having reached it.
        const double wanted = q * (1.0 - 0x1p-40);
        Sum below;
        double last = 0.0;
        for (const std::size_t i : order) {
            if (share[i] > 0.0) {
                last = value[i];
                below.add(share[i]);
                if (below.value() >= wanted) {
                    break;
                }
            }
        }
        return std::scalbn(last, exponent);
    };
    result.percentile95 = quantile(0.95);
    result.percentile99 = quantile(0.99);
    return result;
}

std::vector<double> column(const Values& values, Eigen::Index c) {
    std::vector<double> result(static_cast<std::size_t>(values.rows()));
    Eigen::Map<Eigen::VectorXd>(result.data(), values.rows()) = values.col(c);
    return result;
}

} // namespace

std::optional<double> Norm::relative() const {
    if (error == 0.0) {
        return 0.0;
    }
    return reference > 0.0 ? std::optional(error / reference) : std::nullopt;
}

ErrorNorms error_norms(std::span<const double> f, std::span<const double> g, std::span<const double> weight) {
    DIFUSA_REQUIRE(f.size() == g.size() && f.size() == weight.size());
    ErrorNorms norms;
    Sum area;
    std::vector<double> e(f.size());
    for (std::size_t i = 0; i < f.size(); ++i) {
        DIFUSA_REQUIRE(weight[i] >= 0.0 && std::isfinite(weight[i] + f[i]) && std::isfinite(g[i]));
        e[i] = f[i] - g[i];
        area.add(weight[i]);
    }
    norms.area = area.value();
    std::vector<double> share;
    if (norms.area > 0.0) {
        share.assign(weight.begin(), weight.end());
        for (double& s : share) {
            s /= norms.area;
        }
    }
    std::vector<double> r(g.begin(), g.end());
    const Measures error = measure(e, share), reference = measure(r, share);
    norms.l1 = {error.l1, reference.l1};
    norms.l2 = {error.l2, reference.l2};
    norms.linf = {error.linf, reference.linf};
    norms.percentile95 = {error.percentile95, reference.percentile95};
    norms.percentile99 = {error.percentile99, reference.percentile99};
    norms.bias = {error.mean, reference.l1};
    norms.integral = {error.mean * norms.area, std::abs(reference.mean) * norms.area};
    return norms;
}

FieldNorms field_norms(const Values& f, const Values& g, std::span<const double> weight, bool rgb) {
    DIFUSA_REQUIRE(f.rows() == g.rows() && f.cols() == g.cols() && (!rgb || f.cols() == 3));
    FieldNorms norms;
    std::vector<double> all_f, all_g, all_weights;
    for (Eigen::Index c = 0; c < f.cols(); ++c) {
        const std::vector<double> f_c = column(f, c), g_c = column(g, c);
        norms.channel.push_back(error_norms(f_c, g_c, weight));
        if (f.cols() > 1) {
            all_f.insert(all_f.end(), f_c.begin(), f_c.end());
            all_g.insert(all_g.end(), g_c.begin(), g_c.end());
            all_weights.insert(all_weights.end(), weight.begin(), weight.end());
        }
    }
    norms.all = f.cols() == 1 ? norms.channel.front() : error_norms(all_f, all_g, all_weights);
    if (rgb) {
        norms.weighted = error_norms(column(weighted_by_luminance(f), 0), column(weighted_by_luminance(g), 0), weight);
    }
    return norms;
}

Values weighted_by_luminance(const Values& rgb) {
    return rgb * luminance_weights;
}

double convergence_order(std::span<const double> h, std::span<const double> error) {
    DIFUSA_REQUIRE(h.size() == error.size());
    const auto n = static_cast<double>(h.size());
    double mean_x = 0.0, mean_y = 0.0;
    for (std::size_t i = 0; i < h.size(); ++i) {
        if (!(h[i] > 0.0) || !(error[i] > 0.0) || !std::isfinite(h[i]) || !std::isfinite(error[i])) {
            throw UsageError("an order of convergence needs positive, finite spacings and errors (an error of 0 has "
                             "none): omit measurement " +
                             std::to_string(i + 1));
        }
        mean_x += std::log(h[i]) / n;
        mean_y += std::log(error[i]) / n;
    }
    if (std::adjacent_find(h.begin(), h.end(), std::not_equal_to<>()) == h.end()) {
        throw UsageError("an order of convergence needs measurements at at least two different spacings: measure at "
                         "another spacing");
    }
    double xx = 0.0, xy = 0.0;
    for (std::size_t i = 0; i < h.size(); ++i) {
        const double x = std::log(h[i]) - mean_x;
        xx += x * x;
        xy += x * (std::log(error[i]) - mean_y);
    }
    return xy / xx;
}

} // namespace difusa
