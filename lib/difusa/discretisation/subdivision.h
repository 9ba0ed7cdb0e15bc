// Where patches are divided: where a constant for each element misses most of the light.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>
#include <difusa/discretisation/patch_elements.h>
#include <difusa/discretisation/site_set.h>

#include <array>
#include <vector>

namespace difusa {

/// The mean square by which g·x differs from its mean over a triangle, (1/12) sum_k (g·(v_k - c))², c its centroid.
double mean_square_variation(const std::array<Vec3, 3>& corners, const Vec3& gradient);

/// The gradients of values at sites, along the surface: fits of linear functions to a site's value and its neighbours'
/// differences from it, which are weighted by the inverse squares of their distances; of each column of `values`. At
/// the edge of a shadow it is about the jump over the distance of the sites. 0 in a region with a single site.
/// `values`: #S by #columns; returns #S by 3 #columns.
Values gradients_at(const SiteSet& sites, const Values& values, const Execution& execution);

/// The square of what a constant for each element of the sites misses, integrated over the element: its area times the
/// sum of `mean_square_variation` over the columns of `values` (#S by #columns), per site.
std::vector<double> squared_misses(const PatchElements& elements, const SiteSet& sites, const Values& values,
                                   const Execution& execution);

/// What ends the subdivision of elements.
struct SubdivisionLimits {
    std::size_t elements = 0; ///< no more than these, as far as there are no more to begin with
    int levels = 0;           ///< quarterings of a patch in a row
    double least = 0.0;       ///< mean square by which a constant may miss anywhere
};

/// Quarters the elements with sites that miss most, one after the other, until a limit is met. `miss`: by site. Each
/// quarter counts for a sixteenth of what the whole missed, as it does where the light is linear.
void quarter_worst(PatchElements& elements, const std::vector<double>& miss, const SubdivisionLimits& limits);

} // namespace difusa
