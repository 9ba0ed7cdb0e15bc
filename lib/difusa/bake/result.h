// Everything about a finished bake.
#pragma once

#include <difusa/bake/light_change.h>
#include <difusa/bake/move_object.h>
#include <difusa/bake/options.h>
#include <difusa/core/error.h>
#include <difusa/core/journal.h>
#include <difusa/mesh/output_mesh.h>
#include <difusa/radiosity/error_map.h>
#include <difusa/radiosity/goal_estimate.h>
#include <difusa/radiosity/sensors.h>
#include <difusa/radiosity/system.h>
#include <difusa/repair/diagnosis.h>
#include <difusa/scene/camera.h>
#include <difusa/scene/scene.h>
#include <difusa/transport/recast.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// The cost of a bake.
struct BakeEstimate {
    std::size_t sites = 0;
    bool predicted =
        false; ///< the sites have not been placed: their number is predicted to about 1 %, or 5 % if graded
    std::size_t rays = 0, segments = 0;
    double transport_bytes = 0.0; ///< upper estimate
    double other_bytes = 0.0;     ///< of sites and basis, and of the error estimate or the output, whichever takes more
    double peak_bytes = 0.0;      ///< of the whole process, about (bake/trial.h); 0 but for dry runs
    std::size_t further_rays = 0; ///< about those of the error estimate before further rounds, and those of goals and
                                  ///< of a final gather; 0 if not counted
    /// Wall time of each phase in s, in their order (bake/trial.h); empty if it was not predicted.
    std::vector<std::pair<std::string, double>> phases;
};

/// Sites and rays of a bake, and the points at which its error and each goal are estimated.
struct Effort {
    std::size_t sites = 0, rays = 0, error_points = 0;
    std::size_t goal_samples = 0; ///< 0: there are no goals
    std::size_t shadow_rays = 64; ///< BakeOptions::shadow_rays
};

/// One of several bakes towards an accuracy (bake/error_target.h).
struct Attempt {
    Effort effort;        ///< `sites`: as placed
    double rms = 0.0;     ///< estimated error, relative to the rms reflected radiosity
    double high = 0.0;    ///< 97.5 % end of its interval
    double cut_off = 0.0; ///< the part of light that is cut off (ErrorEstimate::cut_off) and of its bounces, likewise
    double noise_share = 0.0;        ///< of the square of the error without the noise of shadow rays
    double shadow_noise_share = 0.0; ///< the part of that noise in the square of the error
    double seconds = 0.0;
    std::optional<double> goals; ///< largest half width of the goals' 95 % intervals, relative to their means
};

/// A sensor, and what asked for it.
struct PlacedSensor {
    Sensor sensor;
    Index listed = none; ///< number in BakeOptions::at, or none
    Index grid = none;   ///< number in BakeOptions::grids, or none
};

/// Temperatures and fluxes at points of a thermal scene: #points by 1.
struct ThermalValues {
    Values temperature, net_flux, radiosity, irradiation, emissivity; ///< ThermalState
};

/// What the faces of a material come to, means and extremes over the surfels.
struct ThermalSurface {
    Index material = none;
    double area = 0.0;
    double least_temperature = 0.0, mean_temperature = 0.0, largest_temperature = 0.0; ///< K, the mean over the area
    double heat = 0.0;                         ///< W, net: positive if it leaves the surface
    double radiosity = 0.0, irradiation = 0.0; ///< W/m², means
    double error = 0.0; ///< W/m², rms of the estimated errors of the irradiation at the vertices; 0 without an estimate
};

/// Heat in W. The surfaces lose what goes to the surroundings, as far as the discretisation loses nothing.
struct ThermalResult {
    ThermalValues at_vertices;
    std::optional<ThermalValues> at_centres; ///< of the output's triangles, if asked for
    std::vector<ThermalSurface> surfaces;    ///< of the materials that occur, in their order
    double heat = 0.0;                       ///< that leaves all surfaces
    double to_surroundings = 0.0;            ///< net, through openings
    double to_backs = 0.0;  ///< to the backs of faces and what is lost between mirrors: black, at the reference
    double exchanged = 0.0; ///< half the sum of the magnitudes of all net fluxes, those of surroundings and backs too:
                            ///< what imbalances are compared with
    double imbalance() const { return heat - to_surroundings - to_backs; }
};

/// Of glossy surfaces in the solution.
struct GlossyResult {
    std::size_t elements = 0;    ///< pairs of gather point and lobe, each with the coefficients of all harmonics
    std::size_t reflections = 0; ///< in a row that are followed
    double resolved = 1.0;       ///< how much of the sharpest lobe the harmonics hold (LobeHarmonics::resolved)
};

