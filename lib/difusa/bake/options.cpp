#include <difusa/bake/options.h>

#include <difusa/core/error.h>
#include <difusa/discretisation/patch_elements.h>
#include <difusa/mesh/lobe_harmonics.h>
#include <difusa/radiosity/sensors.h>
#include <difusa/scene/sound_scene.h>

#include <cmath>
#include <string>

namespace difusa {

namespace {

constexpr std::size_t most_error_rounds = 64;

[[noreturn]] void refuse(const std::string& option, const std::string& why) {
    throw UsageError(option + ": " + why);
}

bool is_positive_length(double length) {
    return length > 0.0 && std::isfinite(length);
}

void check_sensor_grid(const SensorGrid& grid) {
    const std::string option = "--grid " + grid.on;
    if (!is_positive_length(grid.spacing)) {
        refuse(option, "needs a spacing above 0");
    }
    if (!(grid.margin >= 0.0) || !std::isfinite(grid.margin)) {
        refuse(option, "the margin must be a length of at least 0");
    }
    if (!(grid.height >= 0.0) || !std::isfinite(grid.height)) {
        refuse(option, "the height must be a length of at least 0");
    }
}

void check_target(const BakeOptions& options, const ErrorTarget& target) {
    if (!(target.relative > 0.0)) {
        refuse("--error", "must be above 0");
    }
    if (target.most_sites < 100) {
        refuse("--max-sites", "must be at least 100");
    }
    if (!(target.most_seconds > 0.0)) {
        refuse("--max-seconds", "must be above 0");
    }
    if (options.spacing > 0.0 || options.sites > 0 || options.error_points) {
        refuse("--error", "chooses --sites, --spacing, --rays and --error-points by itself: omit them");
    }
    if (options.adaptive) {
        refuse("--error", "places sites where they help in any case: omit --adaptive");
    }
    if (options.levels) {
        refuse("--levels", "limits how finely --adaptive divides patches, and --error adds sites instead: omit one of "
                           "them");
    }
    if (options.final_gather > 0) {
        refuse("--error", "is that of the field as the basis represents it: omit --final-gather");
    }
}

} // namespace

void check_place(const std::string& name, const ListedPoint& place) {
    if (!place.position.allFinite()) {
        throw UsageError(name + " has a coordinate that is not finite");
    }
    if (place.normal && !is_unit(*place.normal)) {
        throw UsageError(name + " has a normal that is not of unit length");
    }
}

void check_options(const BakeOptions& options) {
    if (options.spacing < 0.0 || !std::isfinite(options.spacing)) {
        refuse("--spacing", "must be a positive length");
    }
    if (options.spacing > 0.0 && options.sites > 0) {
        refuse("--sites", "give either --spacing or --sites, not both");
    }
    if (options.levels && (*options.levels < 1 || *options.levels > PatchElements::most_levels)) {
        refuse("--levels", "must be from 1 to " + std::to_string(PatchElements::most_levels));
    }
    if (options.neighbours < 1 || options.neighbours > 1000) {
        refuse("--neighbours", "must be from 1 to 1000");
    }
    if (options.rays < 1 || options.rays > (std::size_t{1} << 24U)) {
        refuse("--rays", "must be from 1 to 16777216");
    }
    if (options.error_points && *options.error_points != 0 &&
        (*options.error_points < 16 || *options.error_points > (std::size_t{1} << 24U))) {
        refuse("--error-points", "must be 0, for no estimate, or from 16 to 16777216");
    }
    if (options.goal_samples < 32 || options.goal_samples > (std::size_t{1} << 24U)) {
        refuse("--goal-samples", "must be from 32 to 16777216");
    }
    if (options.error_rounds > most_error_rounds) {
        refuse("error rounds", "must be at most " + std::to_string(most_error_rounds));
    }
    for (const SensorGrid& grid : options.grids) {
        check_sensor_grid(grid);
    }
    if (options.target) {
        check_target(options, *options.target);
    }
    if (options.sensor_rays > (std::size_t{1} << 24U) ||
        (options.sensor_rays > 0 && options.sensor_rays < least_sensor_rays)) {
        refuse("--sensor-rays", "must be from " + std::to_string(least_sensor_rays) + " to 16777216");
    }
    if (options.shadow_rays < least_shadow_rays || options.shadow_rays > most_shadow_rays) {
        refuse("--shadow-rays",
               "must be from " + std::to_string(least_shadow_rays) + " to " + std::to_string(most_shadow_rays));
    }
    if (options.final_gather > (std::size_t{1} << 24U)) {
        refuse("--final-gather", "must be at most 16777216");
    }
    for (const Sun& sun : options.suns) {
        if (!is_sound(sun)) {
            refuse("--sun", "needs a direction (in BakeOptions::suns a unit vector), and an irradiance that is 0, or "
                            "from 1e-100 to 1e100");
        }
    }
    for (const PointLight& light : options.point_lights) {
        if (!is_sound(light)) {
            refuse("--point-light", "needs a position, and an intensity that is 0, or from 1e-100 to 1e100");
        }
    }
    if (!(options.solve.tolerance > 0.0) || options.solve.tolerance >= 1.0) {
        refuse("--tolerance", "must be above 0 and below 1");
    }
    if (options.directional_order < 0 || options.directional_order > LobeHarmonics::most_order) {
        refuse("--directional-order", "must be from 0 to " + std::to_string(LobeHarmonics::most_order));
    }
    if (options.mirror_depth < 1 || options.mirror_depth > 256) {
        refuse("--mirror-depth", "must be from 1 to 256");
    }
    if (options.solve.max_iterations < 0) {
        refuse("--max-iterations", "must not be negative");
    }
    if (options.reflectance && !((*options.reflectance >= 0.0) && (*options.reflectance <= 1.0)).all()) {
        refuse("--reflectance", "must be from 0 to 1");
    }
    if (options.sky && !is_light(*options.sky)) {
        refuse("--sky", "must be 0, or from 1e-100 to 1e100");
    }
    if (options.output_spacing < 0.0 || !std::isfinite(options.output_spacing)) {
        refuse("--output-spacing", "must be a positive length");
    }
    if (!is_positive_length(options.output_in_spacings)) {
        refuse("output spacing in spacings", "must be above 0");
    }
}

} // namespace difusa
