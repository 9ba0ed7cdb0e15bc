// For tests of symmetry planes and periods: scenes that have them, and the same with the images made, as meshes.
#pragma once

#include <difusa/import/shapes.h>
#include <difusa/mesh/repetition.h>
#include <difusa/scene/scene.h>

#include <cmath>
#include <utility>
#include <vector>

namespace difusa::test {

inline Repetition::Plane plane(const Vec3& normal, const Vec3& point = Vec3::Zero()) {
    return {point, normal.normalized()};
}

/// The normal of the second plane of a wedge at the z axis whose first is y = 0.
inline Vec3 at_angle(double angle) {
    return {std::sin(angle), -std::cos(angle), 0.0};
}

inline Repetition repeated(std::vector<Repetition::Plane> planes, std::vector<Vec3> periods) {
    Repetition repetition;
    repetition.planes = std::move(planes);
    repetition.periods = std::move(periods);
    return repetition;
}

/// The image of a mesh. Its faces keep their fronts.
inline Mesh image_of(Mesh mesh, const Repetition::Image& image) {
    for (Vec3& point : mesh.points) {
        point = image(point);
    }
    if (image.reflects()) {
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            mesh.turn_over(t);
        }
    }
    mesh.repetition = {};
    mesh.derive();
    return mesh;
}

/// The images of a settled mesh, made: triangle k #T + t is image k of triangle t. Single walls and wedges are all
/// unfolded, infinite series over `depth` images on either side.
inline Mesh unfolded(const Mesh& mesh, std::size_t depth = 0) {
    Mesh whole;
    for (const Repetition::Image& image : mesh.repetition.images(depth)) {
        const Mesh next = image_of(mesh, image);
        if (whole.triangles.empty()) {
            whole = next;
            continue;
        }
        const auto first = static_cast<Index>(whole.points.size());
        whole.points.insert(whole.points.end(), next.points.begin(), next.points.end());
        for (const auto& [a, b, c] : next.triangles) {
            whole.triangles.push_back({first + a, first + b, first + c});
        }
        whole.material.insert(whole.material.end(), next.material.begin(), next.material.end());
    }
    whole.original_face.resize(whole.triangles.size());
    for (Index t = 0; t < whole.triangles.size(); ++t) {
        whole.original_face[t] = t;
    }
    whole.derive();
    return whole;
}

/// The scene with the images of its surface made.
inline Scene unfolded(Scene scene, std::size_t depth = 0) {
    scene.mesh = unfolded(scene.mesh, depth);
    return scene;
}

} // namespace difusa::test
