// The files of a basis inspection: fields on the fine mesh, and the sites.
#pragma once

#include <difusa/io/field_file.h>
#include <difusa/study/inspect_basis.h>

#include <filesystem>
#include <string>

namespace difusa {

/// Point arrays: element (phi of the first element shown), element_17 (each further one, by its number), sum, lebesgue,
/// overlap, nearest_site, Normals. Cell array: original_face_id. Notes: version, options, elements and the positions of
/// their sites.
FieldFile field_of(const BasisInspection& inspection);

/// The sites as a point cloud, row i for element i: Normals, element (its number), shown (1 if `field_of` has it),
/// radius, reach (of the element, from its site), area (∫ phi_i dA), at_own_site (phi_i(p_i)), original_face_id,
/// region.
FieldFile sites_of(const BasisInspection& inspection);

/// A few lines for the user: sum, overlap, Lebesgue constant, and the elements shown.
std::string summary_of(const BasisInspection& inspection);

/// Writes field_of, and sites_of if `sites` is a name: both, or on failure neither. Throws what `write_field` throws.
void write_inspection(const BasisInspection& inspection, const std::filesystem::path& field,
                      const std::filesystem::path& sites, const Execution& execution);

} // namespace difusa
