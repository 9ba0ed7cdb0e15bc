// Light that comes from no surface of the scene.
#pragma once

#include <difusa/core/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// Light from one direction, infinitely far away.
struct Sun {
    Vec3 towards = Vec3::UnitZ(); ///< unit, from the surface to the sun
    Rgb irradiance = Rgb::Zero(); ///< of a surface that faces it, W/m²
    std::string name = {};        ///< its light group; empty: "sun"
    bool of_sky = false;          ///< part of the sky: another sky takes its place, too
};

/// Light from one point, in all directions or in a cone: a surface at distance r that faces it receives the irradiance
/// intensity falloff / r².
struct PointLight {
    Vec3 position = Vec3::Zero();
    Rgb intensity = Rgb::Zero();     ///< radiant intensity in the brightest direction, W/sr
    Vec3 direction = -Vec3::UnitZ(); ///< unit, the axis of the cone
    double cos_inner = -1.0;         ///< cosine of the angle up to which the cone is at full intensity
    double cos_outer = -1.0;         ///< of the angle from which on it is dark; -1: no cone
    std::string name = {};           ///< its light group; empty: "point" or "spot"

    bool is_spot() const { return cos_outer > -1.0; }

    /// The part of `intensity` sent into the unit direction `away` from the light: 1 inside of the cone, 0 outside, and
    /// ((cos - cos_outer) / (cos_inner - cos_outer))² between, as KHR_lights_punctual of glTF has it.
    double falloff(const Vec3& away) const {
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
};

/// Light from everywhere far away, which depends on the direction. Beside it a scene may have an even sky.
class SkyDome {
  public:
    virtual ~SkyDome() = default;

    /// Radiance that arrives from the unit direction `towards` the sky, W/(m² sr).
    virtual Rgb radiance(const Vec3& towards) const = 0;

    /// True if the channels of every radiance are equal.
    virtual bool is_grey() const = 0;
};

/// The lights a scene file speaks of.
struct Lights {
    std::vector<Sun> suns;
    std::vector<PointLight> points;
    std::optional<Rgb> sky; ///< irradiance of a surface that sees nothing but an even sky, W/m²
    std::shared_ptr<const SkyDome> dome;
};

} // namespace difusa
