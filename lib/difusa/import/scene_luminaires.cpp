#include <difusa/import/scene_luminaires.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/luminaire_file.h>
#include <difusa/scene/cie_sky.h>
#include <difusa/scene/sun_position.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <sstream>
#include <string_view>
#include <utility>

namespace difusa {

namespace {

constexpr double degree_in_radians = std::numbers::pi / 180.0;

/// Gamma 0 along `direction`, C0 turned from +x with it the shortest way from straight down; or as given.
void orient_luminaire(const SceneChecks& checks, const JsonValue& from, PointLight& light) {
    const Vec3 down = -checks.up();
    light.direction = from.find("direction") == nullptr && from.find("look_at") == nullptr
                          ? down
                          : checks.direction_or_target(from, "a luminaire", "direction", light.position);
    Vec3 ahead = std::abs(down.x()) > 0.9 ? Vec3::UnitY() : Vec3::UnitX();
    if (const JsonValue* given = from.find("c0")) {
        ahead = checks.direction(*given, quoted("c0"));
        if (!(ahead.cross(light.direction).norm() > 1e-6)) {
            checks.fail(*given, "\"c0\" must not be along the direction of gamma 0");
        }
    } else {
        ahead = (ahead - ahead.dot(down) * down).normalized();
        const double turn = 1.0 + down.dot(light.direction);
        if (turn > 1e-12) { // straight up otherwise: turned over about C0
            const Vec3 axis = down.cross(light.direction);
            ahead = Eigen::Quaterniond(turn, axis.x(), axis.y(), axis.z()).normalized() * ahead;
        }
    }
    light.c0 = (ahead - ahead.dot(light.direction) * light.direction).normalized();
    light.c90 = -light.direction.cross(light.c0);
}

Date read_date(const SceneChecks& checks, const JsonValue& from) {
    const std::string& text = checks.text(from, quoted("date"));
    std::istringstream stream(text);
    Date date;
    char first = 0, second = 0;
    if (!(stream >> date.year >> first >> date.month >> second >> date.day) || first != '-' || second != '-' ||
        stream.peek() != std::istringstream::traits_type::eof() || !is_sound(date)) {
        checks.fail(from, "\"date\" must be a day from 1900 to 2100 such as \"2026-06-21\", not " + excerpt(text));
    }
    return date;
}

double ranged(const SceneChecks& checks, const JsonValue& object, const char* name, double otherwise, double least,
              double most) {
    const JsonValue* value = object.find(name);
    const double given = value == nullptr ? otherwise : checks.number(*value, quoted(name));
    if (!(given >= least && given <= most)) {
        checks.fail(*value, quoted(name) + " must be from " + text_of(least) + " to " + text_of(most) + ", not " +
                                text_of(given));
    }
    return given;
}

/// "latitude", "longitude", "date", "time" in hours, "time_zone", "north".
SunPosition sun_at(const SceneChecks& checks, const JsonValue& from, const std::string& what, Vec3& towards) {
    checks.required(from, what, "latitude");
    checks.required(from, what, "longitude");
    const JsonValue& time = checks.required(from, what, "time");
    const double latitude = ranged(checks, from, "latitude", 0.0, -90.0, 90.0);
    const double longitude = ranged(checks, from, "longitude", 0.0, -180.0, 180.0);
    const double hours = ranged(checks, from, "time", 0.0, 0.0, 24.0);
    const double zone = ranged(checks, from, "time_zone", 0.0, -15.0, 15.0);
    const Date date = read_date(checks, checks.required(from, what, "date"));
    const SunPosition position = sun_position(julian_day(date, hours - zone), latitude, longitude);
    if (!(position.elevation > 0.0)) {
        checks.fail(time, "the sun is below the horizon at this time, at an elevation of " +
                              text_of(position.elevation) +
                              " degrees: see that \"time_zone\" (hours east of universal time) is that of the place");
    }
    const Vec3& up = checks.up();
    Vec3 north = default_north(up);
    if (const JsonValue* given = from.find("north")) {
        north = checks.direction(*given, quoted("north"));
        if (!(north.cross(up).norm() > 1e-6)) {
            checks.fail(*given, "\"north\" must not be vertical");
        }
    }
    towards = towards_sun(position, up, north).normalized();
    return position;
}

/// What says nothing without a "date".
void refuse_parts_of_time(const SceneChecks& checks, const JsonValue& from) {
    for (const char* const name : {"latitude", "longitude", "time", "time_zone", "north"}) {
        if (const JsonValue* given = from.find(name)) {
            checks.fail(*given, quoted(name) + " places the sun together with a \"date\", which is not given");
        }
    }
}

} // namespace

void read_luminaire_light(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const std::string what = "a luminaire";
    checks.members(from, what,
                   {"type", "name", "file", "position", "direction", "look_at", "c0", "luminous_flux", "scale",
                    "colour", "as", "lamp_set"});
    const JsonValue& named = checks.required(from, what, "file");
    const std::filesystem::path path = checks.file_beside(named, quoted("file"));
    const JsonValue* set = from.find("lamp_set");
    const Luminaire luminaire = [&] {
        try {
            return read_luminaire(path, set == nullptr ? 1 : checks.whole(*set, quoted("lamp_set")));
        } catch (const InputError& error) {
            checks.fail(named, "\"file\": " + std::string(error.what()));
        }
    }();
    soup.files.push_back(path);
    soup.files.insert(soup.files.end(), luminaire.files.begin(), luminaire.files.end());
    soup.notes.insert(soup.notes.end(), luminaire.notes.begin(), luminaire.notes.end());
    soup.photometric = true;
    PointLight light;
    light.name = checks.name_of(from);
    light.position = checks.position(checks.required(from, what, "position"), quoted("position"));
    orient_luminaire(checks, from, light);
    light.distribution = luminaire.distribution;
    const double tilt = std::acos(std::clamp(-light.direction.dot(checks.up()), -1.0, 1.0)) / degree_in_radians;
    double candela = light.distribution->largest() * luminaire.tilt_factor(tilt);
    const JsonValue *flux = from.find("luminous_flux"), *scale = from.find("scale");
    if (flux != nullptr && scale != nullptr) {
        checks.fail(*scale, "a luminaire takes \"scale\" or \"luminous_flux\", not both");
    }
    if (flux != nullptr) {
        candela = checks.positive(*flux, quoted("luminous_flux")) / light.distribution->flux() *
                  light.distribution->largest();
    } else if (scale != nullptr) {
        candela *= checks.positive(*scale, quoted("scale"));
    }
    Rgb colour = Rgb::Ones();
    if (const JsonValue* given = from.find("colour")) {
        colour = checks.colour(*given, quoted("colour"));
        const double luminance = colour.matrix().dot(luminance_weights);
        if (!(luminance > 0.0)) {
            checks.fail(*given, "\"colour\" must not be black");
        }
        colour /= luminance; // the candela of the file stay
    }
    light.intensity = candela / lumens_per_watt * colour;
    if (!(light.intensity < 1e30).all()) {
        checks.fail(from, "the intensity of this luminaire exceeds 1e30 W/sr: correct \"scale\" or \"luminous_flux\"");
    }
    if (const JsonValue* as = from.find("as")) {
        const std::string& kind = checks.text(*as, quoted("as"));
        if (kind != "point" && kind != "area") {
            checks.refuse_name(*as, kind, "\"as\": " + excerpt(kind) + " is not known", {"point", "area"});
        }
        if (kind == "area") {
            if (!(luminaire.length > 0.0 && luminaire.width > 0.0)) {
                checks.fail(*as, path.string() + " states no luminous opening with a length and a width: use "
                                                 "\"as\": \"point\"");
            }
            light.half_length = 0.5 * luminaire.length;
            light.half_width = 0.5 * luminaire.width;
            light.is_round = luminaire.is_round;
        }
    }
    soup.lights.points.push_back(std::move(light));
}

Sun read_sun(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const std::string what = "a sun";
    checks.members(from, what,
                   {"type", "name", "towards", "irradiance", "illuminance", "angular_diameter", "latitude", "longitude",
                    "date", "time", "time_zone", "north"});
    Sun sun;
    sun.name = checks.name_of(from);
    const bool by_time = from.find("date") != nullptr;
    if (by_time == (from.find("towards") != nullptr)) {
        checks.refuse_choice(from, what, "\"towards\"", "\"date\" (with latitude, longitude and time)", by_time);
    }
    if (by_time) {
        const SunPosition position = sun_at(checks, from, what, sun.towards);
        if (from.find("irradiance") == nullptr && from.find("illuminance") == nullptr) {
            soup.clear_suns.push_back({soup.lights.suns.size(), clear_sky_sun(position), clear_sky_sunlight(position)});
        }
    } else {
        refuse_parts_of_time(checks, from);
        sun.towards = checks.direction(checks.required(from, what, "towards"), quoted("towards"));
    }
    if (!by_time || from.find("irradiance") != nullptr || from.find("illuminance") != nullptr) {
        sun.irradiance = checks.light(from, what, "irradiance", "illuminance", soup.photometric);
    }
    sun.disc = std::sin(0.5 * degree_in_radians * ranged(checks, from, "angular_diameter", 0.0, 0.0, 90.0));
    return sun;
}

namespace {

/// A type of CIE S 011 by number, or one of those that the standard calls by a name.
std::size_t cie_type(const SceneChecks& checks, const JsonValue& from) {
    constexpr std::array<std::pair<std::string_view, std::size_t>, 5> named{
        {{"overcast", 1}, {"uniform", 5}, {"clear", 12}, {"clear polluted", 13}, {"traditional overcast", 16}}};
    if (from.kind == JsonValue::Kind::text) {
        for (const auto& [name, type] : named) {
            if (from.text == name) {
                return type;
            }
        }
    } else if (const std::size_t type = checks.whole(from, quoted("sky")); type >= 1 && type <= 16) {
        return type;
    }
    checks.fail(from, "\"sky\" must be a type of CIE S 011 from 1 to 15, or 16, or \"overcast\" (1), \"uniform\" (5), "
                      "\"clear\" (12), \"clear polluted\" (13) or \"traditional overcast\" (16)");
}

} // namespace

void read_cie_sky(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup) {
    const std::string what = "a sky";
    checks.members(from, what,
                   {"type", "sky", "sun", "latitude", "longitude", "date", "time", "time_zone", "north", "illuminance",
                    "irradiance", "zenith_luminance", "zenith_radiance", "ground_reflectance"});
    const std::size_t type = cie_type(checks, checks.required(from, what, "sky"));
    const bool even = type == 1 || type == 3 || type == 5 || type == 16;
    const JsonValue *towards = from.find("sun"), *date = from.find("date");
    if ((towards != nullptr && date != nullptr) || (!even && towards == nullptr && date == nullptr)) {
        checks.refuse_choice(from, "a CIE sky of type " + std::to_string(type), "\"sun\" (direction towards it)",
                             "\"date\" (with latitude, longitude and time)", towards != nullptr);
    }
    Vec3 sun = checks.up();
    if (date == nullptr) {
        refuse_parts_of_time(checks, from);
    }
    if (date != nullptr) {
        sun_at(checks, from, what, sun);
    } else if (towards != nullptr) {
        sun = checks.direction(*towards, quoted("sun"));
        if (!(sun.dot(checks.up()) >= 0.0)) {
            checks.fail(*towards, "the sun of a CIE sky must not be below the horizon");
        }
    }
    auto sky = std::make_shared<CieSky>(static_cast<int>(type), checks.up(), sun);
    const bool level = from.find("illuminance") != nullptr || from.find("irradiance") != nullptr;
    const bool zenith = from.find("zenith_luminance") != nullptr || from.find("zenith_radiance") != nullptr;
    if (level == zenith) {
        checks.refuse_choice(from, "a CIE sky", "\"illuminance\" or \"irradiance\" (of a level surface)",
                             "\"zenith_luminance\" or \"zenith_radiance\"", level);
    }
    if (level) {
        sky->scale_to_irradiance(checks.light(from, what, "irradiance", "illuminance", soup.photometric));
    } else {
        sky->scale_to_zenith(checks.light(from, what, "zenith_radiance", "zenith_luminance", soup.photometric));
    }
    if (const JsonValue* ground = from.find("ground_reflectance")) {
        const Rgb at_zenith = sky->radiance(checks.up()) / sky->relative(checks.up());
        sky->set_ground(checks.reflectance_of(*ground, "ground_reflectance") * at_zenith * sky->level_irradiance() *
                        std::numbers::inv_pi);
    }
    soup.lights.dome = std::move(sky);
}

} // namespace difusa
