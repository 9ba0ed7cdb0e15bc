// Lights grouped under names, so that a user can brighten or dim them afterwards: light is additive, so a bake that
// keeps each light's contribution separate need not be repeated for that.
#pragma once

#include <difusa/scene/scene.h>

#include <string>
#include <vector>

namespace difusa {

/// A partition of the lights of a scene into sets whose contributions are kept separate.
struct LightSets {
    std::vector<std::string> names;          ///< one for each set
    std::vector<Index> material, sun, point; ///< the set of the light each emits
    Index sky = 0;                           ///< the set of the uniform sky and the dome

    std::size_t count() const { return names.size(); }
};

/// All lights in one set without a name.
LightSets all_lights(const Scene& scene);

/// One set for each group of lights that emit. Emitting materials belong to their `light_group`, or by default to a
/// group with their name; suns and point lights to one with their name, or by default "sun", "point", "spot" or
/// "luminaire"; the sky to "sky". In the order: materials, suns, point lights, sky. Names are unique; characters a file
/// cannot hold (storable_text), or that would end a line, become '_'. Without any light, the single set of all_lights.
LightSets light_groups(const Scene& scene);

} // namespace difusa
