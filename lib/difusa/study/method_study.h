// Methods beside each other on the same scenes, error against time, unknowns and memory: the classical one of the
// lectures (patches or vertices of a mesh, form factors by hemicube) beside the meshless one; and the default options
// beside others.
#pragma once

#include <difusa/study/estimate_study.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// A scene of a reference case's kind for methods whose patches are no larger than the mesh's triangles, if the case
/// has a mesh too fine for them: ball-over-disc with 320 and 216 triangles. Its exact solution is that of other bodies.
std::optional<Scene> coarse_scene(const std::string& case_name);

/// A method of the comparison.
struct ComparedMethod {
    std::string name;
    BakeOptions bake; ///< the common options with what the method chooses
};

/// Classical, with all light carried by the mesh: patches with hemicubes, shown flat and Gouraud shaded (L 53), and
/// vertices with hemicubes. Between: vertices with direct light evaluated exactly. Meshless: the default basis, with
/// all light carried by it, and with exact direct light, the default.
std::vector<ComparedMethod> classical_and_meshless(const BakeOptions& common);

/// The default options, which grade the sites; evenly spaced sites; these with each of the other bases; and the
/// defaults of version 0.1.0.
std::vector<ComparedMethod> defaults_and_others(const BakeOptions& common);

struct MethodTrial {
    std::string scene, method;
    EstimateTrial trial;
};

/// One bake of each method with about each of these numbers of sites. `tell` is called with each.
std::vector<MethodTrial> compare_methods(const Registry& registry, const KnownLight& light,
                                         const std::vector<ComparedMethod>& methods,
                                         const std::vector<std::size_t>& sites, const Execution& execution,
                                         const std::function<void(const MethodTrial&)>& tell);

/// A row of a Markdown table, and its header: sites, megabytes of the transport, processor time up to the field, rms
/// error of the radiosity relative to the reflected radiosity.
std::string method_header();
std::string method_row(const MethodTrial& trial);

/// As CSV.
std::string method_csv_header();
std::string method_csv_row(const MethodTrial& trial);

/// What was measured elsewhere.
struct MeasuredElsewhere {
    std::string name;
    double seconds = 0.0, error = 0.0; ///< relative
};

/// Error against processor time, a line for each method, as SVG. `title`: after the name of the scene.
std::string method_chart(const std::vector<MethodTrial>& trials, const std::string& title,
                         const std::vector<MeasuredElsewhere>& elsewhere = {});

} // namespace difusa
