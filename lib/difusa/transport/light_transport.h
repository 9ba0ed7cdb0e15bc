// How light travels from surface and sky to the points where it is gathered: geometry only. There are two
// discretisations: gathered.h and pairwise.h.
#pragma once

#include <difusa/algebra/linear_operator.h>

#include <memory>
#include <vector>

namespace difusa {

class GlossyRays;
class SkyOpenings;

/// With the radiosity b of the surfels and pi times the radiance of the sky's parts (scene/sky_parts.h), the irradiance
/// at the points is
///     h = W [b; sky] = D b + Y sky.
/// D_js is the form factor from point j to surfel s, Y_jp that from point j to part p of the sky: directly, and in
/// mirrors, where it is multiplied by their reflectances and may differ by channel. W is identical to the bit whatever
/// the diffuse reflectances and lights.
struct LightTransport {
    std::shared_ptr<const LinearOperator> W; ///< #points by #surfels + #parts of the sky
    std::size_t surfels = 0;
    std::vector<double> sky;  ///< #points: cosine-weighted share of the hemisphere that escapes
    std::vector<double> back; ///< #points: the share that hits the back of a face, which sends no light
    /// #points by #channels of the mirrors, or 1: the share that, after a mirror or a glossy reflection, hits the back
    /// of a face, and the share that is cut off, between mirrors (Mirrors::most) or in an infinite series of cells
    /// (Hit::cut_off). No rows: there are neither.
    Values back_in_mirrors, cut_off;
    std::shared_ptr<const GlossyRays> glossy = {};    ///< what glossy reflection needs to know; null: nothing is glossy
    std::shared_ptr<const SkyOpenings> openings = {}; ///< that rays are aimed at (skylight.h); null: at none
    std::size_t rays = 0;     ///< first-hit rays cast, not counting those that go on from mirrors
    std::size_t segments = 0; ///< visibility segments cast, and rays to mirror patches and on from them
    std::size_t bytes = 0;    ///< size of W

    std::size_t points() const { return W->rows(); }

    /// [b; sky], what the columns of W are multiplied with, for each column; without rows in sky, the sky is dark.
    Values on_bins(const Values& b, const Values& sky_radiosity, const Execution& execution) const;

    /// h = W [b; sky] for each column; without rows in sky, the sky is dark.
    void gather(const Values& b, const Values& sky_radiosity, Values& h, const Execution& execution) const;

    /// The largest row sum of D over the surfels: at most 1 if gathered and without mirrors. A ray that goes on from a
    /// mirror counts there and where it ends.
    double largest_row_sum(const Execution& execution) const;
};

} // namespace difusa
