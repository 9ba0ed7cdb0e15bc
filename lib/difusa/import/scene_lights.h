// Lights, sky and camera of scene files.
#pragma once

#include <difusa/import/scene_checks.h>
#include <difusa/repair/polygon_soup.h>

namespace difusa {

/// Adds an entry of "lights" to the soup.
void read_scene_light(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup);

/// Adds "sky" to the soup, with the suns of its image.
void read_scene_sky(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup);

Camera scene_camera(const SceneChecks& checks, const JsonValue& from);

} // namespace difusa
