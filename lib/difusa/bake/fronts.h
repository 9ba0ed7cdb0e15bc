// Turns over what is inside out, and settles which of coplanar faces is in front, before anything is computed from
// them.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/result.h>

namespace difusa {

/// Turns over all faces, or the parts of the scene that are certainly inside out, as `choices.flip` says, and reports
/// them as a finding of the diagnosis; notes parts that seem to be. The engine has been built over the scene's mesh.
/// True if the mesh has changed: the engine must be made anew. Phase "check fronts", if rays decide.
bool settle_fronts(BakeResult& result, const Choices& choices, const Execution& execution);

/// Sets faces of a scene that was read from files apart where they lie on others (repair/coplanar_faces.h); of a
/// thermal scene, leaves out what they cover of each other (repair/covered_parts.h). Reports it as a finding of the
/// diagnosis. The surface of a scene that was given stays as it is: it is what further scenes to be lit are compared
/// with. True if the mesh has changed.
bool settle_coplanar_faces(BakeResult& result, const Execution& execution);

/// Notes where objects that have been moved, of a scene that was read from files, lie on others in the same plane:
/// there they stay.
void note_coplanar_faces(const BakeResult& result, const Execution& execution);

} // namespace difusa
