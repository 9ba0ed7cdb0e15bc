// Interface of every scene with an exact solution: the light at a point of its surface.
#pragma once

#include <difusa/core/types.h>

#include <optional>

namespace difusa {

/// One channel of light at a surface point, W/m²: B = E + rho H, H = H_direct + H_indirect.
struct ReferenceLight {
    double E = 0.0;                 ///< emitted radiosity
    double rho = 0.0;               ///< reflectance
    double H = 0.0;                 ///< irradiance
    std::optional<double> H_direct; ///< the part of H directly from the sun or from E; absent if unknown

    double B() const { return E + rho * H; }
};

/// A scene with known radiosity. The header of each says where its surfaces are.
class Reference {
  public:
    Reference() = default;
    Reference(const Reference&) = default;
    Reference& operator=(const Reference&) = default;
    Reference(Reference&&) = default;
    Reference& operator=(Reference&&) = default;
    virtual ~Reference() = default;

    /// At the surface point represented by x, a point on or near it with unit normal n.
    virtual ReferenceLight at(const Vec3& x, const Vec3& n) const = 0;
};

} // namespace difusa
