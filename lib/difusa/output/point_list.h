// The user's list of points at which to report the light.
#pragma once

#include <difusa/bake/options.h>

#include <filesystem>
#include <vector>

namespace difusa {

/// Reads a table of points: on each line x y z, or x y z nx ny nz with a normal of any nonzero length, separated by
/// commas, semicolons (not both) or blanks. `#` starts a comment. Numbers may be quoted. The first line may be a
/// heading, which must be one of those two, in upper or lower case.
/// Throws InputError, naming the line, for anything else, and for a table without points.
std::vector<ListedPoint> read_point_list(const std::filesystem::path& file);

} // namespace difusa
