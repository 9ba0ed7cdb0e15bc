// `--visibility auto`: the fastest engine available on this machine.
#pragma once

#include <difusa/plugin/registry.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// The engines "auto" tries, in this order; then any other engine by its name. They all give the same hits.
inline constexpr std::array<std::string_view, 2> preferred_visibility{"embree", "cgal"};

/// The engine selected by `choice`: for "auto" the first that is found and starts, otherwise the choice itself. Engines
/// skipped because they do not start are reported in `notes`.
/// Throws UsageError for an unknown name or a wrong parameter, and if "auto" finds none.
std::string choose_visibility(const Registry& registry, std::string_view choice, std::vector<std::string>& notes);

} // namespace difusa
