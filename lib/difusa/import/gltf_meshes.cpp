#include <difusa/import/gltf_meshes.h>

#include <difusa/core/error.h>
#include <difusa/core/memory.h>

#include <algorithm>
#include <array>
#include <optional>

namespace difusa {

namespace {

Rgb vertex_colour(const GltfAccessor& colours, std::size_t v) {
    return Rgb(colours.at(v, 0), colours.at(v, 1), colours.at(v, 2)).max(0.0).min(1.0);
}

} // namespace

void GltfMeshes::read_mesh(const JsonValue& index, const Placement& place) {
    const JsonValue& mesh = input_.file().entry("meshes", index);
    const std::string name = "mesh " + std::to_string(static_cast<std::size_t>(index.number));
    mesh_is_new_ = met_.insert(static_cast<std::size_t>(index.number)).second;
    if (mesh.find("weights") != nullptr) {
        note_mesh("meshes with morph targets", "their base shape is read", name);
    }
    for (const JsonValue& primitive :
         input_.checks().list(input_.checks().required(mesh, name, "primitives"), quoted("primitives"))) {
        read_primitive(primitive, name, place);
    }
}

void GltfMeshes::note_mesh(const std::string& what, const std::string& meaning, const std::string& name,
                           std::size_t amount) {
    if (mesh_is_new_) {
        input_.note(what, meaning, name, amount);
    }
}

std::array<std::size_t, 3> GltfMeshes::triangle(std::size_t mode, std::size_t t) {
    if (mode == 4) {
        return {3 * t, 3 * t + 1, 3 * t + 2};
    }
    if (mode == 5) {
        return {t, t + 1 + t % 2, t + 2 - t % 2};
    }
    return {t + 1, t + 2, 0};
}

void GltfMeshes::read_primitive(const JsonValue& from, const std::string& name, const Placement& place) {
    std::optional<Primitive> primitive = primitive_of(from, name);
    if (!primitive) {
        return;
    }
    const std::size_t mode = primitive->mode;
    const std::size_t count = primitive->indices ? primitive->indices->count() : primitive->positions.count();
    const std::size_t triangles = mode == 4 ? count / 3 : count < 3 ? 0 : count - 2;
    const std::size_t left_over = mode == 4 ? count % 3 : count < 3 ? count : 0;
    if (left_over > 0) {
        note_mesh("leftover vertices that form no triangle", "they are ignored; export the mesh again", name,
                  left_over);
    }
    require_room(triangles);
    for (std::size_t t = 0; t < triangles; ++t) {
        std::array<std::size_t, 3> corners = triangle(mode, t);
        for (std::size_t& corner : corners) {
            corner = primitive->indices ? static_cast<std::size_t>(primitive->indices->at(corner, 0)) : corner;
            if (corner >= primitive->positions.count()) {
                input_.checks().fail(
                    from, name + ", triangle " + std::to_string(t) + " refers to vertex " + std::to_string(corner) +
                              " of " + std::to_string(primitive->positions.count()) + ": export the scene again");
            }
        }
        if (mode == 5 && (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])) {
            continue; // degenerate, where strips are joined
        }
        if (place.mirrors()) {
            std::swap(corners[1], corners[2]);
        }
        add_triangle(*primitive, corners, place);
    }
    PolygonSoup& soup = input_.soup();
    if (!soup.point_reflectance.empty()) {
        soup.point_reflectance.resize(soup.points.size(), Rgb::Constant(0.5));
    }
    if (!soup.corner_texture.empty()) {
        soup.corner_texture.resize(soup.corners.size(), unplaced);
    }
}

std::optional<GltfMeshes::Primitive> GltfMeshes::primitive_of(const JsonValue& from, const std::string& name) {
    const JsonChecks& checks = input_.checks();
    checks.object(from, "a primitive");
    if (input_.extension(from, "KHR_draco_mesh_compression") != nullptr && from.find("attributes") != nullptr &&
        from.find("attributes")->names.empty()) {
        checks.fail(from,
                    name + " is compressed (Draco), which is not supported: export the scene without compression");
    }
    const JsonValue* mode_given = from.find("mode");
    const std::size_t mode = mode_given == nullptr ? 4 : checks.whole(*mode_given, quoted("mode"));
    if (mode < 4 || mode > 6) {
        note_mesh("primitives of points or lines", "they have no surface and are ignored", name);
        return std::nullopt;
    }
    const JsonValue& attributes = checks.required(from, "a primitive of " + name, "attributes");
    checks.object(attributes, quoted("attributes"));
    const JsonValue* position_index = attributes.find("POSITION");
    if (position_index == nullptr) {
        note_mesh("primitives without positions", "they are ignored", name);
        return std::nullopt;
    }
    Primitive result;
    result.mode = mode;
    result.positions = input_.file().accessor(*position_index, "POSITION", 3);
    const JsonValue* material_index = from.find("material");
    const GltfMaterials::Surface* const look =
        material_index == nullptr ? nullptr : &materials_.surface(*material_index);
    read_arrays(from, attributes, name, look == nullptr ? 0 : look->texture_set, result);
    if (from.find("targets") != nullptr) {
        note_mesh("primitives with morph targets", "their base shape is read", name);
    }
    const bool tinted = look != nullptr && result.colours && (look->material.specular() > 0.0).any();
    result.material = materials_.material(material_index, result.colours.has_value(),
                                          tinted ? mean_colour(result, name) : Rgb(Rgb::Ones()));
    if (result.material == none) {
        note_mesh("primitives without a material",
                  "their faces have the default reflectance (--reflectance); give them a material", name);
    }
    result.factor = look == nullptr ? Rgb(Rgb::Ones()) : look->material.reflectance;
    result.vertex.assign(result.positions.count(), none);
    return result;
}

