// The formats a field can be written in. Each writes `field`, whose arrays are consistent, into a file that the caller
// commits, and throws ResourceError on failure.
#pragma once

#include <difusa/io/field_file.h>
#include <difusa/io/whole_file.h>

namespace difusa {

/// VTK XML PolyData: everything.
void write_vtp(const FieldFile& field, WholeFile& file, const Execution& execution);

/// PLY, binary little-endian: geometry, normals, colours, quality; the notes as comments.
void write_ply(const FieldFile& field, WholeFile& file, const Execution& execution);

/// glTF 2.0, binary, +Y upwards: geometry, normals, colours (COLOR_0, linear, unlit), every array of real numbers of up
/// to four components (_RADIOSITY and so on, single precision); the notes as `extras` of the asset. Throws
/// ResourceError if that is more than 4 GiB.
void write_glb(const FieldFile& field, WholeFile& file, const Execution& execution);

/// In the format implied by the name `file`, checked and chosen as in `write_field` without `whole`.
void write_field(const FieldFile& field, const std::filesystem::path& file, WholeFile& whole,
                 const Execution& execution);

/// The same for a field that has a value everywhere. Throws what `require_finite` throws.
void write_finite_field(const FieldFile& field, const std::filesystem::path& file, WholeFile& whole,
                        const Execution& execution);

} // namespace difusa
