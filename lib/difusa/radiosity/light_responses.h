// The solution for chosen lights, and with it for all their mixtures: what light groups, sun positions and parts of the
// sky are used for.
#pragma once

#include <difusa/radiosity/system.h>

namespace difusa {

/// h_l = (I - T)^-1 g_l of some lights l. Their mixtures are exact, as accurate as the solutions, and cost a product.
class LightResponses {
  public:
    /// `g`: #points by #lights times #channels, the channels of each light in turn, W/m²; `reflectance`: #surfels by
    /// #channels. All lights are solved for together (radiosity/response.h). Throws NotConverged.
    LightResponses(const RadiositySystem& system, const Values& reflectance, const Values& g,
                   const SolveOptions& options, const Execution& execution);

    std::size_t lights() const { return static_cast<std::size_t>(h_.cols() / channels_); }

    /// h of all lights, as g.
    const Values& all() const { return h_; }

    /// sum_l factor_l h_l, by channel: #points by #channels, W/m². `factors`: #lights by #channels, or by 1 for grey
    /// factors. Bit-identical for any number of threads.
    Values mixed(const Values& factors, const Execution& execution) const;

  private:
    Eigen::Index channels_;
    Values h_;
};

} // namespace difusa
