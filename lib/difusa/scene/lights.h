// Light that does not come from the scene's surfaces.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/intensity_distribution.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// Light from one direction, infinitely far away.
struct Sun {
    Vec3 towards = Vec3::UnitZ(); ///< unit, from the surface to the sun
    Rgb irradiance = Rgb::Zero(); ///< on a surface facing it, W/m²
    std::string name = {};        ///< its light group; empty: "sun"
    bool of_sky = false;          ///< part of the sky: replaced when the sky is
    double disc = 0.0;            ///< sine of half the angle under which its disc is seen; 0: a point

    bool is_extended() const { return disc > 0.0; }

    /// A direction towards the disc for (u, v) in [0,1)²: uniform over the disc as it is seen along its axis.
    Vec3 towards_disc(const std::array<double, 2>& place) const;
};

/// Light from one point, in all directions or in a cone: a surface facing it at distance r receives the irradiance
/// intensity falloff / r².
struct PointLight {
    Vec3 position = Vec3::Zero();
    Rgb intensity = Rgb::Zero();     ///< radiant intensity in the brightest direction, W/sr
    Vec3 direction = -Vec3::UnitZ(); ///< unit, the axis of the cone
    double cos_inner = -1.0;         ///< cosine of the angle up to which the cone is at full intensity
    double cos_outer = -1.0;         ///< cosine of the angle beyond which it is dark; -1: no cone
    std::string name = {};           ///< its light group; empty: "point", "spot" or "luminaire"
    /// A luminaire: how the intensity depends on the direction; null: as above. Its planes are counted from `c0`, and
    /// gamma 0 is along `direction`; these two and `c90` are unit and at right angles to each other.
    std::shared_ptr<const IntensityDistribution> distribution = {};
    Vec3 c0 = Vec3::UnitX(), c90 = Vec3::UnitY();
    double half_length = 0.0, half_width = 0.0; ///< of a flat luminous opening around `position`, along c0 and c90
    bool is_round = false;                      ///< the opening is an ellipse with these half axes

    bool is_extended() const { return half_length > 0.0 || half_width > 0.0; }

    /// The radius of a ball around `position` that contains the opening.
    double radius() const { return is_round ? std::max(half_length, half_width) : std::hypot(half_length, half_width); }

    /// The point of the opening for (u, v) in [0,1)², uniform by area.
    Vec3 place(const std::array<double, 2>& uv) const;

    bool is_spot() const { return cos_outer > -1.0; }

    /// The angle from `direction` beyond which it is dark or, of a luminaire, far darker than in its beam
    /// (IntensityDistribution::beyond_beam). pi: it shines everywhere.
    double beyond_beam() const {
        return distribution ? distribution->beyond_beam() : std::acos(std::clamp(cos_outer, -1.0, 1.0));
    }

    /// The fraction of `intensity` emitted in the unit direction `away` from the light: 1 inside the cone, 0 outside,
    /// and ((cos - cos_outer) / (cos_inner - cos_outer))² in between, as in KHR_lights_punctual of glTF.
    /// For a luminaire: its intensity in that direction over its largest.
    double falloff(const Vec3& away) const {
        if (distribution) {
            return distribution->relative({c0.dot(away), c90.dot(away), -direction.dot(away)});
        }
        if (!is_spot()) {
            return 1.0;
        }
        const double cosine = direction.dot(away);
        if (cosine >= cos_inner) {
            return 1.0;
        }
        const double part = cosine <= cos_outer ? 0.0 : (cosine - cos_outer) / (cos_inner - cos_outer);
        return part * part;
    }

    /// What a surface at x with the unit normal n would receive from the source at `from`, over `intensity`: the
    /// cosine times the falloff over the square of the distance.
    double kernel(const Vec3& from, const Vec3& x, const Vec3& n) const {
        const Vec3 way = from - x;
        const double distance = way.norm();
        const Vec3 towards = way / distance;
        const double cosine = n.dot(towards);
        return cosine > 0.0 ? cosine * falloff(-towards) / (distance * distance) : 0.0;
    }

    /// The mean of `kernel` over the opening, all of it being in sight: `kernel` itself without an opening. By
    /// Gauss-Legendre rules of three nodes a side on parts no larger than half the distance of x from the opening (2 to
    /// 48 a side): a fifth of the opening's size away and more, within 1e-3, with intensities tabulated every 10°.
    double mean_kernel(const Vec3& x, const Vec3& n) const;
};

/// Light from infinitely far away that depends on direction. A scene may also have a uniform sky in addition.
class SkyDome {
  public:
    virtual ~SkyDome() = default;

    /// Radiance arriving from the unit direction `towards` the sky, W/(m² sr).
    virtual Rgb radiance(const Vec3& towards) const = 0;

    /// True if the channels of every radiance are equal.
    virtual bool is_grey() const = 0;
};

/// The lights described in a scene file.
struct Lights {
    std::vector<Sun> suns;
    std::vector<PointLight> points;
    std::optional<Rgb> sky; ///< irradiance of a surface that sees only a uniform sky, W/m²
    std::shared_ptr<const SkyDome> dome;
};

} // namespace difusa
