// Lights by the names under which a user may want to brighten or dim them afterwards: light adds up, so a bake that
// keeps the light of each apart needs no other to do that.
#pragma once

#include <difusa/scene/scene.h>

#include <string>
#include <vector>

namespace difusa {

/// Some of the lights of a scene.
struct LightGroup {
    std::string name;
    std::vector<char> materials; ///< #materials: 1 if what this material emits belongs to the group
    std::vector<char> suns, points;
    bool sky = false; ///< the even sky and the dome
};

/// All lights as one group, which has no name.
LightGroup all_lights(const Scene& scene);

/// Each light that shines is in one group. Emitting materials are in that of their `light_group`, or else of their
/// name; suns and point lights in that of their name, or else "sun", "point" or "spot"; the sky in "sky". In the order:
/// materials, suns, point lights, sky. No two have the same name; what a file cannot hold of a name (storable_text),
/// and what would end a line, is '_' in it.
std::vector<LightGroup> light_groups(const Scene& scene);

/// Emitted radiosity at a surface point as far as it is of the group, W/m².
inline Rgb emission(const Scene& scene, const LightGroup& group, const SurfacePoint& x) {
    return group.materials[scene.mesh.material[x.face]] != 0 ? scene.emission(x) : Rgb(Rgb::Zero());
}

} // namespace difusa
