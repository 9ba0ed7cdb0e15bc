// The scenes of data/, one file each. Lengths in metres, except where a scene says otherwise.
#pragma once

#include "scene.h"
#include "surface.h"

#include <cstddef>
#include <string>

namespace scenes {

Scene cornell_box();
Surface courtyard();
Surface room();
Surface ball_over_disc();
Surface bowl();
Surface furnace_box();

/// The rooms of the dissertation's chapter 6, with their lights.
Scene room_a();
Scene room_b();
Scene room_c();
Scene room_d();

/// A room with a mirror on the wall, and one on a table that throws the sun onto the ceiling.
Scene mirror_room();

/// A room with a polished floor.
Scene glossy_floor();

/// The two situations of a paper on mirrors: squares that see each other in one mirror, and in two.
Scene mirror_single();
Scene mirror_double();

/// Thermal scenes: infinite plates with a shield between them, and an oven.
Scene radiation_shield();
Scene oven();

/// One period of a row of houses along a street, in both directions; and half a bay of a greenhouse, of which
/// symmetry planes and a period make the whole.
Scene street_canyon();
Scene greenhouse_row();

/// A colonnaded hall of some 300,000 triangles, most of them in its sixteen fluted columns.
Scene hall();

/// An engine as a CAD program exports it: closed parts that touch and penetrate each other. As many segments around
/// each part as `triangles` (45,000 to 10 million) allow. std::invalid_argument: too few or too many.
Scene engine(std::size_t triangles);

/// A closed room with finely triangulated walls, three balls and an area light, with `triangles` triangles (2000 to 50
/// million) or up to 7 sqrt(triangles) more: 3 % of 50000, 0.7 % of a million. std::invalid_argument: too few or too
/// many.
Surface room_with_balls(std::size_t triangles);

/// A scene file that lights room.off by luminaires and a CIE sky, and the IES file of the luminaires.
std::string office_json();
std::string office_luminaire_ies();

/// Test case 5.11 of CIE 171:2006: a room with a window, its scene file with an overcast sky, and its points.
Surface daylit_room();
std::string daylit_room_json();
std::string daylit_room_points();

/// The complete text of an OFF file with every defect that can be repaired.
std::string ugly_off();

} // namespace scenes
