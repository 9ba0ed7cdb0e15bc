// The light and reflectance of a scene on each surfel: everything the linear system needs to know of the lighting.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/surfels.h>
#include <difusa/lighting/direct_light.h>

#include <array>
#include <cstdint>
#include <vector>

namespace difusa {

/// Means over surfels; columns are the channels, or the channels of each set of lights in turn.
struct SurfelLight {
    Values reflectance;             ///< rho: #surfels by #channels
    Values emission;                ///< E, W/m²: #surfels by #sets #channels, from faces that are not area lights
    Values direct;                  ///< H, W/m²: likewise, shadowed irradiance from suns, point lights and area lights
    Values uneven_emission;         ///< the part of `emission` with a texture or pattern; no rows: there is none
    Values all_emission;            ///< W/m²: #surfels by #channels, from all faces and sets
    Values from_outside;            ///< W/m²: #surfels by #channels, the part of `direct` from suns and point lights
    std::vector<std::uint8_t> even; ///< #surfels: 1 where `direct` and the reflectance represent all of the surfel
    std::size_t segments = 0;       ///< shadow rays cast

    /// rho ∘ H: likewise, direct light after one reflection.
    Values first_bounce() const;
};

/// Points spread evenly over a surfel with these pieces, from two numbers in [0, 1).
void spread_points(const Surfels& surfels, const std::vector<Surfels::Piece>& pieces, std::size_t count,
                   const std::array<double, 2>& shift, std::vector<SurfacePoint>& points);

/// How many points of a surfel direct light is sampled at. A pilot decides how many follow, and is the result itself if
/// it is even and no shadow ray was needed. Otherwise it does not count, because the mean would be biased: `even`
/// points follow where the pilot's differ by at most a tenth of the brightest, and `edge` in penumbrae and at the edges
/// of shadows; fewer where each of them takes many shadow rays. Values of area lights that are chosen roughly
/// (DirectLight::chooses_roughly) differ by chance: there the pilot never counts, and all of its shadow rays, or none,
/// being blocked is what is called even. Nor does it count where a beam is as narrow as the surfel (NarrowBeams), which
/// its points may all miss: as many follow, up to 4096, as bring about `edge` of them into the beam.
struct SurfelSamples {
    std::size_t pilot = 4, even = 12, edge = 96;

    /// `rays`: DirectLight::rays_per_sample. With up to eight of them, the above; half of that with twice as many, ...,
    /// but at least 4 and 16.
    static SurfelSamples of(std::size_t rays);
};

/// The number of points that materials are averaged over on a surfel with these pieces: 0 where they are constant. Else
/// 16, and where emission has a texture, four for each of its pixels, if these are more, but at most 4096: displays and
/// rows of LEDs are dark but for a few pixels.
std::size_t material_samples(const Scene& scene, const std::vector<Surfels::Piece>& pieces);

/// What materials are averaged over on a surfel with these pieces: calls `act(x, share)` for each piece, of which only
/// x.face is set, or for so many `samples` spread over it, which are left in `points`.
template <class Act>
void for_material_places(const Surfels& surfels, const std::vector<Surfels::Piece>& pieces, std::size_t samples,
                         std::vector<SurfacePoint>& points, const Act& act) {
    if (samples > 0) {
        spread_points(surfels, pieces, samples, {0.5, 0.5}, points);
        for (const SurfacePoint& x : points) {
            act(x, 1.0 / static_cast<double>(samples));
        }
        return;
    }
    double area = 0.0;
    for (const Surfels::Piece& piece : pieces) {
        area += piece.area;
    }
    for (const Surfels::Piece& piece : pieces) {
        SurfacePoint x;
        x.face = piece.triangle;
        act(x, area > 0.0 ? piece.area / area : 1.0 / static_cast<double>(pieces.size()));
    }
}

/// `even` is set where the materials are constant and direct light differed by little at all points that it was sampled
/// at. Constants are averaged exactly; textures, patterns and corner colours over points (material_samples), direct
/// light over those of SurfelSamples.
SurfelLight light_on_surfels(const Scene& scene, const Surfels& surfels, const DirectLight& light, int channels,
                             std::uint64_t seed, const Execution& execution);

} // namespace difusa
