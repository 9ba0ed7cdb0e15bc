#include <difusa/study/references/manufactured.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

namespace difusa {

namespace {

constexpr double longest_panel = 1.5;
/// Minimum distance to an edge, as a share of the largest size: gives the limit there, at a corner along the bisector.
constexpr double off_edge = 1e-14;

/// Calls act(sinh t, cosh t, weight) for the nodes of panels that cover [from, to] cut at ±end.
template <class Act>
void for_each_panel_node(const QuadratureRule& rule, double from, double to, double end, const Act& act) {
    from = std::max(from, -end);
    to = std::min(to, end);
    if (!(from < to)) {
        return;
    }
    const double panels = std::ceil((to - from) / longest_panel), length = (to - from) / panels;
    for (double p = 0.0; p < panels; p += 1.0) {
        for (std::size_t k = 0; k < rule.size(); ++k) {
            const double e = std::exp(from + (p + rule.node[k]) * length), inverse = 1.0 / e;
            act(0.5 * (e - inverse), 0.5 * (e + inverse), rule.weight[k] * length);
        }
    }
}

[[noreturn]] void refuse(const std::string& what) {
    throw UsageError("manufactured box: " + what);
}

Vec3 inward(int axis, bool upper) {
    Vec3 n = Vec3::Zero();
    n[axis] = upper ? -1.0 : 1.0;
    return n;
}

std::string place_text(const Vec3& x) {
    return "(" + std::to_string(x.x()) + ", " + std::to_string(x.y()) + ", " + std::to_string(x.z()) + ")";
}

} // namespace

ManufacturedBox::Radiosity ManufacturedBox::waves(const Vec3& size, double mean, double amplitude, double waves) {
    const Vec3 k = waves * std::numbers::pi * size.cwiseInverse();
    return [k, mean, amplitude](const Vec3& x, const Vec3& /*n*/) {
        return mean + amplitude * std::cos(k.x() * x.x()) * std::cos(k.y() * x.y()) * std::cos(k.z() * x.z());
    };
}

/// K B at x on a face whose normal is along `axis`.
double ManufacturedBox::irradiance(const Vec3& x, int axis, const QuadratureRule& rule) const {
    const bool upper = x[axis] > 0.5 * size_[axis];
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    const Vec3 below = x.cwiseMax(off_edge * size_.maxCoeff()),
               above = (size_ - x).cwiseMax(off_edge * size_.maxCoeff());
    // Where less than a hundredth of the tolerance is left of 8/3 exp(-3t), 2 exp(-2s) and 2 exp(-s).
    const double small = 0.01 * tolerance_;
    const double end_cubed = std::log(8.0 / (3.0 * small)) / 3.0, end_squared = std::log(2.0 / small) / 2.0,
                 end_first = std::log(2.0 / small);
    double sum = 0.0;
    Vec3 y;
    // ∫ B / cosh³ t dt on the line along an axis at the distance q from x.
    const auto line = [&](double q, int along, const Vec3& n) {
        double inner = 0.0;
        const double from = -below[along] / q, to = above[along] / q;
        for_each_panel_node(rule, std::asinh(from), std::asinh(to), end_cubed,
                            [&](double sinh, double cosh, double weight) {
                                y[along] = std::clamp(x[along] + q * sinh, 0.0, size_[along]);
                                inner += weight / (cosh * cosh * cosh) * radiosity_(y, n);
                            });
        return inner;
    };
    { // the opposite face
        const double d = size_[axis], from = -below[i] / d, to = above[i] / d;
        const Vec3 n = inward(axis, !upper);
        y[axis] = upper ? 0.0 : d;
        for_each_panel_node(rule, std::asinh(from), std::asinh(to), end_squared,
                            [&](double sinh, double cosh, double weight) {
                                y[i] = std::clamp(x[i] + d * sinh, 0.0, size_[i]);
                                sum += weight / (cosh * cosh) * line(d * cosh, j, n);
                            });
    }
    for (const int across : {i, j}) {
        const int along = i + j - across;
        for (const bool far : {false, true}) {
            const double x0 = far ? above[across] : below[across];
            const Vec3 n = inward(across, far);
            y[across] = far ? size_[across] : 0.0;
            for_each_panel_node(rule, 0.0, std::asinh(size_[axis] / x0), end_first,
                                [&](double sinh, double cosh, double weight) {
                                    const double height = std::clamp(x0 * sinh, 0.0, size_[axis]);
                                    y[axis] = upper ? size_[axis] - height : height;
                                    sum += weight * sinh / (cosh * cosh) * line(x0 * cosh, along, n);
                                });
        }
    }
    return sum / std::numbers::pi;
}

ManufacturedBox::ManufacturedBox(const Vec3& size, double rho, Radiosity radiosity, double tolerance)
    : size_(size), rho_(rho), tolerance_(tolerance), radiosity_(std::move(radiosity)) {
    if (!(size.allFinite() && size.minCoeff() > 0.0)) {
        refuse("the sizes must be positive, not " + place_text(size));
    }
    if (!(rho >= 0.0 && rho <= 1.0)) {
        refuse("the reflectance must be in [0,1], not " + std::to_string(rho));
    }
    if (!(tolerance >= 1e-12)) {
        refuse("the tolerance must be at least 1e-12, not " + std::to_string(tolerance));
    }
    const auto for_each_place = [&](const std::vector<double>& places, const auto& act) {
        for (int axis = 0; axis < 3; ++axis) {
            for (const double end : {0.0, size_[axis]}) {
                for (const double p : places) {
                    for (const double q : places) {
                        Vec3 x;
                        x[axis] = end;
                        x[(axis + 1) % 3] = p * size_[(axis + 1) % 3];
                        x[(axis + 2) % 3] = q * size_[(axis + 2) % 3];
                        act(x, axis);
                    }
                }
            }
        }
    };
    std::vector<double> grid;
    for (int k = 0; k <= 8; ++k) {
        grid.push_back(k / 8.0);
    }
    double largest = 0.0;
    for_each_place(grid, [&](const Vec3& x, int axis) {
        const double B = radiosity_(x, inward(axis, x[axis] > 0.0));
        if (!std::isfinite(B)) {
            refuse("B is not finite at " + place_text(x));
        }
        largest = std::max(largest, std::abs(B));
    });

    const std::vector<double> edges{0.0, 1e-4, 0.03, 0.4, 1.0};
    const auto samples = [&](const QuadratureRule& rule) {
        std::vector<double> values;
        for_each_place(edges, [&](const Vec3& x, int axis) { values.push_back(irradiance(x, axis, rule)); });
        return values;
    };
    std::vector<double> coarse;
    for (const std::size_t nodes : {6U, 8U, 12U, 16U, 24U}) {
        const QuadratureRule finer = gauss_legendre(nodes);
        const std::vector<double> fine = samples(finer);
        error_ = coarse.empty() ? std::numeric_limits<double>::infinity() : 0.0;
        for (std::size_t k = 0; k < coarse.size(); ++k) {
            error_ = std::max(error_, std::abs(fine[k] - coarse[k]));
        }
        if (error_ <= tolerance * largest) {
            break;
        }
        rule_ = finer;
        coarse = fine;
    }
    if (!(error_ <= tolerance * largest)) {
        throw NotConverged("manufactured box: " + std::to_string(rule_.size()) + " nodes per panel leave an error of " +
                           std::to_string(error_) + " W/m²; is B smooth on each face?");
    }

    least_emission_ = std::numeric_limits<double>::infinity();
    for_each_place(grid, [&](const Vec3& x, int axis) {
        const double E = radiosity_(x, inward(axis, x[axis] > 0.0)) - rho_ * irradiance(x, axis, rule_);
        if (E < -tolerance * largest) {
            refuse("the emission would be " + std::to_string(E) + " W/m² at " + place_text(x) +
                   "; raise B's mean, or lower the reflectance");
        }
        least_emission_ = std::min(least_emission_, E);
    });
}

ReferenceLight ManufacturedBox::at(const Vec3& x, const Vec3& n) const {
    int axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    const bool upper = n[axis] < 0.0;
    Vec3 foot = x.cwiseMax(0.0).cwiseMin(size_);
    foot[axis] = upper ? size_[axis] : 0.0;
    if (!((x - foot).norm() <= 1e-6 * size_.maxCoeff())) {
        refuse(place_text(x) + " is not on the face with the normal " + place_text(inward(axis, upper)));
    }
    const double B = radiosity_(foot, inward(axis, upper)), H = irradiance(foot, axis, rule_);
    return {B - rho_ * H, rho_, H, {}};
}

} // namespace difusa
