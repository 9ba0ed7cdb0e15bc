// What a bake found out, ready to be evaluated: the light of all lamps together, and if wanted of each group apart.
#pragma once

#include <difusa/radiosity/field.h>

#include <string>
#include <vector>

namespace difusa {

/// The light of one group at points, W/m².
struct GroupValues {
    std::string name;
    Values B, H; ///< #points by 3
};

/// Everything about the light at points: #points by 3, W/m² but for rho. A grey scene has three equal columns.
struct PointValues {
    Values B;          ///< radiosity, E + rho H
    Values H;          ///< irradiance, direct and indirect
    Values H_direct;   ///< straight from lights, the sky and emitting faces
    Values H_indirect; ///< after one reflection or more
    Values rho;        ///< reflectance, at the very point
    Values E;          ///< emitted radiosity, at the very point
    Values noise;      ///< #points by #channels: an estimate of B's noise of gathering; without rows if not gathered
    std::vector<GroupValues> groups;    ///< those of the solution; their B and H add up to B and H
    std::size_t rays = 0, segments = 0; ///< cast
    std::size_t clear = 0;              ///< points that needed no shadow rays to lamps
};

/// Places may lie on edges: rays start from a little inside of their faces.
struct Solution {
    std::shared_ptr<const Field> field;               ///< all light
    std::vector<std::shared_ptr<const Field>> groups; ///< empty, or fields that add up to it

    /// `final_gather` rays from each point (an even number), in two independent halves whose difference tells the
    /// noise; 0: the basis is evaluated. Seeds as in `Field`.
    PointValues at(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                   const std::string& purpose, const Execution& execution) const;
};

} // namespace difusa
