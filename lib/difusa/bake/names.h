// What a message says of a name that nothing has.
#pragma once

#include <difusa/scene/scene.h>

#include <string>
#include <vector>

namespace difusa {

/// "there is no material `lmap`, did you mean lamp? There are: lamp, wall".
std::string unknown_name(const std::string& what, const std::string& name, const std::vector<std::string>& all);

/// The names of the materials that faces have.
std::vector<std::string> names_of_materials_in_use(const Scene& scene);

} // namespace difusa