void GltfMeshes::read_arrays(const JsonValue& from, const JsonValue& attributes, const std::string& name,
                             std::size_t texture_set, Primitive& to) {
    const auto matching = [&](const char* what, const JsonValue& index, std::size_t components, bool more) {
        GltfAccessor accessor = input_.file().accessor(index, what, components, more);
        if (accessor.count() != to.positions.count()) {
            input_.checks().fail(index, name + " has " + std::to_string(to.positions.count()) + " positions and " +
                                            std::to_string(accessor.count()) + " of " + what +
                                            ": export the scene again");
        }
        return accessor;
    };
    const std::string set = "TEXCOORD_" + std::to_string(texture_set);
    if (const JsonValue* index = attributes.find(set)) {
        to.textures = matching(set.c_str(), *index, 2, false);
    }
    if (const JsonValue* index = attributes.find("COLOR_0")) {
        to.colours = matching("COLOR_0", *index, 3, true);
    }
    if (const JsonValue* index = from.find("indices")) {
        to.indices = input_.file().accessor(*index, "indices", 1);
        if (to.indices->component() != GltfAccessor::Component::uint8 &&
            to.indices->component() != GltfAccessor::Component::uint16 &&
            to.indices->component() != GltfAccessor::Component::uint32) {
            input_.checks().fail(*index, name + " has indices that are not unsigned: export the scene again");
        }
    }
}

Rgb GltfMeshes::mean_colour(const Primitive& primitive, const std::string& name) {
    const std::size_t corners = primitive.indices ? primitive.indices->count() : primitive.positions.count();
    Rgb sum = Rgb::Zero(), least = Rgb::Ones(), most = Rgb::Zero();
    for (std::size_t i = 0; i < corners; ++i) {
        const auto v = primitive.indices ? static_cast<std::size_t>(primitive.indices->at(i, 0)) : i;
        if (v < primitive.colours->count()) { // another is refused when its triangle is read
            const Rgb colour = vertex_colour(*primitive.colours, v);
            sum += colour;
            least = least.min(colour);
            most = most.max(colour);
        }
    }
    if (!(least < most).any()) {
        return most;
    }
    note_mesh("primitives of metal with vertex colours", "their mean is used for what is reflected specularly", name);
    return sum / static_cast<double>(corners);
}

void GltfMeshes::add_triangle(Primitive& primitive, const std::array<std::size_t, 3>& corners, const Placement& place) {
    PolygonSoup& soup = input_.soup();
    std::array<Index, 3> face;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t v = corners[k];
        if (primitive.vertex[v] == none) {
            primitive.vertex[v] = static_cast<Index>(soup.points.size());
            const GltfAccessor& x = primitive.positions;
            soup.points.push_back(place({x.at(v, 0), x.at(v, 1), x.at(v, 2)}));
            if (primitive.colours) {
                add_colour(primitive.factor * vertex_colour(*primitive.colours, v));
            }
        }
        face[k] = primitive.vertex[v];
    }
    soup.add_face(face, primitive.material, 0);
    if (primitive.textures) {
        soup.corner_texture.resize(soup.corners.size() - 3, unplaced);
        for (const std::size_t v : corners) {
            soup.corner_texture.emplace_back(primitive.textures->at(v, 0), 1.0 - primitive.textures->at(v, 1));
        }
    }
}

void GltfMeshes::add_colour(const Rgb& colour) {
    input_.soup().point_reflectance.resize(input_.soup().points.size() - 1, Rgb::Constant(0.5));
    input_.soup().point_reflectance.push_back(colour.max(0.0).min(1.0));
}

void GltfMeshes::require_room(std::size_t triangles) {
    constexpr double bytes = 3 * (sizeof(Vec3) + sizeof(Rgb) + sizeof(TextureCoordinates) + sizeof(Index)) + 16;
    constexpr double step = 0x1p28;
    if (input_.soup().corners.size() + 3 * triangles >= none) {
        throw ResourceError(input_.checks().file() +
                            ": with all instances of its meshes the scene has more triangles than "
                            "can be numbered (1.4e9): export it in parts");
    }
    if (static_cast<double>(input_.soup().face_count() + triangles) * bytes > asked_for_) {
        asked_for_ = static_cast<double>(input_.soup().face_count() + triangles) * bytes + step;
        require_memory(static_cast<double>(triangles) * bytes + step, available_memory(),
                       "the scene " + input_.checks().file() + " with all instances of its meshes",
                       "export it in parts");
    }
}

} // namespace difusa
