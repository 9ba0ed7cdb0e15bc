// Placement of the sites.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/result.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/rays/tracer.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// The regions of the surface that light reaches.
struct LitSurface {
    std::vector<char> dark; ///< #regions: 1 where no light arrives; all 0 if none arrives anywhere, or sites are wanted
                            ///< everywhere
    double dark_area = 0.0;
};

/// The sites, and what else is known where they are placed.
struct Placed {
    std::shared_ptr<SiteSet> sites;
    double dark_area = 0.0;           ///< of the surface that no light reaches
    std::vector<double> spacing = {}; ///< #S, of graded sites; else none
    /// If parts of the surface have moved: as it was when the first points were spread on it, which then went along.
    std::shared_ptr<const Mesh> unmoved = {};
    std::shared_ptr<Basis> basis = {};           ///< of the choices, bound to the sites; null if it is not bound yet
    std::optional<Contraction> contraction = {}; ///< of a system on them with the same transport, if it is known
    std::string elements = {};                   ///< of that system: ElementChoice::text
};

/// Phase "look for dark surfaces". Notes emitters whose light reaches nothing.
LitSurface lit_surface(const BakeResult& result, const DirectLight& lights, const Tracer& tracer,
                       const Execution& execution);

/// Fills in BakeOptions::spacing, to match BakeOptions::sites, and that of the output, unless they are given.
void choose_spacing(BakeResult& result, const Choices& choices, const LitSurface& lit, const Execution& execution);

/// How many sites memory has room for.
std::size_t most_sites_now(const Execution& execution);

/// How many sites `place_sites` would place, to about 1 %; nothing if placing them is as cheap. Phase "predict sites".
/// Chooses the spacing.
std::optional<std::size_t> forecast_sites(BakeResult& result, const Choices& choices, const LitSurface& lit,
                                          const Execution& execution);

/// Points of the lit surface at this spacing. Throws ResourceError, InputError.
std::vector<SurfacePoint> lit_points(const BakeResult& result, const Choices& choices, const LitSurface& lit,
                                     double spacing, const Execution& execution);

/// The sites at these points; `spacing`, `size`: as in make_site_set.
std::shared_ptr<SiteSet> site_set_of(const BakeResult& result, const LitSurface& lit, std::vector<SurfacePoint> points,
                                     double spacing, const Execution& execution, const SizeField* size = nullptr);

/// Sites on the lit surface, at BakeOptions::spacing, which has been chosen (`choose_spacing`). Throws ResourceError,
/// InputError.
std::shared_ptr<SiteSet> place_sites(const BakeResult& result, const Choices& choices, const LitSurface& lit,
                                     const Execution& execution);

} // namespace difusa
