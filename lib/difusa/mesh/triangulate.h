// One polygon in space becomes triangles between its own corners.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <span>
#include <vector>

namespace difusa {

/// What became of a polygon.
struct Triangulation {
    enum class Outcome {
        done,
        no_area,       ///< all corners on a line within rounding, or sides that only run forth and back
        crosses_itself ///< the polygon bounds no simple region: sides cross, or run twice around the same area
    };
    Outcome outcome = Outcome::done;
    std::vector<std::array<Index, 3>> triangles; ///< positions in the list of corners, oriented as the polygon
    bool concave = false;                        ///< some corner turns against the others
    bool planar = true; ///< no corner farther from the mean plane than 1e-6 of the polygon's diameter (or rounding)
    Vec3 place = Vec3::Zero(); ///< a corner next to the crossing, if it crosses itself
};

/// Triangulates the polygon with these corners (finite; consecutive ones differ; the last joins the first).
///
/// The triangles together cover exactly what the polygon encloses, so their vector areas add up to its own,
/// ½ Σ p_i × p_{i+1}. Corners in the middle of a straight side become corners of triangles, and no triangle lies
/// along such a side. A corner may be visited more than once, and a side may touch a corner or run back along another
/// side (a hole joined to the outline by a seam, two parts that meet in a corner), as long as the polygon runs once
/// and in one direction around everything it encloses.
///
/// A quadrilateral that is clearly convex is cut along its shorter diagonal (along the one through corner 0 if they
/// are equal to 1e-6). Everything else is a constrained Delaunay triangulation with exact predicates, in the plane of
/// two coordinates if the polygon is planar (which leaves coordinates unrounded), else in the plane of its Newell
/// normal. A corner that lies on a side of the polygon within rounding is taken to lie on it where exact arithmetic
/// would find a crossing there, or a triangle without area.
Triangulation triangulate(std::span<const Vec3> corners);

} // namespace difusa
