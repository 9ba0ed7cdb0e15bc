// Objects of a scene that are moved, by their names.
#pragma once

#include <difusa/mesh/rigid_motion.h>
#include <difusa/repair/polygon_soup.h>
#include <difusa/scene/scene.h>

#include <span>
#include <string>
#include <vector>

namespace difusa {

/// What is to be moved, and how.
struct ObjectMove {
    std::string object; ///< see `triangles_of_object`
    double turn = 0.0;  ///< degrees about the vertical through the middle of its bounding box, counterclockwise seen
                        ///< from above
    RigidMotion motion; ///< after that
};

/// What was moved.
struct MovedObject {
    std::string object;
    RigidMotion motion;           ///< the whole of it
    std::vector<Index> triangles; ///< ascending
};

/// The triangles of a mesh of a scene file, by its "name"; if there is none, those of a material; or, by numbers in the
/// file, those of faces, "12" or "12-40", of which it has `faces`. Throws UsageError, with the names there are, if
/// there are no such triangles.
std::vector<Index> triangles_of_object(const std::string& name, const Scene& scene, std::span<const SoupPart> parts,
                                       std::size_t faces);

/// Moves an object. `up`: unit. Throws UsageError for a motion that is not rigid, and for what it cannot be applied to
/// (`triangles_of_object`, `moved_mesh`).
MovedObject move_object(const ObjectMove& move, const Vec3& up, std::span<const SoupPart> parts, std::size_t faces,
                        Scene& scene);

/// Moves again what was moved. Throws InputError if the mesh has no such triangles, or the motion is not rigid.
void move_again(const MovedObject& moved, Mesh& mesh);

} // namespace difusa
