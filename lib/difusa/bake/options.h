// What a user may choose.
#pragma once

#include <difusa/algebra/solver.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/camera.h>
#include <difusa/scene/scene.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

inline constexpr std::size_t default_sites = 5000;

/// Bounds of BakeOptions::shadow_rays.
inline constexpr std::size_t least_shadow_rays = 8, most_shadow_rays = 4096;

/// Quarterings of a patch in a row, if patches are divided.
inline constexpr int default_levels = 4;

/// A place where a user wants to know the light: with a normal what a sensor there measures, wherever it stands;
/// without one the light at the nearest point of the surface.
struct ListedPoint {
    Vec3 position = Vec3::Zero();
    std::optional<Vec3> normal; ///< unit. Snapped to the surface, only what faces within 90° of it counts
};

/// Sensors in rows and columns over a flat face.
struct SensorGrid {
    std::string on;       ///< number of a face in the file, or name of a material
    double height = 0.0;  ///< above the face, along its normal
    double spacing = 0.0; ///< largest distance between neighbours
    double margin = 0.0;  ///< least distance from the outline of the face
};

/// A part of the surface whose mean irradiance is wanted: materials and faces together, or places (bake/goals.h).
struct GoalRequest {
    std::string name;
    std::vector<std::string> materials;                     ///< by name
    std::vector<std::pair<std::size_t, std::size_t>> faces; ///< first and last number in the mesh file
    std::vector<ListedPoint> places;
};

/// An accuracy to reach by adding sites and rays (bake/error_target.h).
struct ErrorTarget {
    /// Rms error of the radiosity, relative to the rms of the reflected radiosity: the upper end of its estimate, below
    /// which it lies with a confidence of 97.5 %. With goals instead: half the width of the 95 % interval of each mean,
    /// relative to the mean.
    double relative = 0.01;
    std::size_t most_sites = 1'000'000;                            ///< give up beyond
    double most_seconds = std::numeric_limits<double>::infinity(); ///< likewise, as predicted before each attempt;
                                                                   ///< results then depend on the machine's speed
    bool best_effort = false; ///< if the target is out of reach, end with the best result instead of throwing
};

/// What a user may choose. Plugins are named as on the command line, "name" or "name:parameter=value,...".
struct BakeOptions {
    /// Empty: "moving-least-squares", or "normalized-radial" if bounces do not die out with it, or for "pairwise".
    std::string basis;
    std::string sampler;              ///< empty: the one that the basis demands, or else "poisson-disk"
    std::string transport = "gather"; ///< "gather", or "pairwise" with the parameter areas=integral|neighbours
    std::string directions = "fibonacci";
    /// Closed-form form factors of surface that a point sees whole, in place of rays: "auto", if a sample of the points
    /// shows that they pay; "always"; "never" (transport/analytic_transport.h).
    std::string analytic = "auto";
    std::string kernel;              ///< of pairwise transport; empty: "disc" there
    std::string visibility = "auto"; ///< rays/visibility_choice.h
    std::string solver = "krylov";
    /// How coefficients follow from light (discretisation/projection.h); empty: the best for the basis.
    std::string projection;
    /// The light of suns, point lights and area lights: "exact", evaluated where it is wanted and after one reflection
    /// on surfels, outside the linear system; or "interpolated", carried by the basis as in the dissertation.
    std::string direct = "exact";

    /// How light evaluated exactly is carried over its first reflection: "live", with samples on bright surfels where
    /// these are few, or "operator", by the transport alone (FirstBounce in radiosity/system.h).
    std::string first_bounce = "live";

