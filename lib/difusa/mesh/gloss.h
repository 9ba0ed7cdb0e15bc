// The faces of a mesh that reflect light glossily.
#pragma once

#include <difusa/core/colour.h>
#include <difusa/mesh/glossy_lobe.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace difusa {

/// What a material says of its gloss: the share `reflectance` of the light is reflected in a lobe.
struct Gloss {
    LobeShape shape;
    Rgb reflectance = Rgb::Zero(); ///< in [0,1]
};

/// Whether the reflectance and the lobe are within their limits.
inline bool is_sound(const Gloss& gloss) {
    const double least =
        gloss.shape.model == LobeShape::Model::phong ? LobeShape::least_exponent : LobeShape::least_roughness;
    const double most = gloss.shape.model == LobeShape::Model::phong ? LobeShape::most_exponent : 1.0;
    return (gloss.reflectance >= 0.0 && gloss.reflectance <= 1.0).all() && gloss.shape.sharpness >= least &&
           gloss.shape.sharpness <= most;
}

/// What rays need to know of glossy surfaces. Fronts reflect; backs are opaque like any other. Like the shape of the
/// surface, they belong to the geometry: light transport depends on them.
struct GlossySurfaces {
    struct Kind {
        Index lobe = 0; ///< in `lobes`
        Rgb reflectance = Rgb::Zero();
    };
    std::vector<Index> of_face; ///< #T: number in `kinds`, or none; empty: nothing is glossy
    std::vector<Kind> kinds;
    std::vector<std::shared_ptr<const GlossyLobe>> lobes;

    bool any() const { return !kinds.empty(); }

    const GlossyLobe& lobe_of(Index kind) const { return *lobes[kinds[kind].lobe]; }

    /// The kind of glossy surface that a triangle is, or none.
    Index kind(Index triangle) const { return any() ? of_face[triangle] : none; }

    bool is_grey() const {
        return std::all_of(kinds.begin(), kinds.end(),
                           [](const Kind& each) { return equal_channels(each.reflectance); });
    }
};

} // namespace difusa
