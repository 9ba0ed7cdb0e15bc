#include <difusa/form_factors/surfaces.h>

#include <array>
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

/// #T: 1 for backs that were added to a face of the file, whose triangles are all turned the same way but for them.
std::vector<char> added_backs(const Mesh& mesh) {
    std::map<Index, Vec3> front;
    std::vector<char> back;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3& first = front.try_emplace(mesh.original_face[t], mesh.normals[t]).first->second;
        back.push_back(first.dot(mesh.normals[t]) < 0.0 ? 1 : 0);
    }
    return back;
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
    const std::vector<char> back = added_backs(mesh);
    std::map<std::pair<Index, bool>, Index> number;
    std::vector<std::pair<Index, bool>> key;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        key.emplace_back(mesh.original_face[t], back[t] != 0);
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

Surfaces with_backs_apart(const Mesh& mesh, const Surfaces& surfaces) {
    const std::vector<char> back = added_backs(mesh);
    std::vector<std::array<char, 2>> has(surfaces.size(), {0, 0});
    for (std::size_t t = 0; t < back.size(); ++t) {
        has[surfaces.of[t]][back[t] != 0 ? 1 : 0] = 1;
    }
    Surfaces apart;
    std::vector<std::array<Index, 2>> number(surfaces.size(), {none, none});
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        for (std::size_t side = 0; side < 2; ++side) {
            if (has[i][side] != 0) {
                number[i][side] = static_cast<Index>(apart.name.size());
                apart.name.push_back(surfaces.name[i] + (side == 1 && has[i][0] != 0 ? " (back)" : ""));
            }
        }
    }
    for (std::size_t t = 0; t < back.size(); ++t) {
        apart.of.push_back(number[surfaces.of[t]][back[t] != 0 ? 1 : 0]);
    }
    return apart;
}

Surfaces surfaces_by_group(const Mesh& mesh, const std::vector<Material>& materials) {
    return surfaces_by_name(mesh, true, [&](Index m) {
        return m < materials.size() && !materials[m].light_group.empty() ? materials[m].light_group
                                                                         : material_name(materials, m);
    });
}

} // namespace difusa
