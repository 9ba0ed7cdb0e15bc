// Merges points at exactly the same position.
#pragma once

#include <difusa/core/types.h>

#include <span>
#include <vector>

namespace difusa {

/// For each point with used[p] != 0 the first used point with equal coordinates (0 and -0 are equal), possibly itself;
/// `none` for the others. Used points are finite. Uses sorting, so that no choice of coordinates makes it slow.
std::vector<Index> first_at_place(std::span<const Vec3> points, std::span<const char> used);

} // namespace difusa
