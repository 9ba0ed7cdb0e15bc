#include <difusa/scene/cie_sky.h>

#include <difusa/core/colour.h>
#include <difusa/scene/sky_quadrature.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace difusa {

namespace {

struct SkyParameters {
    double a, b, c, d, e;
};

/// Table 1 of the standard.
constexpr std::array<SkyParameters, 15> sky_parameters{{{4.0, -0.70, 0.0, -1.0, 0.0},
                                                        {4.0, -0.70, 2.0, -1.5, 0.15},
                                                        {1.1, -0.8, 0.0, -1.0, 0.0},
                                                        {1.1, -0.8, 2.0, -1.5, 0.15},
                                                        {0.0, -1.0, 0.0, -1.0, 0.0},
                                                        {0.0, -1.0, 2.0, -1.5, 0.15},
                                                        {0.0, -1.0, 5.0, -2.5, 0.30},
                                                        {0.0, -1.0, 10.0, -3.0, 0.45},
                                                        {-1.0, -0.55, 2.0, -1.5, 0.15},
                                                        {-1.0, -0.55, 5.0, -2.5, 0.30},
                                                        {-1.0, -0.55, 10.0, -3.0, 0.45},
                                                        {-1.0, -0.32, 10.0, -3.0, 0.45},
                                                        {-1.0, -0.32, 16.0, -3.0, 0.30},
                                                        {-1.0, -0.15, 16.0, -3.0, 0.30},
                                                        {-1.0, -0.15, 24.0, -2.8, 0.15}}};

} // namespace

CieSky::CieSky(int type, const Vec3& up, const Vec3& sun) : type_(type), up_(up), sun_(sun) {
    if (type < 1 || type > 16 || !(up.dot(sun) >= -1e-12)) {
        throw std::invalid_argument("a CIE sky has a type from 1 to 16 and a sun that is not below the horizon");
    }
    at_zenith_ = indicatrix(up.dot(sun)) * gradation(1.0);
}

/// phi; at the horizon its limit, 1.
double CieSky::gradation(double cosine) const {
    if (type_ == 16) {
        return (1.0 + 2.0 * cosine) / 3.0;
    }
    const SkyParameters& p = sky_parameters[static_cast<std::size_t>(type_ - 1)];
    return cosine > 0.0 ? 1.0 + p.a * std::exp(p.b / cosine) : 1.0;
}

double CieSky::indicatrix(double cosine) const {
    if (type_ == 16) {
        return 1.0;
    }
    const SkyParameters& p = sky_parameters[static_cast<std::size_t>(type_ - 1)];
    const double chi = std::acos(std::clamp(cosine, -1.0, 1.0));
    return 1.0 + p.c * (std::exp(p.d * chi) - std::exp(0.5 * p.d * std::numbers::pi)) + p.e * cosine * cosine;
}

double CieSky::relative(const Vec3& towards) const {
    return indicatrix(towards.dot(sun_)) * gradation(towards.dot(up_)) / at_zenith_;
}

double CieSky::level_irradiance() const {
    constexpr std::size_t nodes = 48;
    return difusa::level_irradiance(up_, sun_, nodes, [this](const Vec3& towards) { return relative(towards); });
}

void CieSky::scale_to_irradiance(const Rgb& irradiance) {
    zenith_ = irradiance / level_irradiance();
}

Rgb CieSky::radiance(const Vec3& towards) const {
    return towards.dot(up_) < 0.0 ? ground_ : Rgb(relative(towards) * zenith_);
}

bool CieSky::is_grey() const {
    return equal_channels(zenith_) && equal_channels(ground_);
}

} // namespace difusa
