// Fuzz target: any bytes as a scene file. Meshes and pictures are files of the folder it runs in; whatever is in them,
// the meshes are one square.
#include <difusa/core/error.h>
#include <difusa/import/scene_file.h>
#include <difusa/repair/soup_check.h>

#include "fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace difusa;
    const auto square = [](const std::filesystem::path& file) {
        PolygonSoup soup;
        soup.file = file.string();
        soup.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)};
        Material material;
        material.name = "paint";
        soup.materials = {material};
        const std::array<Index, 4> corners{0, 1, 2, 3};
        soup.add_face(corners, 0, 1);
        soup.add_face(std::span(corners).first(3), none, 2);
        soup.corner_texture.assign(7, TextureCoordinates(0.5, 0.25));
        return soup;
    };
    try {
        const PolygonSoup soup = parse_scene({reinterpret_cast<const char*>(data), size}, "input", square);
        fuzz::check(soup, 4 * size);
        for (const Sun& sun : soup.lights.suns) {
            fuzz::hold(std::abs(sun.towards.norm() - 1.0) < 1e-6 && (sun.irradiance >= 0.0).all(), "suns are sound");
        }
        for (const PointLight& light : soup.lights.points) {
            fuzz::hold(light.position.allFinite() && std::abs(light.direction.norm() - 1.0) < 1e-6 &&
                           light.cos_outer <= light.cos_inner && (light.intensity >= 0.0).all(),
                       "lights are sound");
        }
        if (soup.camera) {
            fuzz::hold(soup.camera->view_angle > 0.0 && soup.camera->up.cross(soup.camera->towards).norm() > 0.0,
                       "cameras show something");
        }
        try {
            check_soup(soup);
        } catch (const InputError&) { // transforms that send points too far away
        }
    } catch (const InputError& error) {
        fuzz::hold(std::string_view(error.what()).find("input") != std::string_view::npos, "messages name the file");
    }
    return 0;
}
