// The all-weather sky of R. Perez, R. Seals and J. Michalsky ("All-weather model for sky luminance distribution -
// preliminary configuration and validation", Solar Energy 50(3), 1993; erratum 51(5), 1993).
#pragma once

#include <difusa/scene/lights.h>

namespace difusa {

/// The luminance at the angle zeta from the zenith and gamma from the sun is proportional to
/// (1 + a exp(b / cos zeta)) (1 + c exp(d gamma) + e cos² gamma).
struct PerezShape {
    double a = 0.0, b = 0.0, c = 0.0, d = 0.0, e = 0.0;

    /// Never negative. Cosines of zeta below 0.01 count as that: b may be positive.
    double relative(double cos_zeta, double gamma) const;
};

/// What the model makes of a measurement (R. Perez, P. Ineichen, R. Seals, J. Michalsky and R. Stewart, "Modeling
/// daylight availability and irradiance components from direct and global irradiance", Solar Energy 44(5), 1990).
struct PerezWeather {
    double clearness = 1.0;  ///< epsilon: 1 where the sun is hidden, 6 and more under a clear sky
    double brightness = 0.1; ///< Delta
    PerezShape shape;
    double diffuse_efficacy = 0.0, direct_efficacy = 0.0; ///< lm/W, of the sky's light and the sun's
};

/// Irradiances in W/m², of level ground by the sky alone (above 0), and of a surface that faces the sun by the sun
/// alone (not negative); `zenith`: the sun's angle from it in [0, pi/2], radians; `dew_point`: °C, for the water in the
/// air. The extraterrestrial irradiance is 1367 W/m², the air mass that of Kasten (1966). With 1.065 < clearness < 2.8,
/// a brightness below 0.2 counts as 0.2 in the shape, as in Radiance's programs: outside of that range the model was
/// not fitted. Throws UsageError for other numbers.
PerezWeather perez_weather(double direct, double diffuse, double zenith, double dew_point);

/// The shape for a sun at this angle from the zenith: table 1 and equations 6 to 8 of 1993.
PerezShape perez_shape(double clearness, double brightness, double zenith);

/// A sky of such a shape, black below the horizon.
class PerezSky final : public SkyDome {
  public:
    /// `up` and `sun`: unit, the sun not below the horizon. `irradiance`: of level ground by the sky, W/m²; met by
    /// quadrature to about 1e-6.
    PerezSky(const PerezShape& shape, const Vec3& up, const Vec3& sun, const Rgb& irradiance);

    Rgb radiance(const Vec3& towards) const override;
    bool is_grey() const override;

  private:
    PerezShape shape_;
    Vec3 up_, sun_;
    Rgb scale_ = Rgb::Ones();
};

} // namespace difusa
