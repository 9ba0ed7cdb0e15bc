#include <difusa/import/gltf_lights.h>

#include <difusa/core/photometry.h>
#include <difusa/scene/sound_scene.h>

#include <cmath>
#include <numbers>

namespace difusa {

namespace {

/// Where a direction of the node points: its -z, along which cameras look and lights shine. What a scale of 0 destroys
/// is recovered from the rotations alone.
Vec3 turned(const GltfInput& input, const JsonValue& at, const GltfNodePlace& node, const Vec3& direction) {
    Vec3 result = (node.place.linear * direction).stableNormalized();
    if (!is_unit(result)) {
        result = (node.turn * direction).stableNormalized();
    }
    if (!is_unit(result)) {
        input.checks().fail(at,
                            "the direction of a camera or light is undefined, since the matrix of its node or of one "
                            "above it has a scale of 0: export the scene again");
    }
    return result;
}

} // namespace

void read_gltf_camera(GltfInput& input, const JsonValue& index, const GltfNodePlace& place) {
    const JsonValue& from = input.file().entry("cameras", index);
    const JsonValue* perspective = from.find("perspective");
    if (perspective == nullptr) {
        input.note("cameras without perspective", "they are ignored");
        return;
    }
    if (input.soup().camera) {
        input.note("additional cameras", "only the first one is used");
        return;
    }
    input.checks().object(*perspective, quoted("perspective"));
    Camera camera;
    camera.eye = place.place.offset;
    camera.towards = turned(input, index, place, -Vec3::UnitZ());
    camera.up = turned(input, index, place, Vec3::UnitY());
    camera.view_angle =
        input.checks().number(input.checks().required(*perspective, "a camera", "yfov"), quoted("yfov"));
    if (!(camera.view_angle > 0.0 && camera.view_angle < std::numbers::pi) || !camera.eye.allFinite() ||
        !(camera.up.cross(camera.towards).norm() > 1e-6)) {
        input.checks().fail(*perspective, "a camera that shows nothing (its \"yfov\" must be above 0 and below pi): "
                                          "export the scene again");
    }
    input.soup().camera = camera;
}

void read_gltf_light(GltfInput& input, const JsonValue& index, const GltfNodePlace& place) {
    const JsonValue* extension_of_root = input.extension(input.file().root(), "KHR_lights_punctual");
    const std::size_t number_of = input.checks().whole(index, quoted("light"));
    const JsonValue* lights = extension_of_root == nullptr ? nullptr : extension_of_root->find("lights");
    if (lights == nullptr || number_of >= input.checks().list(*lights, quoted("lights")).size()) {
        input.checks().fail(index, "light " + std::to_string(number_of) + " does not exist: export the scene again");
    }
    const JsonValue& from = lights->items[number_of];
    input.checks().object(from, "a light");
    const std::string& type = input.checks().text(input.checks().required(from, "a light", "type"), quoted("type"));
    input.soup().photometric = true;
    const double intensity = input.number(from, "intensity", 1.0);
    const Rgb colour = input.vector(from, "color", Vec3::Ones()).array() * (intensity / lumens_per_watt);
    if (!(colour >= 0.0).all() || !(colour <= 1e30).all() || !place.place.offset.allFinite()) {
        input.checks().fail(from, "a light has a colour or intensity that is negative or too large: correct it");
    }
    if (from.find("range") != nullptr) {
        input.note("lights with a range", "it is ignored: light falls off with the square of the distance");
    }
    if (type == "directional") {
        input.soup().lights.suns.push_back(
            {turned(input, index, place, Vec3::UnitZ()), colour, input.text(from, "name", "")});
        return;
    }
    PointLight light;
    light.position = place.place.offset;
    light.intensity = colour;
    light.name = input.text(from, "name", "");
    if (type == "spot") {
        const JsonValue nothing;
        const JsonValue* spot = from.find("spot");
        const JsonValue& cone = spot == nullptr ? nothing : *spot;
        const double inner = input.number(cone, "innerConeAngle", 0.0);
        const double outer = input.number(cone, "outerConeAngle", 0.25 * std::numbers::pi);
        if (!(inner >= 0.0 && inner <= outer && outer > 0.0 && outer < std::numbers::pi)) {
            input.checks().fail(cone.kind == JsonValue::Kind::null ? from : cone,
                                "the cone of a spot light needs 0 <= inner <= outer angle: export the scene again");
        }
        light.direction = turned(input, index, place, -Vec3::UnitZ());
        light.cos_inner = std::cos(inner);
        light.cos_outer = std::cos(outer);
    } else if (type != "point") {
        input.note("lights of unknown type", "they are ignored");
        return;
    }
    input.soup().lights.points.push_back(light);
}

} // namespace difusa
