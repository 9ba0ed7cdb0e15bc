// Reads files written by field_file.h, and similar ones from other programs.
#pragma once

#include <difusa/io/field_file.h>

#include <filesystem>

namespace difusa {

/// Reads VTK XML PolyData (`.vtp`) or PLY (`.ply`), chosen by the file name.
///
/// Files from `write_field` are restored as written: `.vtp` exactly (except `quality`, which it does not store), `.ply`
/// as far as PLY can: points and triangles exactly, normals and quality as floats, notes as text.
///
/// From other programs: all encodings of VTK's XML format (text, base64, appended; compressed or not), all of PLY's;
/// polygons and strips become triangles (a polygon's cell values go to each of them, polygons without area are
/// dropped); real numbers become doubles; whole numbers become 32-bit ones if they fit, otherwise doubles. Lines and
/// text arrays over points or cells are dropped; so are cell arrays of a cloud that does not have one vertex cell per
/// point. Unnamed components are called 0, 1, ...; PLY's red, green and blue bytes become the array `display_rgb`, its
/// other properties scalars under their own names.
///
/// Throws InputError, naming the file, the place and the remedy, if it cannot be opened, is of another format,
/// truncated or damaged, has corners that are not points or coordinates that are not finite, or a polygon that crosses
/// itself; ResourceError if it does not fit into memory.
FieldFile read_field(const std::filesystem::path& file);

} // namespace difusa
