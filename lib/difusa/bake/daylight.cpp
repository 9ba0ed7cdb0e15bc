#include <difusa/bake/daylight.h>

#include <difusa/bake/evaluation.h>
#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/plugin/choice.h>
#include <difusa/scene/cie_sky.h>
#include <difusa/scene/perez_sky.h>
#include <difusa/scene/sun_position.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

namespace difusa {

namespace {

std::vector<SurfacePoint> daylight_points(BakeResult& result, const Execution& execution) {
    if (result.listed.empty() && result.sensors.empty()) {
        if (result.mesh.vertices.empty()) {
            refine_output(result, execution);
        }
        return result.mesh.vertices;
    }
    std::vector<std::pair<Index, SurfacePoint>> listed;
    for (std::size_t k = 0; k < result.listed.size(); ++k) {
        listed.emplace_back(result.listed_number[k], result.listed[k]);
    }
    std::vector<SurfacePoint> of_grids;
    for (const PlacedSensor& placed : result.sensors) {
        if (placed.sensor.kind != SensorKind::planar) {
            throw UsageError("--sensor " + result.options.sensor +
                             ": daylight coefficients are those of planes: give normals, or --sensor horizontal");
        }
        const SurfacePoint point{placed.sensor.position, placed.sensor.axis, none, 0.0, 0.0};
        if (placed.listed != none) {
            listed.emplace_back(placed.listed, point);
        } else {
            of_grids.push_back(point);
        }
    }
    std::stable_sort(listed.begin(), listed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<SurfacePoint> points;
    for (const auto& each : listed) {
        points.push_back(each.second);
    }
    points.insert(points.end(), of_grids.begin(), of_grids.end());
    return points;
}

using SkyParameter = ParameterSpec::Type;

std::vector<ParameterSpec> with_sun_position(std::vector<ParameterSpec> own) {
    own.push_back({"elevation", SkyParameter::real, "45", "of the sun above the horizon, degrees", 0.0, 90.0, {}});
    own.push_back(
        {"azimuth", SkyParameter::real, "180", "of the sun, degrees from north over east", -360.0, 360.0, {}});
    own.push_back({"ground", SkyParameter::real, "0.2", "reflectance of the ground", 0.0, 1.0, {}});
    return own;
}

Choice parse_sky_choice(const std::string& text) {
    return parse_choice(
        "daylight-sky", text,
        {{"cie", with_sun_position(
                     {{"type", SkyParameter::integer, "16", "of CIE S 011, or 16: traditional overcast", 1, 16, {}},
                      {"diffuse", SkyParameter::real, "", "irradiance of level ground by the sky, W/m²", 0, 1e9, {}},
                      {"illuminance", SkyParameter::real, "", "the same in lux", 0, 1e12, {}}})},
         {"perez",
          with_sun_position(
              {{"direct", SkyParameter::real, "", "irradiance of a surface that faces the sun, W/m²", 0, 1400, {}},
               {"diffuse", SkyParameter::real, "", "irradiance of level ground by the sky, W/m²", 0, 1400, {}},
               {"dew", SkyParameter::real, "11", "dew point, °C", -90, 60, {}},
               {"sun", SkyParameter::word, "none", "whether its light is spread over its part", 0, 0, {"none", "part"}},
               {"light", SkyParameter::word, "visible", "what watts are meant", 0, 0, {"visible", "solar"}}})}});
}

/// Scales the sky's parts to the irradiance, adds the sun's to its part, and lights the ground.
void settle_radiances(SkyInParts& result, const SkyDivision& division, double diffuse, double direct, const Vec3& sun,
                      double ground) {
    Values& L = result.radiance;
    L.row(0).setZero();
    const Eigen::RowVectorXd own = division.level_irradiance(L);
    for (Eigen::Index c = 0; c < L.cols(); ++c) {
        L.col(c) *= diffuse / own[c];
    }
    if (direct > 0.0) {
        const Index part = division.at(sun);
        // So that a surface that faces the part is lit as by the sun.
        L.row(static_cast<Eigen::Index>(part)).array() += direct / division.moment(division.cell(part)).norm();
    }
    L.row(0) = ground * std::numbers::inv_pi * division.level_irradiance(L);
}

} // namespace

DaylightMatrix daylight_matrix(BakeResult& result, const DaylightRequest& request, const Execution& execution) {
    if (result.scene->thermal) {
        throw UsageError("daylight coefficients are those of light: a thermal scene has none");
    }
    if (!result.scene->mesh.repetition.planes.empty()) {
        throw UsageError("--daylight: " + result.file +
                         " has symmetry planes, and each part of the sky by itself is not symmetric: bake the whole "
                         "scene (periods can stay)");
    }
    DaylightMatrix matrix{SkyDivision(request.factor, result.up, request.north.value_or(default_north(result.up))),
                          daylight_points(result, execution),
                          {}};
    const double bytes = 2.0 * 3.0 * sizeof(double) * static_cast<double>(matrix.points.size()) *
                         static_cast<double>(matrix.sky.count());
    if (bytes > static_cast<double>(execution.memory_left())) {
        throw ResourceError("the daylight coefficients of " + std::to_string(matrix.points.size()) + " points and " +
                            std::to_string(matrix.sky.count()) + " parts take " + text_of(bytes / 1e9) +
                            " GB, more than there is: choose fewer points, or a coarser --sky-parts");
    }
    DaylightOptions options;
    options.site_rays = result.options.rays;
    options.rays = request.rays;
    options.seed = result.options.seed;
    options.solve = result.options.solve;
    matrix.coefficients = daylight_coefficients(*result.system, result.solution.light.reflectance, matrix.points,
                                                matrix.sky, options, execution);
    return matrix;
}

SkyInParts sky_in_parts(const std::string& text, const SkyDivision& division) {
    const Choice choice = parse_sky_choice(text);
    const Parameters& p = choice.parameters;
    constexpr double degree = std::numbers::pi / 180.0;
    const double elevation = p.real("elevation") * degree, azimuth = p.real("azimuth") * degree;
    const Vec3 sun = std::sin(elevation) * division.up() +
                     std::cos(elevation) * (std::cos(azimuth) * division.north() +
                                            std::sin(azimuth) * division.north().cross(division.up()));
    SkyInParts result{{}, choice.text(), {}};
    if (choice.name == "cie") {
        if (p.given("diffuse") == p.given("illuminance")) {
            throw UsageError("--daylight-sky " + text + ": give either diffuse, in W/m², or illuminance, in lux");
        }
        const double diffuse = p.given("diffuse") ? p.real("diffuse") : p.real("illuminance") / lumens_per_watt;
        const auto type = static_cast<int>(p.integer("type"));
        result.radiance = division.mean_radiances(CieSky(type, division.up(), sun));
        settle_radiances(result, division, diffuse, 0.0, sun, p.real("ground"));
        return result;
    }
    if (!p.given("direct") || !p.given("diffuse")) {
        throw UsageError("--daylight-sky " + text + ": give both direct and diffuse, in W/m²");
    }
    const PerezWeather weather =
        perez_weather(p.real("direct"), p.real("diffuse"), 0.5 * std::numbers::pi - elevation, p.real("dew"));
    const bool visible = p.word("light") == "visible", with_sun_part = p.word("sun") == "part";
    result.radiance = division.mean_radiances(PerezSky(weather.shape, division.up(), sun, Rgb::Ones()));
    settle_radiances(result, division, p.real("diffuse") * (visible ? weather.diffuse_efficacy / lumens_per_watt : 1.0),
                     with_sun_part ? p.real("direct") * (visible ? weather.direct_efficacy / lumens_per_watt : 1.0)
                                   : 0.0,
                     sun, p.real("ground"));
    if (with_sun_part) {
        result.notes.emplace_back("the light of the sun is spread over the part of the sky that it is in: its shadows "
                                  "are as soft as that part is large");
    } else if (p.real("direct") > 0.0) {
        result.notes.emplace_back("the light of the sun itself is left out, also on the ground: sun=part adds it");
    }
    return result;
}

} // namespace difusa
