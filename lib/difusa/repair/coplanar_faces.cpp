#include <difusa/repair/coplanar_faces.h>

#include <difusa/core/error.h>
#include <difusa/mesh/repetition.h>

#include <Eigen/Eigenvalues>

#include <map>
#include <utility>

namespace difusa {

namespace {

/// The shortest way by which a corner follows all of its flat patches: n · way = shift for each of their normals.
Vec3 way_of_corner(const std::vector<std::pair<Vec3, double>>& shifts) {
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
    Vec3 sum = Vec3::Zero();
    for (const auto& [n, shift] : shifts) {
        normals += n * n.transpose();
        sum += shift * n;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(normals);
    Vec3 way = Vec3::Zero();
    for (int k = 0; k < 3; ++k) { // along the others hardly any normal points
        if (axes.eigenvalues()[k] > 0.01 * axes.eigenvalues()[2]) {
            const Vec3 axis = axes.eigenvectors().col(k);
            way += axis.dot(sum) / axes.eigenvalues()[k] * axis;
        }
    }
    return way;
}

void move_corners(Mesh& mesh, const CoplanarLayers& layers, const std::vector<Index>& group) {
    using Corner = std::pair<Index, Index>; // point and group
    std::map<Corner, std::vector<std::pair<Vec3, double>>> shifts;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (layers.shift(t) != 0.0) {
            for (const Index point : mesh.triangles[t]) {
                shifts[{point, group[t]}].emplace_back(mesh.normals[t], layers.shift(t));
            }
        }
    }
    std::vector<char> stays(mesh.points.size(), 0); // for a corner that does not move
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (const Index point : mesh.triangles[t]) {
            stays[point] = stays[point] != 0 || !shifts.contains(Corner(point, group[t])) ? 1 : 0;
        }
    }
    const std::vector<Vec3> before = mesh.points;
    std::map<Corner, Index> moved;
    for (const auto& [corner, own] : shifts) {
        const Vec3 place = before[corner.first] + way_of_corner(own);
        if (stays[corner.first] != 0) {
            moved[corner] = static_cast<Index>(mesh.points.size());
            mesh.points.push_back(place);
        } else { // further groups at this point get new ones
            moved[corner] = corner.first;
            mesh.points[corner.first] = place;
            stays[corner.first] = 1;
        }
    }
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (Index& point : mesh.triangles[t]) {
            if (const auto found = moved.find(Corner(point, group[t])); found != moved.end()) {
                point = found->second;
            }
        }
    }
}

} // namespace

SetApart set_apart(Mesh& mesh, const Execution& execution) {
    SetApart result;
    const CoplanarDistances distances(mesh);
    result.layer = distances.layer;
    result.gap = distances.gap;
    const std::optional<std::vector<Overlap>> overlaps = find_overlaps(mesh, distances.rounding(), execution);
    result.given_up = !overlaps;
    if (!overlaps || overlaps->empty()) {
        return result;
    }
    const CoplanarLayers layers(mesh, distances, *overlaps);
    std::map<Index, CoplanarFace> moved;
    for (const Overlap& overlap : *overlaps) {
        const bool a = layers.shift(overlap.a) != 0.0, b = layers.shift(overlap.b) != 0.0;
        if (a || b) {
            const Index face = mesh.original_face[b ? overlap.b : overlap.a],
                        other = mesh.original_face[b ? overlap.a : overlap.b];
            moved.emplace(face, CoplanarFace{face, other, overlap.place});
        }
    }
    if (moved.empty()) {
        return result;
    }
    Mesh apart = mesh;
    move_corners(apart, layers, layers.groups(*overlaps));
    apart.repetition.walls.clear(); // those of before
    apart.derive();
    try {
        settle_repetition(apart);
    } catch (const InputError&) { // a layer leads beyond a symmetry plane or a period
        result.given_up = true;
        return result;
    }
    mesh = std::move(apart);
    for (const auto& [number, face] : moved) {
        result.moved.push_back(face);
    }
    return result;
}

} // namespace difusa
