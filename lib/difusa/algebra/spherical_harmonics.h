// Real spherical harmonics: functions of direction, orthonormal over the sphere.
#pragma once

#include <difusa/core/types.h>

#include <cstddef>
#include <span>
#include <vector>

namespace difusa {

/// Y_lm for l = 0 ... order and m = -l ... l, Y_lm being number l² + l + m: a multiple of P_lm(z) cos(m phi) for m >= 0
/// and of P_l|m|(z) sin(|m| phi) for m < 0, without the sign (-1)^m (R. Green, "Spherical harmonic lighting: the gritty
/// details", 2003). By stable recurrences, without a trigonometric function.
class SphericalHarmonics {
  public:
    /// order >= 0.
    explicit SphericalHarmonics(int order);

    int order() const { return order_; }
    std::size_t count() const { return static_cast<std::size_t>((order_ + 1) * (order_ + 1)); }
    static std::size_t number(int l, int m) { return static_cast<std::size_t>(l * l + l + m); }

    /// All of them at a unit vector: Y[count()].
    void at(const Vec3& direction, std::span<double> Y) const;

    /// What turns coefficients of a function f into those of f(Rᵀ ω), one block of 2l + 1 by 2l + 1 for each l.
    using Rotation = std::vector<Eigen::MatrixXd>;

    /// By quadrature that is exact for products of two harmonics.
    Rotation rotation(const Eigen::Matrix3d& R) const;

    /// `from`, `to`: count() rows, any number of columns.
    static void rotate(const Rotation& rotation, const Eigen::Ref<const Values>& from, Eigen::Ref<Values> to);

    /// The reverse, which is the transpose.
    static void rotate_back(const Rotation& rotation, const Eigen::Ref<const Values>& from, Eigen::Ref<Values> to);

  private:
    struct Step {
        double a, b; ///< P_l = a (z P_(l-1) - b P_(l-2))
    };
    int order_;
    std::vector<double> diagonal_;        ///< P_mm / sin^m
    std::vector<std::vector<Step>> step_; ///< of each m, from l = m + 1 on
    std::vector<Vec3> node_;              ///< of the quadrature
    std::vector<double> weight_;
    Values at_nodes_; ///< #nodes by count()
};

} // namespace difusa
