// Placement of the sites.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/result.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/rays/tracer.h>

#include <memory>
#include <optional>
#include <vector>

namespace difusa {

/// The regions of the surface that light reaches.
struct LitSurface {
    std::vector<char> dark; ///< #regions: 1 where no light arrives; all 0 if none arrives anywhere, or sites are wanted
                            ///< everywhere
    double dark_area = 0.0;
};

/// Phase "look for dark surfaces". Notes emitters whose light reaches nothing.
LitSurface lit_surface(const BakeResult& result, const DirectLight& lights, const Tracer& tracer,
                       const Execution& execution);

/// How many sites `place_sites` would place, to about 1 %; nothing if placing them is as cheap. Phase "predict sites".
/// Chooses the spacing as `place_sites` does.
std::optional<std::size_t> forecast_sites(BakeResult& result, const Choices& choices, const LitSurface& lit,
                                          const Execution& execution);

/// Sites on the lit surface, at BakeOptions::spacing, which is chosen to match BakeOptions::sites if it is 0. Phase
/// "place sites". Throws ResourceError, InputError.
std::shared_ptr<SiteSet> place_sites(BakeResult& result, const Choices& choices, const LitSurface& lit,
                                     const Execution& execution);

} // namespace difusa
