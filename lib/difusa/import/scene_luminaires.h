// Luminaires, suns and skies of the CIE in scene files.
#pragma once

#include <difusa/import/scene_checks.h>
#include <difusa/repair/polygon_soup.h>

namespace difusa {

/// Adds a light of the type "luminaire" to the soup, with the notes of its file.
void read_luminaire_light(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup);

/// A light of the type "sun": by its direction, or by place, date and time.
Sun read_sun(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup);

/// Sets the sky of the soup to one of the type "cie".
void read_cie_sky(const SceneChecks& checks, const JsonValue& from, PolygonSoup& soup);

} // namespace difusa
