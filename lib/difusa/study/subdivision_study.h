// What dividing patches where the light varies is worth: elements, unknowns, rays and time beside those of an even
// mesh.
#pragma once

#include <difusa/study/estimate_study.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

struct SubdivisionTrial {
    std::string scene, method;
    EstimateTrial trial;
    /// Elements of an even mesh with the same error, by the power law between the nearest even meshes; none of the even
    /// ones themselves, and where the error is outside of theirs.
    std::optional<double> even;
};

/// The classical method with all light carried by the mesh and hemicubes (L 29), with about `elements` elements and
/// multiples of that: on even meshes (1, 2, 4, 8, 16), and on patches that are divided, which send light as a whole
/// (1, 2, 4, 8), or whose parts each send their own (4, 8). `tell` is called with each.
std::vector<SubdivisionTrial> compare_subdivision(const Registry& registry, const KnownLight& light,
                                                  const BakeOptions& common, std::size_t elements,
                                                  const Execution& execution,
                                                  const std::function<void(const SubdivisionTrial&)>& tell);

/// A row of a Markdown table, and its header: elements, unknowns, rays, processor time up to the field, error of the
/// radiosity relative to the reflected radiosity, elements of an even mesh with that error.
std::string subdivision_header();
std::string subdivision_row(const SubdivisionTrial& trial);

/// As CSV.
std::string subdivision_csv_header();
std::string subdivision_csv_row(const SubdivisionTrial& trial);

/// Error against the number of elements, a line for each method, as SVG.
std::string subdivision_chart(const std::vector<SubdivisionTrial>& trials);

} // namespace difusa
