// The standard general skies of CIE S 011/E:2003 (ISO 15469:2004).
#pragma once

#include <difusa/scene/lights.h>

namespace difusa {

/// The luminance at the angle Z from the zenith and chi from the sun, over that at the zenith, is
/// f(chi) phi(Z) / (f(Z_s) phi(0)), with phi(Z) = 1 + a exp(b / cos Z) and
/// f(chi) = 1 + c (exp(d chi) - exp(d pi / 2)) + e cos² chi. Type 16: (1 + 2 cos Z) / 3, the traditional overcast sky.
class CieSky : public SkyDome {
  public:
    /// `type`: 1 to 16; `up` and `sun`: unit, the sun not below the horizon. Radiance 1 at the zenith; black below the
    /// horizon. Throws std::invalid_argument for anything else.
    CieSky(int type, const Vec3& up, const Vec3& sun);

    /// That of the zenith, W/(m² sr).
    void scale_to_zenith(const Rgb& radiance) { zenith_ = radiance; }

    /// Irradiance of a level surface that sees the whole sky, W/m².
    void scale_to_irradiance(const Rgb& irradiance);

    /// Of such a surface, over the radiance of the zenith: by Gauss-Legendre rules, to about 1e-6.
    double level_irradiance() const;

    /// The ground below the horizon, W/(m² sr).
    void set_ground(const Rgb& radiance) { ground_ = radiance; }

    /// The luminance over that of the zenith; `towards`: unit, above the horizon.
    double relative(const Vec3& towards) const;

    Rgb radiance(const Vec3& towards) const override;
    bool is_grey() const override;

  private:
    double gradation(double cosine) const;
    double indicatrix(double cosine) const;

    int type_;
    Vec3 up_, sun_;
    double at_zenith_ = 1.0; ///< f(Z_s) phi(0)
    Rgb zenith_ = Rgb::Ones(), ground_ = Rgb::Zero();
};

} // namespace difusa
