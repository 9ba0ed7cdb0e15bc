// Lights by the names under which a user may want to brighten or dim them afterwards: light adds up, so a bake that
// keeps the light of each apart needs no other to do that.
#pragma once

#include <difusa/scene/scene.h>

#include <string>
#include <vector>

namespace difusa {

/// A division of the lights of a scene into sets, whose light is kept apart.
struct LightSets {
    std::vector<std::string> names;          ///< one for each set
    std::vector<Index> material, sun, point; ///< the set that what each emits belongs to
    Index sky = 0;                           ///< the set of the even sky and the dome

    std::size_t count() const { return names.size(); }
};

/// All lights in one set, which has no name.
LightSets all_lights(const Scene& scene);

/// A set for each group of lights that shine. Emitting materials are in that of their `light_group`, or else of their
/// name; suns and point lights in that of their name, or else "sun", "point" or "spot"; the sky in "sky". In the order:
/// materials, suns, point lights, sky. No two have the same name; what a file cannot hold of a name (storable_text),
/// and what would end a line, is '_' in it. Without any light the one set of all_lights.
LightSets light_groups(const Scene& scene);

} // namespace difusa
