// What the writer and the reader of saved transports share.
#pragma once

#include <difusa/bake/options.h>
#include <difusa/io/sealed_file.h>

namespace difusa {

inline const SealKind& transport_seal() {
    static const SealKind kind{"difusa transport", 6, "make it anew: bake_radiosity SCENE OUT --save-transport FILE"};
    return kind;
}

/// Calls `visit(name, member)` for the choices of a bake that a saved transport holds, lights excepted: texts, lengths
/// and tolerances, and whole numbers.
template <class Options, class Visit> void for_saved_choices(Options& options, const Visit& visit) {
    visit("basis", options.basis);
    visit("sampler", options.sampler);
    visit("transport", options.transport);
    visit("directions", options.directions);
    visit("analytic", options.analytic);
    visit("kernel", options.kernel);
    visit("projection", options.projection);
    visit("flip", options.flip);
    visit("quality", options.quality);
    visit("spacing", options.spacing);
    visit("sites", options.sites);
    visit("adaptive", options.adaptive);
    visit("neighbours", options.neighbours);
    visit("rays", options.rays);
    visit("shadow_rays", options.shadow_rays);
    visit("seed", options.seed);
    visit("visibility", options.visibility);
    visit("solver", options.solver);
    visit("stop", options.stop);
    visit("direct", options.direct);
    visit("mirror_depth", options.mirror_depth);
    visit("tolerance", options.solve.tolerance);
    visit("max_iterations", options.solve.max_iterations);
}

} // namespace difusa
