// Transports saved by a bake, for tests.
#pragma once

#include <difusa/bake/relight.h>

#include <scratch_directory.h>
#include <support/lit_scenes.h>

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

} // namespace difusa::test
