// Visualises a basis: elements, their sum, their overlap and their Lebesgue function on a fine mesh.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/output_mesh.h>
#include <difusa/plugin/registry.h>
#include <difusa/repair/diagnosis.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// Options; as in a bake (BakeOptions), so that the same options show the basis of that bake, unless it leaves out
/// surfaces that no light reaches, or adds sites where none can be seen.
struct InspectOptions {
    std::string basis = "moving-least-squares";
    std::string sampler;             ///< empty: the one that the basis demands, or else "poisson-disk"
    std::string visibility = "auto"; ///< for samplers that cast rays
    double spacing = 0.0;            ///< unit of the mesh; 0: from `sites`
    std::size_t sites = 0;           ///< desired number; 0: as in a bake
    int neighbours = 10;             ///< m
    double output_spacing = 0.0;     ///< longest edge of the output; 0: a sixth of the site spacing
    std::uint64_t seed = 1;
    std::vector<Index> elements; ///< elements to show
    std::vector<Vec3> near; ///< and those with sites nearest to these points; if both are empty, to the mesh's centroid
    std::vector<std::filesystem::path> outputs; ///< as BakeOptions::outputs
};

struct BasisInspection {
    std::string file;
    Diagnosis diagnosis;
    Mesh mesh;
    SiteSet sites;                                            ///< `area` is ∫ phi_i dA, by the same rule as in a bake
    InspectOptions options;                                   ///< with defaults filled in
    std::vector<std::pair<std::string, std::string>> plugins; ///< kind and choice with all parameters
    std::vector<Index> elements;                              ///< those shown, each once

    // At the vertices of the output mesh:
    OutputMesh output;
    Values phi;                   ///< #V by #elements: phi of each element shown
    std::vector<double> sum;      ///< #V, sum_i phi_i
    std::vector<double> lebesgue; ///< #V, sum_i |phi_i|: amplification of errors in the coefficients
    std::vector<Index> overlap;   ///< #V, number of nonzero elements
    std::vector<Index> nearest;   ///< #V, site at the smallest site distance; nearest in space if all are infinite

    // For each element:
    std::vector<double> reach; ///< #S, distance from the site to the farthest vertex where the element is nonzero; 0 if
                               ///< there is none
    std::vector<double> at_own_site; ///< #S, phi_i(p_i)

    // Over the surface, by area (a vertex represents a third of each triangle around it). A basis that sums to one has
    // no element where none of its sites is in sight, as under what stands on a floor: that part is left out.
    double mean_overlap = 0.0, mean_lebesgue = 0.0;
    double left_out = 0.0; ///< the part that is left out, of all of the surface

    /// True if vertex v is part of what is judged.
    bool counts(std::size_t v) const { return !sums_to_one || overlap[v] > 0; }
    bool sums_to_one = false;
};

/// Reads the mesh, places sites, binds the basis, and evaluates it. Each step reports itself as a phase of
/// `execution.progress`. Throws UsageError (plugin, option, or a nonexistent element: names the range; an
/// output that would overwrite a file that is read), InputError, ResourceError, Interrupted.
BasisInspection inspect_basis(const Registry& registry, const std::filesystem::path& file,
                              const InspectOptions& options, const Execution& execution);

} // namespace difusa
