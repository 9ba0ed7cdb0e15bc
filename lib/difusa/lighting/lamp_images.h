// The lamps of a scene that goes on beyond symmetry planes and periods (mesh/repetition.h), as they are in the images
// of its cell.
#pragma once

#include <difusa/scene/scene.h>

#include <memory>
#include <span>
#include <vector>

namespace difusa {

/// Images in which lamps are looked for. Of infinite series they are those at most `depth` periods, or reflections in a
/// row, away: Mirrors::most, or fewer, but at least one, so that a lamp has at most `most_of_one` images and all lamps
/// together have at most `most_of_all`, if those at a depth of one are not more already.
struct LampImages {
    static constexpr std::size_t most_of_one = 1024, most_of_all = 8192;

    std::vector<Repetition::Image> images; ///< the cell itself first; none: the scene does not go on beyond its mesh
    std::size_t depth = 0;                 ///< of infinite series

    static LampImages of(const Mesh& mesh, std::size_t lamps);
};

PointLight image_of(const PointLight& light, const Repetition::Image& image);

/// The light and its images in other places. A light on a symmetry plane is its own image in it.
std::vector<PointLight> with_images(const PointLight& light, const LampImages& images, const Mesh& mesh);

/// Of these triangles of the mesh one image after another: points, triangles, materials, normals and areas. Triangle k
/// n + i is image k of triangles[i], of n.
std::shared_ptr<const Mesh> with_images(std::span<const Index> triangles, const LampImages& images, const Mesh& mesh);

} // namespace difusa
