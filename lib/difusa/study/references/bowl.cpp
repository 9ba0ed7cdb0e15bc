#include <difusa/study/references/bowl.h>

#include <difusa/study/references/check_parameter.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace difusa {

Bowl::Bowl(const BowlParameters& parameters) : parameters_(parameters) {
    const auto& [beta, rho, s, sun, sky] = parameters;
    check_parameter("bowl", beta > 0.0 && beta < std::numbers::pi, "the half-angle must be between 0 and pi", beta);
    check_parameter("bowl", rho >= 0.0 && rho <= 1.0, "the reflectance must be in [0,1]", rho);
    check_parameter("bowl", std::abs(s.norm() - 1.0) <= 8.0 * std::numeric_limits<double>::epsilon(),
                    "the direction towards the sun must have unit length", s.norm());
    check_parameter("bowl", s.z() > 0.0,
                    "the sun must be above the horizon for its light to enter; its direction's z must be positive",
                    s.z());
    check_parameter("bowl", sun >= 0.0 && std::isfinite(sun), "the sun's irradiance must be finite and not negative",
                    sun);
    check_parameter("bowl", sky >= 0.0 && std::isfinite(sky), "the sky's irradiance must be finite and not negative",
                    sky);
}

double Bowl::share() const {
    const double sine = std::sin(0.5 * parameters_.half_angle);
    return sine * sine;
}

double Bowl::elevation() const {
    return std::asin(std::min(1.0, parameters_.towards_sun.z()));
}

double Bowl::indirect() const {
    const double f = share(), rho = parameters_.rho;
    return rho * f * (1.0 - f) * (parameters_.sun * parameters_.towards_sun.z() + parameters_.sky) / (1.0 - rho * f);
}

/// n·s where the point is lit, else 0.
double Bowl::from_sun(const Vec3& x) const {
    const double length = x.norm();
    if (!(length > 0.0)) {
        throw UsageError("bowl: the centre of the sphere is not on it");
    }
    const Vec3 p = x / length, &s = parameters_.towards_sun;
    const double cosine = -p.dot(s);
    return cosine > 0.0 && p.z() + 2.0 * cosine * s.z() > -std::cos(parameters_.half_angle) ? cosine : 0.0;
}

bool Bowl::lit(const Vec3& x) const {
    return from_sun(x) > 0.0;
}

ReferenceLight Bowl::at(const Vec3& x, const Vec3& /*n*/) const {
    const double direct = parameters_.sun * from_sun(x) + parameters_.sky * (1.0 - share());
    return {0.0, parameters_.rho, direct + indirect(), direct};
}

} // namespace difusa