struct BakeResult {
    Diagnosis diagnosis;
    std::string file;
    std::vector<std::filesystem::path> files; ///< all that the scene was read from; empty if it was given
    std::shared_ptr<Scene> scene;
    std::shared_ptr<const SiteSet> sites;                     ///< null in a dry run that predicts their number
    BakeOptions requested;                                    ///< as the caller gave them
    BakeOptions options;                                      ///< with defaults filled in
    std::vector<std::pair<std::string, std::string>> plugins; ///< kind and choice with all parameters
    bool dry_run = false;                                     ///< nothing below `estimate` is filled in
    unsigned threads = 1;
    std::vector<Index> turned_over;    ///< triangles whose fronts were backs in the file (bake/fronts.h)
    std::string transport_file;        ///< the transport was loaded from there; empty: it was computed
    std::vector<MovedObject> moved;    ///< what is not where the file has it, in the order of the motions
    std::optional<RecastCount> recast; ///< the rays that the last motions took
    std::optional<Camera> camera;      ///< from the scene file
    Vec3 up = Vec3::UnitZ();         ///< unit, upwards: what the scene file says, or the convention of the mesh format
    int channels = 3;                ///< 1 for a grey scene
    bool sky_assumed = false;        ///< nothing else emits light
    LightFactors light_factors;      ///< on the light groups of the finished scene
    bool turned_off = false;         ///< all lights of the scene, on purpose: no sky takes their place
    bool photometric = false;        ///< what people read is in lux and cd/m²
    bool photometric_lights = false; ///< the file measures its lights so
    Journal journal;                 ///< times of the phases, notes, savings; counts "rays", "segments", "output rays",
                                     ///< "output segments"

    BakeEstimate estimate;
    std::vector<Attempt> attempts;                 ///< at BakeOptions::target; the most accurate is this result
    bool target_missed = false;                    ///< ... is out of reach: this is the best that was
    std::shared_ptr<const RadiositySystem> system; ///< depends on geometry alone; can be solved for other lights
    Solution solution;
    double constant_error = 0.0;        ///< rms by which the basis misses the function 1 at random surface points
    std::string elements;               ///< basis and projection of `system`: ElementChoice::text
    double analytic_share = 0.0;        ///< of the transport to a point, on average, that is from exact form factors
    double mean_back = 0.0;             ///< share of the light paths from the surface that end on backs
    double mean_cut_off = 0.0;          ///< share of the light from the gather points that is cut off between mirrors
    std::optional<GlossyResult> glossy; ///< if something is glossy
    std::optional<ErrorEstimate> error;
    std::vector<Goal> goals;                  ///< those of BakeOptions::goals on this mesh
    std::vector<GoalEstimate> goal_estimates; ///< of each

    OutputMesh mesh;
    PointValues output;                  ///< at its vertices
    std::optional<PointValues> centres;  ///< at the centres of its triangles
    std::vector<SurfacePoint> listed;    ///< the surface points nearest to those of BakeOptions::at that ask for them
    std::vector<double> listed_distance; ///< their distances from those points
    std::vector<Index> listed_number;    ///< their numbers in BakeOptions::at
    PointValues listed_values;
    std::optional<ErrorsAt> listed_errors; ///< of B there, with an error estimate
    std::vector<PlacedSensor> sensors;     ///< the others, in order, and then those of the grids
    SensorReadings readings;
    std::optional<ErrorsAt> errors;       ///< of B at the vertices, of H in a thermal scene, with an error estimate
    std::optional<ThermalResult> thermal; ///< of a thermal scene

    /// Not of a dry run, which has none.
    const Field& field() const {
        DIFUSA_REQUIRE(solution.field != nullptr, "a dry run has no field");
        return *solution.field;
    }
    bool has_groups() const { return options.light_groups; }
};

/// How patches are divided, if they are; else null, and before there is a system.
inline const Substructure* substructure_of(const BakeResult& result) {
    return result.system ? result.system->discretisation().basis->substructure() : nullptr;
}

/// Whether the error of the irradiance was estimated, apart from the radiosity's: in a scene that reflects nothing,
/// whose radiosity has none, it was not. Thermal scenes have one error, which is of the irradiation.
inline bool knows_error_of_irradiance(const BakeResult& result) {
    return result.error && result.error->points > 0 && !result.scene->thermal;
}

} // namespace difusa
