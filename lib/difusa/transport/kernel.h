// Plugin kind "kernel": the form factor between two sites, without visibility.
#pragma once

#include <difusa/core/types.h>

namespace difusa {

class Kernel {
  public:
    virtual ~Kernel() = default;

    /// The share of the light leaving a receiver at x (unit normal n_x) that goes to a small patch of area A at y (unit
    /// normal n_y): F(x, y) A, dimensionless, >= 0; 0 if either faces away from the other.
    virtual double form_factor(const Vec3& x, const Vec3& n_x, const Vec3& y, const Vec3& n_y, double A) const = 0;
};

} // namespace difusa
