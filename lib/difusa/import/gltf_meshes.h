// The triangles of glTF meshes, with their colours, texture coordinates and materials.
#pragma once

#include <difusa/import/gltf_input.h>
#include <difusa/import/gltf_materials.h>
#include <difusa/import/placement.h>

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace difusa {

class GltfMeshes {
  public:
    /// `input` must outlive the object.
    explicit GltfMeshes(GltfInput& input) : input_(input), materials_(input) {}

    /// Adds mesh `index` of the file at `place` to the soup.
    void read_mesh(const JsonValue& index, const Placement& place);

  private:
    struct Primitive {
        std::size_t mode = 4; ///< triangles: a list (4), a strip (5) or a fan (6)
        GltfAccessor positions;
        std::optional<GltfAccessor> textures, colours, indices;
        Index material = none;
        Rgb factor = Rgb::Ones(); ///< on the colours
        /// Numbers in the soup, assigned as faces use them: many primitives may share one large array.
        std::vector<Index> vertex;
    };
    /// For a mesh with many instances, only once.
    void note_mesh(const std::string& what, const std::string& meaning, const std::string& name,
                   std::size_t amount = 1);
    /// Three vertices of triangle t of a list (4), strip (5) or fan (6).
    static std::array<std::size_t, 3> triangle(std::size_t mode, std::size_t t);
    void read_primitive(const JsonValue& from, const std::string& name, const Placement& place);

    /// Nothing, with a note, for primitives without surface.
    std::optional<Primitive> primitive_of(const JsonValue& from, const std::string& name);
    void read_arrays(const JsonValue& from, const JsonValue& attributes, const std::string& name,
                     std::size_t texture_set, Primitive& to);
    /// The mean of the vertex colours over the primitive's corners.
    Rgb mean_colour(const Primitive& primitive, const std::string& name);
    void add_triangle(Primitive& primitive, const std::array<std::size_t, 3>& corners, const Placement& place);
    void add_colour(const Rgb& colour);
    /// A mesh may have many instances: a small file can require more memory than there is.
    void require_room(std::size_t triangles);

    GltfInput& input_;
    GltfMaterials materials_;
    std::set<std::size_t> met_; ///< meshes
    bool mesh_is_new_ = true;   ///< the current one is seen for the first time
    double asked_for_ = 0x1p26; ///< bytes known to be available
};

} // namespace difusa