    double spacing = 0.0;      ///< unit of the scene; 0: from `sites`
    std::size_t sites = 0;     ///< wanted number; 0: default_sites
    bool adaptive = false;     ///< as many sites, but where they help
    std::optional<int> levels; ///< quarterings of a patch in a row, if patches are divided (bake/subdivided_patches.h);
                               ///< absent: default_levels
    int neighbours = 10;       ///< m
    std::size_t rays = 512;    ///< a site
    std::optional<ErrorTarget> target; ///< determines sites and rays, and starts with few
    SolveOptions solve;                ///< tolerance, iterations; what stops them is said by `stop`
    std::string stop = "residual"; ///< what the tolerance limits: "residual", or the "change" in an iteration (StopBy)
    bool keep_iterates = false;    ///< Solution::iterates
    std::size_t mirror_depth = 32; ///< reflections in a row in mirrors (Mirrors::most)
    bool gloss = true;             ///< false: what glossy materials reflect in a lobe is absorbed
    int directional_order = 8;     ///< of the spherical harmonics of glossy surfaces (LobeHarmonics::most_order)
    std::size_t final_gather = 0;  ///< rays from each output vertex; 0: the basis is evaluated
    std::size_t shadow_rays = 64;  ///< from a point to the area lights (DirectLight::irradiance); from 8 on
    std::optional<std::size_t> error_points; ///< of the error estimate; 0: none; absent: #S / 8 in 400..4096
    std::size_t error_rounds = 2;   ///< how often the error is measured again, at most, where much doubt is left
    std::optional<Rgb> reflectance; ///< of faces without a colour; absent: what the scene says, or else 0.5
    std::optional<Rgb> sky; ///< irradiance of an unshaded surface, W/m²; absent: 1 if there is no other light, else 0
    std::vector<Sun> suns;  ///< added to those of the scene
    std::vector<PointLight> point_lights; ///< likewise
    bool light_groups = false;            ///< keep each group's contribution apart (scene/light_groups.h)
    bool every_surface = false;           ///< sites also on surfaces that these lights do not reach, for a system
                                          ///< that is to be lit otherwise
    bool face_centres = false;            ///< evaluate at the centres of the output's triangles too
    std::vector<ListedPoint> at;          ///< evaluate at these places too
    bool snap = false;                    ///< at the nearest surface, even where a normal is given
    std::string sensor = "planar";        ///< what is measured in mid-air (bake/sensing.h): "planar", "horizontal",
                                          ///< "spherical", "cylindrical"
    std::vector<SensorGrid> grids;        ///< further sensors
    std::size_t sensor_rays = 0;     ///< from each sensor; 0: 4096, or as many as `final_gather`, and up to 65536 where
                                     ///< they are noisy (read_sensors)
    std::vector<GoalRequest> goals;  ///< estimate their mean irradiance
    std::size_t goal_samples = 4096; ///< places where residuals are gathered for each goal; at least 32
    double output_spacing = 0.0;     ///< longest edge of the output; 0: `output_in_spacings`
    /// Which faces of a file are turned over: "auto", parts that are certainly inside out (lighting/inside_out.h; those
    /// that seem to be are noted), "all", or "none". The faces of a scene made by a program are turned over by "all"
    /// alone.
    std::string flip = "auto";
    /// Of what is derived from the light for people to read: "radiometric" (W), "photometric" (lux, cd/m²), or "auto",
    /// photometric if the file measures its lights so. The light itself is always in W.
    std::string units = "auto";
    bool graded_sky = false;         ///< the sky that is assumed where nothing shines is brighter above than below
    double output_in_spacings = 1.0; ///< longest edge of the output in site spacings, if `output_spacing` is 0
    std::string quality; ///< name of the preset that these options were chosen by, for the report; empty: none
    std::uint64_t seed = 1;

    /// Called as soon as the surface and its visibility are known, before anything else is computed; what it throws
    /// ends the bake. May be empty.
    std::function<void(const Scene&, const Visibility&, const std::optional<Camera>&, const Vec3& up)> when_visible;

    /// Files that the caller is going to write. A bake reads its file and everything that it names, and throws
    /// UsageError before it computes anything if that would overwrite one of those, or a plugin.
    std::vector<std::filesystem::path> outputs;
};

/// Throws UsageError for a number out of its range or a light that is not sound.
void check_options(const BakeOptions& options);

/// Throws UsageError, with the name of the place, unless its position is finite and its normal, if any, of unit length.
void check_place(const std::string& name, const ListedPoint& place);

} // namespace difusa
