// The scenes of data/, one file each. Lengths in metres, except where a scene says otherwise.
#pragma once

#include "surface.h"

#include <cstddef>
#include <string>

namespace scenes {

Surface cornell_box();
Surface courtyard();
Surface room();
Surface ball_over_disc();
Surface bowl();
Surface furnace_box();

/// A closed room with walls in fine triangles, three balls and a lamp, of about `triangles` triangles in all, at
/// least 2000 and at most 50 million.
Surface room_with_balls(std::size_t triangles);

/// The whole text of an OFF file with everything wrong that can be mended.
std::string ugly_off();

} // namespace scenes
