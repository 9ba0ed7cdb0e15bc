// `--visibility auto`: the fastest engine that this machine has.
#pragma once

#include <difusa/plugin/registry.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// What "auto" tries, in this order; after these any other engine by its name. The answers are the same.
inline constexpr std::array<std::string_view, 2> preferred_visibility{"embree", "cgal"};

/// The engine that `choice` stands for: of "auto" the first that is found and can be started, otherwise the choice
/// itself. An engine that was passed over because it cannot be started is told in `notes`.
/// Throws UsageError for an unknown name or a wrong parameter, and if "auto" finds none.
std::string choose_visibility(const Registry& registry, std::string_view choice, std::vector<std::string>& notes);

} // namespace difusa
