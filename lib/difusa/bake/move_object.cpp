#include <difusa/bake/move_object.h>

#include <difusa/bake/names.h>
#include <difusa/core/error.h>
#include <difusa/import/placement.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>
#include <utility>

namespace difusa {

namespace {

/// "12" or "12-40".
std::optional<std::pair<std::size_t, std::size_t>> face_range(const std::string& text) {
    std::size_t first = 0, last = 0;
    const char* const end = text.data() + text.size();
    const auto begins = std::from_chars(text.data(), end, first);
    if (begins.ec != std::errc() || (begins.ptr != end && *begins.ptr != '-')) {
        return std::nullopt;
    }
    if (begins.ptr == end) {
        return std::pair(first, first);
    }
    const auto ends = std::from_chars(begins.ptr + 1, end, last);
    return ends.ec == std::errc() && ends.ptr == end && first <= last ? std::optional(std::pair(first, last))
                                                                      : std::nullopt;
}

/// The triangles for which `belongs` is true.
template <class Belongs> std::vector<Index> triangles_where(const Mesh& mesh, const Belongs& belongs) {
    std::vector<Index> triangles;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (belongs(t)) {
            triangles.push_back(t);
        }
    }
    return triangles;
}

std::vector<char> marks_of(const std::vector<Index>& triangles, const Mesh& mesh) {
    std::vector<char> marked(mesh.triangles.size(), 0);
    for (const Index t : triangles) {
        marked[t] = 1;
    }
    return marked;
}

} // namespace

std::vector<Index> triangles_of_object(const std::string& name, const Scene& scene, std::span<const SoupPart> parts,
                                       std::size_t faces) {
    const Mesh& mesh = scene.mesh;
    std::vector<std::string> known;
    std::vector<Index> triangles;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        if (parts[p].name.empty()) {
            continue;
        }
        known.push_back(parts[p].name);
        if (parts[p].name == name) {
            const std::vector<Index> own = triangles_where(mesh, [&](Index t) {
                const std::size_t face = mesh.original_face[t];
                return face >= parts[p].first_face && (p + 1 == parts.size() || face < parts[p + 1].first_face);
            });
            triangles.insert(triangles.end(), own.begin(), own.end());
        }
    }
    if (triangles.empty()) {
        triangles = triangles_where(mesh, [&](Index t) { return scene.materials[mesh.material[t]].name == name; });
    }
    if (const auto range = face_range(name); triangles.empty() && range) {
        if (range->second >= faces) {
            throw UsageError("--move " + name + ": the faces of the file have the numbers 0 to " +
                             std::to_string(faces - 1));
        }
        triangles = triangles_where(mesh, [&](Index t) {
            return range->first <= mesh.original_face[t] && mesh.original_face[t] <= range->second;
        });
    }
    if (triangles.empty()) {
        for (const Material& material : scene.materials) {
            known.push_back(material.name);
        }
        throw UsageError("--move: " + unknown_name("object", name, known) +
                         ". An object is a mesh of a scene file or a material, by its name, or faces by their numbers "
                         "(12-40)");
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

MovedObject move_object(const ObjectMove& move, const Vec3& up, std::span<const SoupPart> parts, std::size_t faces,
                        Scene& scene) {
    MovedObject moved{move.object, move.motion, triangles_of_object(move.object, scene, parts, faces)};
    Mesh& mesh = scene.mesh;
    if (move.turn != 0.0) {
        Eigen::AlignedBox3d box;
        for (const Index t : moved.triangles) {
            box.extend(mesh.box(t));
        }
        const Eigen::Matrix3d turn = rotation(up, move.turn);
        Vec3 axis = box.center();
        axis -= up.dot(axis) * up;
        moved.motion.offset += move.motion.rotation * (axis - turn * axis);
        moved.motion.rotation = move.motion.rotation * turn;
    }
    if (!is_rigid(moved.motion)) {
        throw UsageError("--move " + move.object +
                         ": the motion must be rigid, of finite numbers: a rotation, which "
                         "neither scales nor mirrors, and a displacement");
    }
    try {
        mesh = moved_mesh(mesh, marks_of(moved.triangles, mesh), moved.motion);
    } catch (const InputError& error) {
        throw UsageError("--move " + move.object + ": " + error.what());
    }
    return moved;
}

void move_again(const MovedObject& moved, Mesh& mesh) {
    if (!is_rigid(moved.motion) || std::any_of(moved.triangles.begin(), moved.triangles.end(),
                                               [&](Index t) { return t >= mesh.triangles.size(); })) {
        throw InputError("what was moved is not on this surface");
    }
    mesh = moved_mesh(mesh, marks_of(moved.triangles, mesh), moved.motion);
}

} // namespace difusa
