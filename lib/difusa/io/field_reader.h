// Reads back what field_file.h writes, and the like from other programs.
#pragma once

#include <difusa/io/field_file.h>

#include <filesystem>

namespace difusa {

/// Reads VTK XML PolyData (`.vtp`) or PLY (`.ply`), chosen by the file name.
///
/// What `write_field` wrote comes back as it was: `.vtp` exactly (but for `quality`, which it does not hold), `.ply` as
/// far as PLY holds it: points and triangles exactly, normals and quality as floats, notes as texts.
///
/// From other programs: all encodings of VTK's XML format (text, base64, appended; compressed or not), all of PLY's;
/// polygons and strips become triangles (a polygon's cell values go to each of them, polygons without area are left
/// out); real numbers become doubles; whole numbers become 32-bit ones where they fit, else doubles. Lines and arrays
/// of texts over points or cells are left out; so are cell arrays of a cloud that is not one vertex cell a point.
/// Components without names are called 0, 1, ...; PLY's red, green and blue bytes are the array `display_rgb`, its
/// other properties are scalars of their own names.
///
/// Throws InputError, naming the file, the place and the remedy, if it cannot be opened, is of another format, cut
/// short or damaged, has corners that are no points or coordinates that are not finite, or a polygon that crosses
/// itself; ResourceError if it does not fit into memory.
FieldFile read_field(const std::filesystem::path& file);

} // namespace difusa
