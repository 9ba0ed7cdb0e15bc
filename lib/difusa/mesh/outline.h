// The corners of one face in order, without parts that enclose nothing.
#pragma once

#include <difusa/core/types.h>

#include <vector>

namespace difusa {

/// A corner of a face: its point, and the corner in the file it comes from (which has colour and texture coordinates).
struct Corner {
    Index place;  ///< number of the point that all points at this position are merged into
    Index source; ///< number of the corner in the file
};

using Outline = std::vector<Corner>;

/// Number of distinct positions among the corners.
std::size_t distinct_places(const Outline& outline);

/// Removes corners at the same position as the one before, and spikes: sides that run out to a corner and straight back
/// (a b a becomes a). The result has three corners or more, or encloses nothing.
void remove_repetitions(Outline& outline);

/// Normalises outlines of the same face: starts at the lowest place and continues towards the lower of its two
/// neighbours. Returns true if that reversed the direction.
bool make_canonical(Outline& outline);

} // namespace difusa
