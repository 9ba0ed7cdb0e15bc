// Light that does not come from the scene's surfaces.
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
    Rgb irradiance = Rgb::Zero(); ///< on a surface facing it, W/m²
    std::string name = {};        ///< its light group; empty: "sun"
    bool of_sky = false;          ///< part of the sky: replaced when the sky is
};

/// Light from one point, in all directions or in a cone: a surface facing it at distance r receives the irradiance
/// intensity falloff / r².
struct PointLight {
    Vec3 position = Vec3::Zero();
    Rgb intensity = Rgb::Zero();     ///< radiant intensity in the brightest direction, W/sr
    Vec3 direction = -Vec3::UnitZ(); ///< unit, the axis of the cone
    double cos_inner = -1.0;         ///< cosine of the angle up to which the cone is at full intensity
    double cos_outer = -1.0;         ///< cosine of the angle beyond which it is dark; -1: no cone
    std::string name = {};           ///< its light group; empty: "point" or "spot"

    bool is_spot() const { return cos_outer > -1.0; }

    /// The fraction of `intensity` emitted in the unit direction `away` from the light: 1 inside the cone, 0 outside,
    /// and ((cos - cos_outer) / (cos_inner - cos_outer))² in between, as in KHR_lights_punctual of glTF.
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
