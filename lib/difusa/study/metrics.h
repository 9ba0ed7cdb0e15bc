// The error of a field against its reference: norms over the surface, and the order of convergence.
#pragma once

#include <difusa/core/types.h>

#include <optional>
#include <span>
#include <vector>

namespace difusa {

/// A measure of an error together with the same measure of the reference.
struct Norm {
    double error = 0.0;
    double reference = 0.0;

    /// error / reference: 0 if there is no error, nothing if there is one and the reference is zero everywhere.
    std::optional<double> relative() const;
};

/// Norms of the error e = f - g of a field f against its reference g over a surface of area A.
///
/// All but `integral` are in the unit of the field. Percentiles are quantiles by area: the smallest t such that |e| <=
/// t on at least that share of the surface. The reference of each norm is the same norm of g, except for `bias`.
struct ErrorNorms {
    double area = 0.0; ///< A, the sum of the weights
    Norm l1;           ///< ∫ |e| dA / A
    Norm l2;           ///< root of ∫ e² dA / A
    Norm linf;         ///< largest |e|
    Norm percentile95; ///< of |e|
    Norm percentile99; ///< of |e|
    Norm bias;         ///< ∫ e dA / A, with its sign; reference: ∫ |g| dA / A
    Norm integral;     ///< ∫ e dA, with its sign (an energy error: W where f is in W/m²); reference: |∫ g dA|
};

/// Norms by quadrature: f and g at points with these weights (areas). Points of weight 0 only affect the largest error.
/// All values must be finite and no weight negative. Without points or area, all norms except `linf` are 0. Scale-free:
/// no intermediate result over- or underflows unless the final one does.
ErrorNorms error_norms(std::span<const double> f, std::span<const double> g, std::span<const double> weight);

/// Norms of a field of one or more channels.
struct FieldNorms {
    std::vector<ErrorNorms> channel;
    ErrorNorms all; ///< all channels together, as if each were another sheet of the surface
    /// Of the Rec. 709 weighted sum of the channels, if there are three.
    std::optional<ErrorNorms> weighted;
};

/// `f`, `g`: #points by #channels, and #points weights; `rgb`: three channels are R, G and B.
FieldNorms field_norms(const Values& f, const Values& g, std::span<const double> weight, bool rgb);

/// R, G and B weighted by what they contribute to luminance: #rows by 1 (Rec. ITU-R BT.709).
Values weighted_by_luminance(const Values& rgb);

/// p in error = C h^p: the slope of the least-squares line through (log h, log error), the order of convergence with h
/// the spacing of sites or the length of edges.
/// Throws UsageError unless there are at least two different h, and all h and errors are positive and finite.
double convergence_order(std::span<const double> h, std::span<const double> error);

} // namespace difusa
