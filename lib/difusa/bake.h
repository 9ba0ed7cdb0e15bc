// The whole way from a mesh file to a radiosity field:
// read, diagnose, scene, sites, basis, transport, direct light, solve, evaluate, judge.
#pragma once

#include <difusa/algebra/solver.h>
#include <difusa/core/progress.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/output_mesh.h>
#include <difusa/plugin/registry.h>
#include <difusa/radiosity/energy.h>
#include <difusa/radiosity/error_estimate.h>
#include <difusa/radiosity/field.h>
#include <difusa/radiosity/solution.h>
#include <difusa/repair/diagnosis.h>
#include <difusa/scene/scene.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// A place where a user wants to know the light: the nearest point of the surface is evaluated.
struct ListedPoint {
    Vec3 position = Vec3::Zero();
    std::optional<Vec3> normal; ///< only surface whose front turns from it by less than 90° counts; absent: all
};

/// Something that the scene does not need and that was therefore not done.
struct Saving {
    std::string what;    ///< "shadow rays"
    std::string because; ///< "the room is convex and empty"
    std::string unit;    ///< "rays"
    double amount = 0.0; ///< what it would have taken
};

/// What a user may choose. Plugins are named as on the command line, "name" or "name:parameter=value,...".
struct BakeOptions {
    std::string basis = "normalized-radial";
    std::string sampler = "poisson-disk";
    std::string transport = "gather"; ///< "gather", or "pairwise" with the parameter areas=integral|neighbours
    std::string directions = "low-discrepancy";
    std::string kernel = "disc";     ///< of pairwise transport
    std::string visibility = "auto"; ///< plugin/visibility_choice.h; of a result the engine that was used
    std::string solver = "krylov";
    std::string projection = "natural"; ///< discretisation/projection.h
    /// Where coefficients are the values at the sites, the equation is solved with them, which is sure to converge, and
    /// the field evaluated with coefficients after so many sweeps of residual correction (ProjectionKind::corrected),
    /// which smooths far less. 0: with the same.
    int correction = 2;
    /// The light of suns, point lights and lamps: "exact", computed where it is wanted, or "interpolated" as a part of
    /// the unknown, as in the dissertation.
    std::string direct = "exact";
    /// The same light after one reflection: "gathered" where rays hit, or "interpolated" between the sites (cheaper;
    /// the only way of pairwise transport). Empty: gathered where that is possible.
    std::string first_bounce;

    double spacing = 0.0;                    ///< unit of the scene; 0: from `sites`
    std::size_t sites = 0;                   ///< wanted number; 0: 5000
    int neighbours = 10;                     ///< m
    std::size_t rays = 1024;                 ///< a site
    SolveOptions solve;                      ///< tolerance, iterations
    std::size_t final_gather = 0;            ///< rays from each output vertex; 0: the basis is evaluated
    std::optional<std::size_t> error_points; ///< of the error estimate; 0: none; absent: #S / 8 in 128..4096
    std::optional<Rgb> reflectance;          ///< of faces without a colour; absent: what the scene says, or else 0.5
    std::optional<Rgb> sky; ///< irradiance of an unshaded surface, W/m²; absent: 1 if there is no other light, else 0
    std::vector<Sun> suns;  ///< added to those of the scene
    std::vector<PointLight> point_lights;     ///< likewise
    bool light_groups = false;                ///< keep the light of each group apart (scene/light_groups.h)
    bool face_centres = false;                ///< evaluate at the centres of the output's triangles too
    std::vector<ListedPoint> at;              ///< evaluate at these places too
    double output_spacing = 0.0;              ///< longest edge of the output; 0: the site spacing
    double crease_angle = 0.6981317007977318; ///< 40°: sharper edges are not shaded smoothly
    std::uint64_t seed = 1;
};

/// What a bake would take.
struct BakeEstimate {
    std::size_t rays = 0, segments = 0;
    double elements_per_ray = 0.0; ///< measured at random surface points
    double transport_bytes = 0.0;  ///< upper estimate
    double seconds = 0.0;          ///< of the transport phase, from a sample of rays; 0 if not measured
    std::size_t further_rays = 0;  ///< those of the error estimate and of a final gather; 0 if not measured
    double further_seconds = 0.0;  ///< likewise, with their shadow rays
};

/// Everything known about a finished bake.
struct BakeResult {
    Diagnosis diagnosis;
    std::string file;
    std::shared_ptr<Scene> scene;
    std::shared_ptr<SiteSet> sites;
    BakeOptions options;                                      ///< with what was left open filled in
    std::vector<std::pair<std::string, std::string>> plugins; ///< kind and choice with all parameters
    bool dry_run = false;                                     ///< nothing below `estimate` is filled in
    unsigned threads = 1;
    std::optional<Camera> camera;   ///< that of the scene's file
    std::vector<std::string> notes; ///< what the user should know
    int channels = 3;               ///< 1 for a grey scene

    BakeEstimate estimate;
    std::size_t nonzeros = 0;
    std::size_t rays = 0, segments = 0;               ///< cast for transport and direct light
    std::size_t output_rays = 0, output_segments = 0; ///< cast for the output's vertices
    std::size_t lamps = 0;                            ///< emitting triangles whose light was computed in closed form
    std::vector<Saving> savings;
    double largest_row_sum = 0.0;          ///< of the transport matrix, reflectance not counted
    double constant_error = 0.0;           ///< rms by which the basis misses the function 1 at random surface points
    double condition = 1.0;                ///< of the matrix the projection inverts
    std::size_t projection_points = 0;     ///< points at which light was gathered: the sites, or more
    double spectral_radius = 0.0;          ///< of K diag(rho)
    bool spectral_radius_is_bound = false; ///< true: an upper bound (the norm), else an estimate
    double mean_back = 0.0;                ///< share of the rays that met the back of a face
    SolveSummary solve;                    ///< h moved to `irradiance`
    Values irradiance;                     ///< #S by #channels, at the sites
    Values irradiance_direct;              ///< likewise
    std::shared_ptr<const Field> field;    ///< the solution, to be evaluated anywhere
    Solution solution;                     ///< the same, and its groups
    Values rho, emission;                  ///< at the sites; emission is the element's mean
    EnergyBalance energy;
    std::optional<ErrorEstimate> error;

    OutputMesh mesh;
    PointValues output;                  ///< at its vertices
    std::optional<PointValues> centres;  ///< at the centres of its triangles
    std::vector<SurfacePoint> listed;    ///< the surface points nearest to BakeOptions::at
    std::vector<double> listed_distance; ///< from there to them
    PointValues listed_values;
    Values residual;    ///< #V by 1: rms of the residual around the vertex, W/m²; empty without an error estimate
    Values error_bound; ///< #V by 1: estimated bound of the error of B there: residual + rho times the largest error
                        ///< anywhere; of a gathered output noise + that; likewise

    std::vector<std::pair<std::string, double>> seconds; ///< wall time of each phase, in order
};

/// Bakes `file`, a mesh or a scene (import/scene_file.h). Steps report themselves as phases of `execution.progress`.
/// Throws UsageError (unknown plugin or parameter), InputError (file, or a scene that no light reaches),
/// NotConverged, ResourceError, Interrupted.
BakeResult bake(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                const Execution& execution);

/// Bakes a scene that is there already; `name` stands for its file in messages and reports. The mesh must be derived.
BakeResult bake(const Registry& registry, Scene scene, const std::string& name, const BakeOptions& options,
                const Execution& execution);

/// The first steps only: up to the sites, and an estimate of the rest.
BakeResult dry_run(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                   const Execution& execution);

} // namespace difusa
