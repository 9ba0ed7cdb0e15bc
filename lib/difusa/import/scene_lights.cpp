#include <difusa/import/scene_lights.h>

#include <difusa/core/error.h>
#include <difusa/core/frame.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/image_file.h>
#include <difusa/import/scene_luminaires.h>
#include <difusa/scene/sky_dome.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

namespace difusa {

namespace {

/// Rays sample what is left of a bright spot with a noise of limit times the square root of the share of rays that hit
/// it, which is 1/300 for the largest that becomes a sun (0.01 sr of pi). With a limit of 10 that is 0.6; half a sky
/// hidden gives 0.5.
constexpr double sun_limit = 10.0;
constexpr std::size_t most_suns = 16; ///< per sky image: each costs a shadow ray wherever light is evaluated

void read_spot(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const std::string what = "a spot light";
    checks.members(from, what,
                   {"type", "name", "position", "direction", "look_at", "intensity", "luminous_intensity",
                    "inner_degrees", "outer_degrees"});
    PointLight light;
    light.name = checks.name_of(from);
    light.position = checks.position(checks.required(from, what, "position"), quoted("position"));
    light.direction = checks.direction_or_target(from, what, "direction", light.position);
    light.intensity = checks.light(from, what, "intensity", "luminous_intensity", soup.photometric);
    const JsonValue& outer = checks.required(from, what, "outer_degrees");
    const double outer_degrees = checks.positive(outer, quoted("outer_degrees"));
    const JsonValue* inner = from.find("inner_degrees");
    const double inner_degrees = inner == nullptr ? 0.0 : checks.number(*inner, quoted("inner_degrees"));
    if (!(outer_degrees < 180.0) || !(inner_degrees >= 0.0) || !(inner_degrees <= outer_degrees)) {
        checks.fail(outer, "the cone of a spot light needs 0 <= inner_degrees <= outer_degrees < 180 (angles "
                           "from its axis), not " +
                               text_of(inner_degrees) + " and " + text_of(outer_degrees));
    }
    light.cos_inner = std::cos(inner_degrees * std::numbers::pi / 180.0);
    light.cos_outer = std::cos(outer_degrees * std::numbers::pi / 180.0);
    soup.lights.points.push_back(light);
}

/// The factor on the radiances of a sky, which may be luminances, in cd/m².
double radiance_factor(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const JsonValue* photometric = from.find("photometric");
    if (photometric == nullptr || !checks.truth(*photometric, quoted("photometric"))) {
        return 1.0;
    }
    soup.photometric = true;
    return 1.0 / lumens_per_watt;
}

void read_sky_image(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const JsonValue& named = checks.required(from, "a sky", "file");
    const std::filesystem::path path = checks.file_beside(named, quoted("file"));
    soup.files.push_back(path);
    // Forward as in most programs: y if z is up, -z if y is up.
    Vec3 ahead = std::abs(checks.up().y()) > 0.9 ? Vec3(-Vec3::UnitZ()) : Vec3(Vec3::UnitY());
    if (const JsonValue* given = from.find("ahead")) {
        ahead = checks.direction(*given, quoted("ahead"));
        if (!(ahead.cross(checks.up()).norm() > 1e-6)) {
            checks.fail(*given, "\"ahead\" must not be straight up or down");
        }
    }
    double scale = 1.0;
    if (const JsonValue* given = from.find("scale")) {
        scale = checks.positive(*given, quoted("scale"));
        if (!(scale <= 1e30)) {
            checks.fail(*given, "\"scale\" must be at most 1e30, not " + text_of(scale));
        }
    }
    scale *= radiance_factor(checks, from, soup);
    const JsonValue* split = from.find("split_suns");
    const bool splits = split == nullptr || checks.truth(*split, quoted("split_suns"));
    try {
        const ImageSky whole(read_image(path, PixelEncoding::srgb, soup.notes), scale, checks.up(), ahead);
        auto dome = std::make_shared<ImageSky>(whole);
        std::vector<Sun> suns = splits ? dome->split_suns(sun_limit) : std::vector<Sun>{};
        for (double limit = 2.0 * sun_limit; suns.size() > most_suns; limit *= 2.0) {
            dome = std::make_shared<ImageSky>(whole);
            suns = dome->split_suns(limit);
        }
        if (!suns.empty()) {
            soup.notes.push_back(path.string() + ": its brightest spots become suns: " + std::to_string(suns.size()));
        }
        // What the suns leave is at most as bright as the limit, except where spots are too wide or too many.
        const double bright = 2.0 * sun_limit * whole.mean();
        if (const double left = splits ? dome->solid_angle_above(bright) : 0.0; left > 0.0) {
            soup.notes.push_back(path.string() + ": " + text_of(left) + " sr remain more than " +
                                 text_of(2.0 * sun_limit) +
                                 " times as bright as its mean, in spots too wide or too many to become suns: "
                                 "rays hit them only by chance; use more (--rays), or darken them in the image");
        }
        soup.lights.suns.insert(soup.lights.suns.end(), suns.begin(), suns.end());
        soup.lights.dome = std::move(dome);
    } catch (const InputError& error) {
        checks.fail(named, "\"file\": " + std::string(error.what()));
    } catch (const std::invalid_argument& error) {
        checks.fail(named, path.string() + ": " + error.what());
    }
}

PointLight point_light(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const std::string what = "a point light";
    checks.members(from, what,
                   {"type", "name", "position", "intensity", "power", "luminous_intensity", "luminous_flux"});
    PointLight light;
    light.name = checks.name_of(from);
    light.position = checks.position(checks.required(from, what, "position"), quoted("position"));
    const bool intensity = from.find("intensity") != nullptr || from.find("luminous_intensity") != nullptr;
    const bool power = from.find("power") != nullptr || from.find("luminous_flux") != nullptr;
    if (intensity == power) {
        checks.refuse_choice(from, what, "\"intensity\" (W/sr; \"luminous_intensity\" in cd)",
                             "\"power\" (W; \"luminous_flux\" in lm)", power);
    }
    light.intensity =
        intensity
            ? checks.light(from, what, "intensity", "luminous_intensity", soup.photometric)
            : Rgb(checks.light(from, what, "power", "luminous_flux", soup.photometric) / (4.0 * std::numbers::pi));
    return light;
}

} // namespace

void read_scene_light(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const std::string what = "a light";
    checks.object(from, what);
    const JsonValue& kind = checks.required(from, what, "type");
    const std::string& type = checks.text(kind, quoted("type"));
    if (type == "sun") {
        soup.lights.suns.push_back(read_sun(checks, from, soup));
    } else if (type == "point") {
        soup.lights.points.push_back(point_light(checks, from, soup));
    } else if (type == "spot") {
        read_spot(checks, from, soup);
    } else if (type == "luminaire") {
        read_luminaire_light(checks, from, soup);
    } else {
        checks.refuse_name(kind, type, "a light of \"type\" " + excerpt(type) + " is not known",
                           {"sun", "point", "spot", "luminaire"});
    }
}

void read_scene_sky(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const std::string what = "a sky";
    checks.object(from, what);
    const JsonValue& kind = checks.required(from, what, "type");
    const std::string& type = checks.text(kind, quoted("type"));
    if (type == "uniform") {
        checks.members(from, what, {"type", "irradiance", "illuminance"});
        soup.lights.sky = checks.light(from, what, "irradiance", "illuminance", soup.photometric);
    } else if (type == "gradient") {
        checks.members(from, what, {"type", "zenith", "horizon", "ground", "photometric"});
        const double factor = radiance_factor(checks, from, soup);
        const auto radiance = [&](const char* name) {
            return Rgb(factor * checks.colour(checks.required(from, what, name), quoted(name)));
        };
        soup.lights.dome =
            std::make_shared<GradientSky>(radiance("zenith"), radiance("horizon"), radiance("ground"), checks.up());
    } else if (type == "image") {
        checks.members(from, what, {"type", "file", "scale", "ahead", "split_suns", "photometric"});
        read_sky_image(checks, from, soup);
    } else if (type == "cie") {
        read_cie_sky(checks, from, soup);
    } else {
        checks.refuse_name(kind, type, "a sky of \"type\" " + excerpt(type) + " is not known",
                           {"uniform", "gradient", "image", "cie"});
    }
}

Camera scene_camera(const SceneChecks& checks, const JsonValue& from) {
    const std::string what = "a camera";
    checks.members(from, what, {"eye", "look_at", "towards", "up", "view_degrees"});
    Camera camera;
    camera.eye = checks.position(checks.required(from, what, "eye"), quoted("eye"));
    camera.towards = checks.direction_or_target(from, what, "towards", camera.eye);
    const JsonValue* up = from.find("up");
    camera.up = up == nullptr ? checks.up() : checks.up_direction(*up);
    const bool is_plan = !(camera.up.cross(camera.towards).norm() > 1e-6); // what is up in it is not stated
    if (is_plan && up == nullptr) {
        Vec3 across;
        tangents(checks.up(), across, camera.up);
    } else if (is_plan) {
        checks.fail(from, "the camera looks straight along its \"up\": give it another \"up\"");
    }
    double degrees = 40.0;
    if (const JsonValue* view = from.find("view_degrees")) {
        degrees = checks.positive(*view, quoted("view_degrees"));
        if (!(degrees < 180.0)) {
            checks.fail(*view, "\"view_degrees\" must be below 180");
        }
    }
    camera.view_angle = degrees * std::numbers::pi / 180.0;
    return camera;
}

} // namespace difusa
