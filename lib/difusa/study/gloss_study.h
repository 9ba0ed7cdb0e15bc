// Glossy surfaces in spherical harmonics against path tracing over the same visibility, by lobe and order.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/gloss.h>
#include <difusa/plugin/registry.h>
#include <difusa/scene/scene.h>
#include <difusa/study/path_tracer.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// 4 by 3 by 2.5, with a floor that reflects 0.1 diffusely and `gloss` in a lobe, coloured walls, and a lamp under the
/// ceiling. Materials: floor, walls, red, green, lamp.
Scene glossy_room(const LobeShape& shape, const Rgb& gloss = Rgb::Constant(0.6));

/// Places on its surface, and the irradiance there by path tracing, in two halves.
class TracedRoom {
  public:
    /// `scene` is settled (settle_gloss); `paths` to each place.
    TracedRoom(const Registry& registry, const Scene& scene, std::size_t places, std::size_t paths, std::uint64_t seed,
               const Execution& execution);

    const std::vector<SurfacePoint>& places() const { return places_; }

    /// The mean square of the differences of H (#places by 3) to the traced light, over that of H itself, with the
    /// noise of the paths left out (SplitSquare). `deviation`: an estimate of its standard error.
    struct Judgement {
        double squared = 0.0, deviation = 0.0;
    };
    Judgement judge(const Values& H) const;

  private:
    std::vector<SurfacePoint> places_;
    std::vector<std::array<TracedLight, 2>> light_; ///< at each place, by each half
};

/// A bake of the room, judged at the places.
struct GlossTrial {
    LobeShape shape;
    int order = 0;
    double resolved = 0.0;                 ///< LobeHarmonics::resolved
    TracedRoom::Judgement basis, gather;   ///< of the irradiance: evaluated, and gathered with 2048 rays
    double told = 0.0, told_at_most = 0.0; ///< error that the bake tells of the radiosity, relative, and the end of
                                           ///< its interval
    double seconds = 0.0;                  ///< by the clock, without what judges
};

/// Phong lobes of exponents 10, 50 and 200 and GGX of roughness 0.5 and 0.3, with harmonics of orders 0 to 16. `tell`
/// is called with each trial.
std::vector<GlossTrial> gloss_study(const Registry& registry, std::size_t sites, std::uint64_t seed,
                                    const Execution& execution, const std::function<void(const GlossTrial&)>& tell);

/// A row of a Markdown table, and its header.
std::string gloss_header();
std::string gloss_row(const GlossTrial& trial);

} // namespace difusa
