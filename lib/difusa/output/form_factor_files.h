// Form factors as files: tables, NumPy arrays, Matrix Market.
#pragma once

#include <difusa/form_factors/form_factors.h>
#include <difusa/form_factors/grouped.h>
#include <difusa/form_factors/surfaces.h>

#include <filesystem>
#include <string>

namespace difusa {

enum class FormFactorLayout { sparse, dense };

/// Throws UsageError unless the name ends in .csv, .npz or .mtx.
void check_form_factor_file(const std::filesystem::path& file);

/// Writes to `file`, which appears once it is complete (io/whole_file.h); data/FORM_FACTORS.md describes the formats.
/// Numbers in texts have as many digits as it takes to read the same ones back.
///   .csv  sparse: from,to,form_factor,error, a line for each nonzero, and for each surface a line to "(escapes)"
///         dense: surface,area, a column for each surface, row_sum,escapes
///   .npz  sparse: what scipy.sparse.load_npz reads; dense: the array form_factors; with both, the arrays error, area,
///         row_sum, escapes, names
///   .mtx  Matrix Market, real general: coordinate if sparse, array if dense
/// Throws what `check_form_factor_file` throws, ResourceError if the system refuses or the file would be too large.
void write_form_factors(const FormFactors& F, const Surfaces& surfaces, FormFactorLayout layout,
                        const std::filesystem::path& file);

/// Throws UsageError unless the name ends in .npz.
void check_grouped_file(const std::filesystem::path& file);

/// Writes the links between groups of triangles as arrays to an .npz `file`, likewise; `surfaces`: of the triangles.
/// Throws what `check_grouped_file` throws, ResourceError if the system refuses or the file would be too large.
void write_form_factors(const GroupedFormFactors& F, const Surfaces& surfaces, const std::filesystem::path& file);

/// A table of a few surfaces for people: form factors, row sums, what escapes. `most`: surfaces; empty if there are
/// more.
std::string table_of(const FormFactors& F, const Surfaces& surfaces, std::size_t most = 12);

} // namespace difusa
