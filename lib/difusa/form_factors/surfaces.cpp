#include <difusa/form_factors/surfaces.h>

#include <functional>
#include <map>
#include <utility>

namespace difusa {

namespace {

std::string material_name(const std::vector<Material>& materials, Index m) {
    return m < materials.size() && !materials[m].name.empty() ? materials[m].name : "material " + std::to_string(m);
}

/// Surfaces in the order of their first materials, those with equal names together if `join`.
Surfaces surfaces_by_name(const Mesh& mesh, bool join, const std::function<std::string(Index)>& name) {
    std::vector<char> occurs;
    for (const Index m : mesh.material) {
        if (m >= occurs.size()) {
            occurs.resize(m + 1, 0);
        }
        occurs[m] = 1;
    }
    Surfaces surfaces;
    std::vector<Index> surface(occurs.size(), none);
    std::map<std::string, Index> known;
    for (Index m = 0; m < occurs.size(); ++m) {
        if (occurs[m] == 0) {
            continue;
        }
        const auto next = static_cast<Index>(surfaces.size());
        surface[m] = join ? known.try_emplace(name(m), next).first->second : next;
        if (surface[m] == next) {
            surfaces.name.push_back(name(m));
        }
    }
    for (const Index m : mesh.material) {
        surfaces.of.push_back(surface[m]);
    }
    return surfaces;
}

} // namespace

std::vector<double> Surfaces::areas(const Mesh& mesh) const {
    std::vector<double> area(size(), 0.0);
    for (std::size_t t = 0; t < of.size(); ++t) {
        area[of[t]] += mesh.areas[t];
    }
    return area;
}

Surfaces surfaces_by_face(const Mesh& mesh) {
    // Within a face all triangles are turned the same way but for those of its back.
    std::map<std::pair<Index, bool>, Index> number;
    std::map<Index, Vec3> front;
    std::vector<std::pair<Index, bool>> key;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Index face = mesh.original_face[t];
        const bool back = front.try_emplace(face, mesh.normals[t]).first->second.dot(mesh.normals[t]) < 0.0;
        key.emplace_back(face, back);
        number.try_emplace(key.back(), 0);
    }
    Surfaces surfaces;
    for (auto& [face, surface] : number) {
        surface = static_cast<Index>(surfaces.size());
        surfaces.name.push_back(std::to_string(face.first) + (face.second ? "b" : ""));
    }
    for (const auto& face : key) {
        surfaces.of.push_back(number.at(face));
    }
    return surfaces;
}

Surfaces surfaces_by_material(const Mesh& mesh, const std::vector<Material>& materials) {
    return surfaces_by_name(mesh, false, [&](Index m) { return material_name(materials, m); });
}

Surfaces surfaces_by_group(const Mesh& mesh, const std::vector<Material>& materials) {
    return surfaces_by_name(mesh, true, [&](Index m) {
        return m < materials.size() && !materials[m].light_group.empty() ? materials[m].light_group
                                                                         : material_name(materials, m);
    });
}

} // namespace difusa
