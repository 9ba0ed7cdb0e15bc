#include "scenes.h"

namespace scenes {

namespace {

struct Materials {
    unsigned emitter, receiver, mirror;
};

Materials add_materials(Surface& surface) {
    return {surface.add({"emitter", {0.5, 0.5, 0.5}, {1, 1, 1}}), surface.add({"receiver", {0.5, 0.5, 0.5}, {}}),
            surface.add({"mirror", {0, 0, 0}, {}, {1, 1, 1}})};
}

/// The rectangle with corner a and edges u and v; its front is u × v.
void add_rectangle(Surface& surface, unsigned material, const Vector& a, const Vector& u, const Vector& v) {
    surface.polygon({a,
                     {a.x + u.x, a.y + u.y, a.z + u.z},
                     {a.x + u.x + v.x, a.y + u.y + v.y, a.z + u.z + v.z},
                     {a.x + v.x, a.y + v.y, a.z + v.z}},
                    material);
}

} // namespace

Scene mirror_single() {
    Scene scene;
    scene.surface.remarks = {
        "The situation of one mirror of a paper on mirrors in radiosity: two unit squares that see each other only in",
        "a mirror above them. Lengths are in metres, z is up. By data/generator/mirror_situations.cpp.",
    };
    const auto [emitter, receiver, mirror] = add_materials(scene.surface);
    const Vector x{1, 0, 0}, y{0, 1, 0};
    add_rectangle(scene.surface, emitter, {0, 0, 0}, x, y);
    add_rectangle(scene.surface, receiver, {2, 0, 0}, x, y);
    add_rectangle(scene.surface, mirror, {0.5, -0.25, 2}, {0, 1.5, 0}, {2, 0, 0});
    scene.camera = {{1.5, -6.0, 1.5}, {1.5, 0.5, 0.8}, 40.0};
    return scene;
}

Scene mirror_double() {
    Scene scene;
    scene.surface.remarks = {
        "The situation of several mirrors of a paper on mirrors in radiosity: two unit squares that see each other "
        "only",
        "in a periscope of two mirrors. Lengths are in metres, z is up. By data/generator/mirror_situations.cpp.",
    };
    const auto [emitter, receiver, mirror] = add_materials(scene.surface);
    const unsigned wall = scene.surface.add({"wall", {0, 0, 0}, {}});
    const Vector y{0, 1, 0}, z{0, 0, 1}, slope{1, 0, 1}, across{0, 1.5, 0};
    add_rectangle(scene.surface, emitter, {-1, 0, 0}, y, z);
    add_rectangle(scene.surface, receiver, {4, 0, 2}, z, y);
    add_rectangle(scene.surface, mirror, {1, -0.25, 2}, across, slope);
    add_rectangle(scene.surface, mirror, {1, -0.25, 0}, slope, across);
    add_rectangle(scene.surface, wall, {1, -0.25, 1}, across, z);
    add_rectangle(scene.surface, wall, {2, -0.25, 1}, z, across);
    scene.camera = {{1.5, -8.0, 1.5}, {1.5, 0.5, 1.5}, 40.0};
    return scene;
}

} // namespace scenes
