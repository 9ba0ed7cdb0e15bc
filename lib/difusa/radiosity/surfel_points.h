// Random surface points with a given density over the surfels.
#pragma once

#include <difusa/core/random.h>
#include <difusa/discretisation/surfels.h>

#include <span>
#include <vector>

namespace difusa {

/// Points with shading normals and weights w_p: sum_p w_p f(x_p) estimates ∫ f dA over the surfels whose density is not
/// 0.
struct SurfelPoints {
    std::vector<SurfacePoint> place;
    std::vector<double> weight; ///< area
    std::vector<Index> surfel;  ///< each is on
    std::vector<Index> group;   ///< each belongs to; the groups are of equal size and independent of each other

    std::size_t size() const { return place.size(); }
};

/// One point of each of `groups` groups from each of `shares` equal shares of the density's integral; uniform by area
/// within a surfel. `density`: integral over each surfel, at least 0, in any unit. None if all are 0.
SurfelPoints draw_surfel_points(const Surfels& surfels, std::span<const double> density, std::size_t shares,
                                Index groups, RandomStream& stream);

/// Points chosen among others: of those of each group, one from each of `shares` equal shares of the sum of their
/// chances. The same one may be chosen more than once. `chance`: #from, in any unit, above 0. The weight of a point is
/// multiplied by that sum over its chance and the number of shares, so that the sums estimated are the same.
SurfelPoints choose_points(const SurfelPoints& from, std::span<const double> chance, std::size_t shares, Index groups,
                           RandomStream& stream);

} // namespace difusa
