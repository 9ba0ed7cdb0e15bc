#include <difusa/import/scene_checks.h>

#include <difusa/core/error.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/plugin/parameters.h>

#include <utility>

namespace difusa {

void SceneChecks::read_conventions(const JsonValue& root) {
    unit_ = unit_of(root, 1.0);
    if (const JsonValue* up = root.find("up")) {
        up_ = up_direction(*up);
    }
}

Rgb SceneChecks::colour(const JsonValue& value, const std::string& what) const {
    Rgb c;
    if (value.kind == JsonValue::Kind::number) {
        c = Rgb::Constant(number(value, what));
    } else if (value.kind == JsonValue::Kind::list && value.items.size() == 3) {
        c = Rgb(vector(value, what).array());
    } else {
        fail(value, what + " must be a number (grey) or a list [r, g, b]");
    }
    if (!(c >= 0.0).all() || !(c <= 1e30).all()) {
        fail(value, what + " must be from 0 to 1e30 in each channel");
    }
    return c;
}

Rgb SceneChecks::light(const JsonValue& object, const std::string& what, const char* radiometric,
                       const char* photometric, bool& is_photometric) const {
    const JsonValue *watts = object.find(radiometric), *lumens = object.find(photometric);
    if ((watts == nullptr) == (lumens == nullptr)) {
        refuse_choice(object, what, quoted(radiometric), quoted(photometric), watts != nullptr);
    }
    if (watts != nullptr) {
        return colour(*watts, quoted(radiometric));
    }
    is_photometric = true;
    return colour(*lumens, quoted(photometric)) / lumens_per_watt;
}

Rgb SceneChecks::reflectance_of(const JsonValue& value, std::string_view name) const {
    const Rgb rho = colour(value, quoted(name));
    if (!(rho <= 1.0).all()) {
        fail(value, quoted(name) + " must be from 0 (none) to 1 (all of the light) in each channel");
    }
    return rho;
}

double SceneChecks::positive(const JsonValue& value, const std::string& what) const {
    const double given = number(value, what);
    if (!(given > 0.0)) {
        fail(value, what + " must be above 0, not " + text_of(given));
    }
    return given;
}

double SceneChecks::unit_of(const JsonValue& object, double otherwise) const {
    static const std::vector<std::pair<std::string, double>> known{{"m", 1.0},  {"cm", 0.01},   {"mm", 0.001},
                                                                   {"km", 1e3}, {"in", 0.0254}, {"ft", 0.3048}};
    const JsonValue* value = object.find("unit");
    if (value == nullptr) {
        return otherwise;
    }
    if (value->kind == JsonValue::Kind::text) {
        for (const auto& [name, metres] : known) {
            if (value->text == name) {
                return metres;
            }
        }
        fail(*value,
             "\"unit\" is " + excerpt(value->text) + "; it must be one of m cm mm km in ft, or a number of metres");
    }
    return positive(*value, quoted("unit"));
}

Vec3 SceneChecks::direction(const JsonValue& value, const std::string& what) const {
    const Vec3 v = vector(value, what);
    if (v == Vec3::Zero()) {
        fail(value, what + " is zero and has no direction");
    }
    return v.stableNormalized();
}

Vec3 SceneChecks::up_direction(const JsonValue& value) const {
    if (value.kind == JsonValue::Kind::text) {
        for (int k = 0; k < 3; ++k) {
            if (value.text == std::string(1, "xyz"[k])) {
                return Vec3::Unit(k);
            }
        }
        fail(value, "\"up\" is " + excerpt(value.text) + "; it must be x, y, z or a list of 3 numbers");
    }
    return direction(value, quoted("up"));
}

Vec3 SceneChecks::position(const JsonValue& value, const std::string& what) const {
    return unit_ * vector(value, what);
}

Vec3 SceneChecks::direction_or_target(const JsonValue& object, const std::string& what, const char* name,
                                      const Vec3& from) const {
    const JsonValue *given = object.find(name), *target = object.find("look_at");
    if ((given == nullptr) == (target == nullptr)) {
        refuse_choice(object, what, quoted(name), "\"look_at\"", given != nullptr);
    }
    if (given != nullptr) {
        return direction(*given, quoted(name));
    }
    const Vec3 way = position(*target, quoted("look_at")) - from;
    if (way == Vec3::Zero()) {
        fail(*target, "\"look_at\" is the position from which " + what + " looks");
    }
    return way.stableNormalized();
}

void SceneChecks::refuse_name(const JsonValue& at, const std::string& name, const std::string& missing,
                              const std::vector<std::string>& known) const {
    const std::string near = nearest_name(name, known);
    std::string message = missing + (near.empty() ? "" : "; did you mean " + excerpt(near) + "?");
    if (near.empty()) {
        message += known.empty() ? "; it has none" : ". It has:";
        for (std::size_t i = 0; i < known.size() && i < 20; ++i) {
            message += (i == 0 ? " " : ", ") + excerpt(known[i]);
        }
        message += known.size() > 20 ? ", ..." : "";
    }
    fail(at, message);
}

std::filesystem::path SceneChecks::file_beside(const JsonValue& value, const std::string& what) const {
    const std::string& name = text(value, what);
    const std::filesystem::path path = folder_ / name;
    try {
        check_readable(path);
    } catch (const InputError& error) {
        fail(value, what + ": " + error.what());
    }
    return path;
}

std::string SceneChecks::name_of(const JsonValue& object) const {
    const JsonValue* name = object.find("name");
    return name == nullptr ? "" : text(*name, quoted("name"));
}

void SceneChecks::refuse_choice(const JsonValue& at, const std::string& what, const std::string& one,
                                const std::string& other, bool both) const {
    fail(at, both ? what + " has both " + one + " and " + other + ", but only one is allowed: remove one"
                  : what + " needs either " + one + " or " + other + ": add one");
}

} // namespace difusa
