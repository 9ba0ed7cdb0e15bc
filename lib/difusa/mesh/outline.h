// The corners of one face as they run around it, freed of what encloses nothing.
#pragma once

#include <difusa/core/types.h>

#include <vector>

namespace difusa {

/// A corner of a face: the place, and the corner of the file that stands there (which has colour and texture).
struct Corner {
    Index place;  ///< number of the point all points at this place are merged into
    Index source; ///< number of the corner in the file
};

using Outline = std::vector<Corner>;

/// Number of different places among the corners.
std::size_t distinct_places(const Outline& outline);

/// Removes corners at the place of the one before, and spikes: sides that run out to a corner and straight back the
/// same way (a b a becomes a). What is left has three corners or more, or encloses nothing.
void remove_repetitions(Outline& outline);

/// Brings outlines around the same face to one form: starts at the least place and goes on towards the lesser of its
/// two neighbours. Returns true if that reversed the direction.
bool make_canonical(Outline& outline);

} // namespace difusa
