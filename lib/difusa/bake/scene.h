// The scene of a bake: read, repaired, with the lights of the options added.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/plugin/registry.h>
#include <difusa/repair/polygon_soup.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// Reads a mesh or scene file. Throws UsageError if the outputs would overwrite a file that is read or a plugin.
PolygonSoup read_apart_from(const std::vector<std::filesystem::path>& outputs, const Registry& registry,
                            const std::filesystem::path& file);

/// What is done to the scene of a file before the lights of the options are added.
using SceneChange = std::function<void(Scene&)>;

/// Adds the suns and point lights of the options to the scene's; their sky, if there is one, replaces the scene's and
/// the suns split off from it.
void add_chosen_lights(Scene& scene, const BakeOptions& options);

/// True if a sun, a point light, a sky or a face shines.
bool has_light(const Scene& scene);

/// Gives a scene that nothing lights a sky, uniform or graded as the options say, and notes it.
void assume_sky(BakeResult& result, Scene& scene, const Execution& execution);

/// Reads and repairs a mesh or scene file into `result`: file, diagnosis, scene, camera, channels, and the options
/// determined by the file. Throws what `read_apart_from` throws. Phases: "read", "check mesh".
void read_into(BakeResult& result, const Registry& registry, const std::filesystem::path& file,
               const Execution& execution, const SceneChange& change = {});

/// The same for a scene built by a program, checked as if it were read from a file.
void adopt_into(BakeResult& result, Scene scene, const std::string& name, const Execution& execution,
                const SceneChange& change = {});

} // namespace difusa
