// Triangles of a mesh, found by their boxes.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/mesh/mesh.h>

#include <vector>

namespace difusa {

/// The boxes of these triangles, numbered as in the mesh.
BoxTree tree_of_triangles(const Mesh& mesh, const std::vector<Index>& triangles);

/// Those of all triangles.
BoxTree tree_of_triangles(const Mesh& mesh);

} // namespace difusa
