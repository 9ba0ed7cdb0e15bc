// Triangulates one polygon in space using only its own corners.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <span>
#include <vector>

namespace difusa {

/// The outcome for a polygon.
struct Triangulation {
    enum class Outcome {
        done,
        no_area,       ///< all corners collinear to within rounding, or sides that only run back and forth
        crosses_itself ///< the polygon bounds no simple region: sides cross, or enclose the same area twice
    };
    Outcome outcome = Outcome::done;
    std::vector<std::array<Index, 3>> triangles; ///< indices into the list of corners, oriented like the polygon
    bool concave = false;                        ///< some corner turns against the others
    bool planar = true; ///< no corner farther from the mean plane than 1e-6 of the polygon's diameter (or rounding)
    Vec3 place = Vec3::Zero(); ///< a corner next to the crossing, if it crosses itself
};

/// Triangulates the polygon with these corners (finite; consecutive ones differ; the last connects to the first).
///
/// The triangles together cover exactly what the polygon encloses, so their vector areas add up to its own, ½ Σ p_i ×
/// p_{i+1}. Corners in the middle of a straight side become corners of triangles, and no triangle lies along such a
/// side. A corner may be visited more than once, and a side may touch a corner or run back along another side (a hole
/// joined to the outline by a seam, two parts that meet in a corner), as long as the polygon runs once and in one
/// direction around everything it encloses.
///
/// A quadrilateral that is clearly convex is split along its shorter diagonal (along the one through corner 0 if they
/// are equal to 1e-6). Everything else is a constrained Delaunay triangulation with exact predicates, in the plane of
/// two coordinates if the polygon is planar (which leaves coordinates unrounded), otherwise in the plane of its Newell
/// normal. A corner within rounding of a side of the polygon is taken to lie on it if exact arithmetic would find a
/// crossing there, or a zero-area triangle.
Triangulation triangulate(std::span<const Vec3> corners);

} // namespace difusa
