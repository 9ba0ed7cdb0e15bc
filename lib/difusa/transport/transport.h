// How light travels between the sites of a scene: geometry only, no reflectance and no amount of light in it, so that
// a scene can be relit without casting a ray. Two discretisations make it: gather.h and pairwise.h.
#pragma once

#include <difusa/algebra/sparse_rows.h>
#include <difusa/scene/light_groups.h>
#include <difusa/scene/scene.h>

#include <array>
#include <vector>

namespace difusa {

/// For radiosity sum_k b_k phi_k(y) + E(y) and a sky that gives an unshaded surface the irradiance H_sky, the
/// irradiance at point j is
///     h_j = sum_k S_jk b_k + sum_m (L_jm E_m + uneven_jm) + sky_j H_sky + dome_j.
/// The points are the sites, or more points than that (discretisation/projection.h).
struct Transport {
    SparseRows S; ///< #points by #S
    SparseRows L; ///< #points by #materials: columns of materials that emit evenly; empty rows if none does
    std::array<SparseRows, 3> uneven; ///< for each channel, #points by #materials, W/m²: light of materials that emit
                                      ///< unevenly (Material::emits_unevenly); without rows if none does
    Values dome;                      ///< #points by 3, W/m²: irradiance from Scene::dome; empty without one
    std::vector<double> sky; ///< #points: cosine-weighted share of the hemisphere that escapes; empty: not measured
    std::vector<double>
        back; ///< #points: the share that meets the back of a face, from where no light comes; empty likewise
    std::vector<Values> bounce; ///< each #points by #channels, W/m²: light of sharp sources after one reflection
                                ///< (gather.h, Sources::bounce)
    std::size_t rays = 0;       ///< first-hit rays cast
    std::size_t segments = 0;   ///< visibility segments cast
};

/// Irradiance at the points from emitting faces and the sky, as far as the light is of `group`: #points by `channels`
/// (1: the first channel stands for all; 3).
Values direct_irradiance(const Scene& scene, const LightGroup& group, const Transport& transport, int channels,
                         const Execution& execution);

} // namespace difusa
