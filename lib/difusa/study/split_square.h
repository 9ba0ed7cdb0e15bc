// Squares of differences to what is known with noise, but twice.
#pragma once

#include <difusa/core/types.h>

#include <algorithm>
#include <cmath>

namespace difusa {

/// The sum of |D|² over the vectors D that are known as d and e, each plus independent noise. The noise is not part of
/// the sum in the mean, which may thus be negative: it is that of the products d·e.
class SplitSquare {
  public:
    /// X, Y: covariances of the noise of d and e.
    void add(const Vec3& d, const Eigen::Matrix3d& X, const Vec3& e, const Eigen::Matrix3d& Y) {
        sum_ += d.dot(e);
        // The variance of d·e is D'XD + D'YD + tr(XY); the mean of d'Yd is D'YD + tr(XY), that of e'Xe D'XD + tr(XY).
        const double both = (X * Y).trace();
        variance_ += d.dot(Y * d) + e.dot(X * e) - both;
        least_ += both;
    }

    double sum() const { return sum_; }
    /// An estimate of the standard error of the sum.
    double deviation() const { return std::sqrt(std::max(variance_, least_)); }

  private:
    double sum_ = 0.0, variance_ = 0.0, least_ = 0.0;
};

} // namespace difusa
