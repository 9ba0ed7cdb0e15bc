// Pilot bakes, which tell where sites help: the scene in its own lights with few rays.
#pragma once

#include <difusa/bake/steps.h>
#include <difusa/plugin/registry.h>

#include <algorithm>
#include <cstddef>
#include <functional>

namespace difusa {

/// The rays from each site of a pilot, of those of the bake.
inline std::size_t pilot_rays(std::size_t rays) {
    return std::max<std::size_t>(64, rays / 4);
}

/// Bakes by `options` on `placed`, for the bake that has come to `result` and `choices`, and shows what comes of it to
/// `look`, with the execution of the pilot: none of its notes is reported, its counts are. Throws what a bake does.
void bake_pilot(const BakeResult& result, BakeOptions options, const Registry& registry, const Choices& choices,
                const Placed& placed, const Tracer& tracer, const Execution& execution,
                const std::function<void(const BakeResult& pilot, const Execution& own)>& look);

/// How much it matters at the sites of a pilot if `light`, #S or more rows by #channels, is off by that, W/m²: what
/// they would send back of it, but at least as much as sites with a quarter of the mean reflectance would, because the
/// irradiance of dark surfaces is looked at, too; the light itself if nothing reflects any. #S rows.
Values judged_at_sites(const BakeResult& pilot, const Values& light);

} // namespace difusa
