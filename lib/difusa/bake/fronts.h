// Turns over what is inside out, before anything is computed from it.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/result.h>

namespace difusa {

/// Turns over all faces, or the parts of the scene that are certainly inside out, as `choices.flip` says, and reports
/// them as a finding of the diagnosis; notes parts that seem to be. The engine has been built over the scene's mesh.
/// True if the mesh has changed: the engine must be made anew. Phase "check fronts", if rays decide.
bool settle_fronts(BakeResult& result, const Choices& choices, const Execution& execution);

} // namespace difusa
