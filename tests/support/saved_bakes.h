// Transports saved by a bake, for tests.
#pragma once

#include <difusa/bake/relight.h>

#include <gtest/gtest.h>
#include <scratch_directory.h>
#include <support/lit_scenes.h>
#include <support/plugins.h>

#include <string>

namespace difusa::test {

/// A coarse bake whose system may be lit by anything.
inline BakeOptions relightable(const std::string& transport, const std::string& basis) {
    BakeOptions options = lit::quick(0.3, 32);
    options.transport = transport;
    options.basis = basis;
    options.every_surface = true;
    return options;
}

/// Through a file and back.
inline SavedTransport through_file(const BakeResult& result) {
    const ScratchDirectory scratch;
    save_transport(result, scratch / "transport");
    return load_transport(scratch / "transport", Execution{});
}

/// To relight as baked, without an error estimate.
inline RelightOptions as_baked(const SavedTransport& saved) {
    RelightOptions again;
    again.bake = relight_defaults(saved);
    again.bake.error_points = 0;
    return again;
}

/// Expects that the transport has the bits of a bake by the options, which saved it, in the light of this scene.
inline void expect_bits_of_a_bake(const SavedTransport& saved, const Scene& scene, const BakeOptions& options) {
    const BakeResult fresh = bake(registry(), scene, "scene", options, Execution{});
    const BakeResult relit = relight(registry(), saved, scene, "scene", as_baked(saved), Execution{});
    EXPECT_TRUE((fresh.solution.h.array() == relit.solution.h.array()).all());
    EXPECT_TRUE((fresh.solution.energy.imbalance == relit.solution.energy.imbalance).all());
}

} // namespace difusa::test
