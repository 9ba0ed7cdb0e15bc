// A scene in other light and other colours, with a transport that was saved: no gather ray is cast.
#pragma once

#include <difusa/bake/light_change.h>
#include <difusa/bake/move_object.h>
#include <difusa/bake/options.h>
#include <difusa/bake/result.h>
#include <difusa/bake/saved_transport.h>
#include <difusa/bake/sun_path.h>
#include <difusa/plugin/registry.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

struct RelightOptions {
    /// A scene of the same surface in which other materials, textures and lights may be; absent: that of the bake.
    std::optional<std::filesystem::path> scene;

    /// Made to the lights and materials of the scene, and to the lights that the options of the bake added to it.
    LightChange change;

    /// Lights added to the above (a sky replaces theirs), the solver, and what comes out: places, goals, output mesh,
    /// units, light groups. What the transport depends on is that of the transport, whatever stands here: basis,
    /// sampler, spacing, sites, neighbours, projection, transport, kernel, directions, rays, target, seed, flip.
    BakeOptions bake;

    /// False: the system, its solution, places and goals are found, but no field is evaluated; the light may be dark.
    bool evaluate = true;

    /// Objects that are moved, one after the other, before the scene is lit. Rays are cast again that may meet what has
    /// moved, where it was or where it is (transport/recast.h). Lamps that are no surfaces stay where they are.
    std::vector<ObjectMove> moves = {};

    /// On the groups of all lights in the end, those of `bake` included.
    LightFactors factors = {};
};

/// The choices of the bake that a relit one may make differently: solver, tolerance, what it limits, iterations,
/// direct light and its shadow rays, visibility. To start from; everything else is as by default.
BakeOptions relight_defaults(const SavedTransport& saved);

/// The result has the same bits as a bake of the scene in this light by the options of the saved transport and
/// BakeOptions::every_surface, and its system can be solved for further lights. Rays are cast only towards suns, point
/// lights and area lights, for the error estimate, for goals and sensors, and by a final gather.
///
/// After motions it has the bits of a bake of the moved scene with these sites, those on moved objects having gone
/// along. It can be saved again, and then moved again.
///
/// Throws InputError if the scene does not have the surface of the transport, or if this program divides it otherwise
/// than the one that saved the transport; UsageError for a change that cannot be made, and
/// for motions if the transport is pairwise; and what `bake` throws.
BakeResult relight(const Registry& registry, const SavedTransport& saved, const RelightOptions& options,
                   const Execution& execution);

/// The same for a scene made by a program; `name` stands for it in messages and reports. RelightOptions::scene is not
/// used.
BakeResult relight(const Registry& registry, const SavedTransport& saved, Scene scene, const std::string& name,
                   const RelightOptions& options, const Execution& execution);

/// Receives the result of each time of a path, which holds until the next one.
using SunStepVisit = std::function<void(const SunStep& step, const BakeResult& result)>;

/// The scene over a day: for each time at which the sun of the path is above the horizon, the result with this sun
/// beside all other lights, which stay as they are. Direct light, and its first reflection, is computed for each time;
/// the linear systems of several times are solved together. With the solver krylov each result has the bits that
/// `relight` gives for this sun. Returns the last result, with the journal of all.
BakeResult relight_sun_path(const Registry& registry, const SavedTransport& saved, const RelightOptions& options,
                            const SunPath& path, const SunStepVisit& visit, const Execution& execution);

/// The same for a scene made by a program.
BakeResult relight_sun_path(const Registry& registry, const SavedTransport& saved, Scene scene, const std::string& name,
                            const RelightOptions& options, const SunPath& path, const SunStepVisit& visit,
                            const Execution& execution);

} // namespace difusa
