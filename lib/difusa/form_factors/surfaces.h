// The surfaces between which form factors are asked for: sets of triangles with names.
#pragma once

#include <difusa/mesh/mesh.h>
#include <difusa/scene/material.h>

#include <string>
#include <vector>

namespace difusa {

/// Every triangle of a mesh belongs to one surface.
struct Surfaces {
    std::vector<std::string> name; ///< #surfaces
    std::vector<Index> of;         ///< #T, number of the surface

    std::size_t size() const { return name.size(); }

    /// #surfaces, in the square of the unit of length.
    std::vector<double> areas(const Mesh& mesh) const;
};

/// One surface for each face of the file, in its order: the triangles that a polygon was cut into are one. Names are
/// the numbers of the faces, from 0; backs that were added for double-sided materials are surfaces of their own, and
/// their names end in "b".
Surfaces surfaces_by_face(const Mesh& mesh);

/// One surface for each material that occurs, in their order; materials without a name are "material N".
Surfaces surfaces_by_material(const Mesh& mesh, const std::vector<Material>& materials);

/// The same surfaces, but the backs that were added for double-sided materials are surfaces of their own, "NAME
/// (back)".
Surfaces with_backs_apart(const Mesh& mesh, const Surfaces& surfaces);

/// One surface for each light group: materials of one `light_group`, or by default of one name, together.
Surfaces surfaces_by_group(const Mesh& mesh, const std::vector<Material>& materials);

} // namespace difusa
