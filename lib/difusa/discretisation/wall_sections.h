// Where walls stand on the regions they part.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>

#include <vector>

namespace difusa {

/// The segment along which a separator (separators.h) touches or crosses a triangle of the region that it parts; or a
/// triangle of the region itself does, where a side of one of the two is open.
struct WallSection {
    Index wall = none, triangle = none;
    Vec3 from = Vec3::Zero(), to = Vec3::Zero();
};

/// All of them: those of separators by region, wall and triangle; then the others.
std::vector<WallSection> wall_sections(const Mesh& mesh, const Execution& execution);

} // namespace difusa
