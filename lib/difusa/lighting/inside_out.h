// Which connected parts of a surface have their fronts on the wrong side, judged by where light comes from.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/camera.h>
#include <difusa/scene/scene.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace difusa {

/// A set of triangles that are connected through common corners.
struct ConnectedPart {
    std::vector<Index> triangles; ///< ascending
    double volume = 0.0;          ///< signed: positive if fronts face outwards, for a part that is closed or nearly so
    bool emits = false;
};

/// What is wrong with the fronts of a part.
enum class FrontFault {
    inside_out, ///< certain: as it is, no light can ever reach its fronts, and turned over it does
    leaky,      ///< perhaps inside out: its fronts enclose it but for holes, and light mostly or only meets its backs
    dark_room,  ///< fronts face a closed inside that holds other parts but no light; light meets its backs
    shut_light, ///< fronts face outwards, and a light is shut up inside
};

struct JudgedPart {
    std::size_t part; ///< number in `parts`
    FrontFault fault;
};

struct FrontVerdict {
    std::vector<ConnectedPart> parts; ///< in the order of their first triangles
    std::vector<JudgedPart> faults;   ///< at most one a part, by part
};

/// Judges the fronts of a scene. A part whose fronts face its inside (a negative volume) is a room if a lamp, an
/// emitting face or the camera is seen from in there, and stays as it is. If it has no border (mesh/borders.h) and rays
/// from its fronts meet nothing but these same fronts, it is empty and sealed; if light meets its backs too, it is
/// inside out. With a border it is never more than leaky: rays do not find every hole, and a hall may have but one
/// rooflight. A part whose fronts face outwards, while a lamp, an emitting face or the camera is shut up inside, is an
/// inside-out room if there is nothing outside, neither light nor surface, or if the camera is inside. All else is left
/// alone. Parts with double-sided materials, whose volume vanishes, are not judged. What one decision brings to light
/// is considered in the next.
///
/// `engine` has been built over the scene's mesh. Casts rays only from parts that may be at fault: nothing for an
/// object whose fronts face outwards, under the sky. The result depends on the seed, not on the number of threads.
FrontVerdict judge_fronts(const Scene& scene, const std::optional<Camera>& camera, const Visibility& engine,
                          std::uint64_t seed, const Execution& execution);

} // namespace difusa
