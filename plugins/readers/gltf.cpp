// reader gltf: scenes in glTF 2.0 (.gltf, .glb), with materials, textures, lights and camera.
//
// Read: nodes with their transforms, triangles, strips and fans, vertex colours, base colour and emission with textures
// (PNG, JPEG; KHR_texture_transform), double-sided materials, point, spot and directional lights (KHR_lights_punctual),
// the first perspective camera. Lengths are metres; y stays up.
//
// A diffuse surface reflects base colour times (1 - metallic), or the diffuse colour of
// KHR_materials_pbrSpecularGlossiness times (1 - the largest channel of its specular colour), as specified. Base colour
// times metallic is reflected specularly: by a mirror if the roughness is 0, otherwise in a GGX lobe (data/GLOSS.md).
// The specification also says that a material without "metallicFactor" is metal: it has no diffuse part here, and is
// noted, since exporters often mean paint. Unlit materials (KHR_materials_unlit) are treated as paint of their base
// colour. Faces of primitives without a material have the default reflectance (--reflectance), not glTF's white metal.
// glTF uses photometric units, difusa watts: 683 lm are taken as 1 W, the convention of exporters (importing inverts
// it), so 1 cd/m² of emission is pi/683 W/m², 1 cd of intensity 1/683 W/sr, and 1 lux of a sun 1/683 W/m².
//
// Noted: lines and points, leftover vertices, transparency, textured metalness, roughness and specular colour (their
// means are used), normal and occlusion textures, skins, morph targets, instances, ranges of lights, materials with
// unknown extensions. Rejected: a file that requires an extension that is neither supported nor irrelevant to diffuse
// light.
#include <difusa/import/file_content.h>
#include <difusa/import/gltf_input.h>
#include <difusa/import/gltf_lights.h>
#include <difusa/import/gltf_meshes.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/plugin.h>
#include <difusa/repair/texture_coordinates.h>

#include <algorithm>
#include <set>

namespace {

using namespace difusa;

/// The traversal of the nodes; their contents are read by the parts of import/.
class GltfScene {
  public:
    GltfScene(std::string_view content, const std::filesystem::path& name, PolygonSoup& soup)
        : input_(content, name, soup), meshes_(input_) {}

    void read() {
        input_.check_extensions();
        input_.soup().colours_by_material = true;
        read_nodes();
        input_.write_notes();
        input_.soup().files = input_.file().files();
        settle_textures(input_.soup());
    }

  private:
    /// The axes of a matrix, normalised. A degenerate one is replaced by the normal of the others.
    static Eigen::Matrix3d axes(const Eigen::Matrix3d& linear) {
        Eigen::Matrix3d result;
        for (Eigen::Index k = 0; k < 3; ++k) {
            result.col(k) = linear.col(k).stableNormalized();
        }
        for (Eigen::Index k = 0; k < 3; ++k) {
            if (result.col(k).isZero(0.0)) {
                const Vec3 normal = result.col((k + 1) % 3).cross(result.col((k + 2) % 3));
                result.col(k) = normal / normal.norm(); // NaN if another one is degenerate
            }
        }
        return result;
    }

    GltfNodePlace placement_of(const JsonValue& node) const {
        GltfNodePlace result;
        Placement& place = result.place;
        if (const JsonValue* matrix = node.find("matrix")) {
            const std::vector<double> m = input_.checks().numbers(*matrix, quoted("matrix"), 16); // column by column
            if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
                input_.checks().fail(*matrix,
                                     "\"matrix\" has 16 numbers column by column, and its last row must be 0 0 "
                                     "0 1: export the scene again");
            }
            for (std::size_t column = 0; column < 3; ++column) {
                for (std::size_t row = 0; row < 3; ++row) {
                    place.linear(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
                        m[4 * column + row];
                }
                place.offset[static_cast<Eigen::Index>(column)] = m[12 + column];
            }
            result.turn = axes(place.linear);
            return result;
        }
        place.offset = input_.vector(node, "translation", Vec3::Zero());
        const Vec3 scale = input_.vector(node, "scale", Vec3::Ones());
        place.linear = scale.asDiagonal();
        if (const JsonValue* rotation = node.find("rotation")) {
            const std::vector<double> q = input_.checks().numbers(*rotation, quoted("rotation"), 4);
            const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
            if (!(turn.norm() > 0.0)) {
                input_.checks().fail(*rotation, "\"rotation\" is a quaternion of length 0: export the scene again");
            }
            result.turn = turn.normalized().toRotationMatrix();
            place.linear = result.turn * place.linear;
        }
        return result;
    }

    /// The root nodes: those of the default scene, or all that are not children.
    std::vector<const JsonValue*> roots() {
        std::vector<const JsonValue*> result;
        const JsonValue *scenes = input_.file().root().find("scenes"), *shown = input_.file().root().find("scene");
        if (scenes != nullptr && !scenes->items.empty()) {
            const JsonValue& scene = shown == nullptr ? scenes->items[0] : input_.file().entry("scenes", *shown);
            if (scenes->items.size() > 1) {
                input_.soup().notes.push_back("the file has " + std::to_string(scenes->items.size()) +
                                              " scenes, of which one is read: the default one, or the first");
            }
            if (const JsonValue* nodes = scene.find("nodes")) {
                for (const JsonValue& node : input_.checks().list(*nodes, quoted("nodes"))) {
                    result.push_back(&node);
                }
            }
            return result;
        }
        const JsonValue* nodes = input_.file().root().find("nodes");
        if (nodes == nullptr) {
            return result;
        }
        std::set<double> children;
        for (const JsonValue& node : nodes->items) {
            if (const JsonValue* list = node.find("children")) {
                for (const JsonValue& child : input_.checks().list(*list, quoted("children"))) {
                    children.insert(input_.checks().number(child, quoted("children")));
                }
            }
        }
        own_indices_.resize(nodes->items.size());
        for (std::size_t n = 0; n < nodes->items.size(); ++n) {
            JsonValue& index = own_indices_[n];
            index.kind = JsonValue::Kind::number;
            index.number = static_cast<double>(n);
            index.line = nodes->items[n].line;
            if (!children.contains(index.number)) {
                result.push_back(&index);
            }
        }
        return result;
    }

    void read_nodes() {
        struct Step {
            const JsonValue* index;
            GltfNodePlace parent;
        };
        std::vector<Step> open;
        for (const JsonValue* root : roots()) {
            open.push_back({root, {}});
        }
        std::reverse(open.begin(), open.end());
        const JsonValue* nodes = input_.file().root().find("nodes");
        std::vector<char> met(nodes == nullptr ? 0 : nodes->items.size(), 0);
        while (!open.empty()) {
            const Step step = open.back();
            open.pop_back();
            const JsonValue& node = input_.file().entry("nodes", *step.index);
            char& again = met[static_cast<std::size_t>(step.index->number)];
            if (again != 0) {
                input_.checks().fail(*step.index,
                                     "node " + std::to_string(static_cast<std::size_t>(step.index->number)) +
                                         " has two parents, or is its own ancestor: export the scene again");
            }
            again = 1;
            const GltfNodePlace own = placement_of(node);
            const GltfNodePlace place{step.parent.place * own.place, step.parent.turn * own.turn};
            read_node(node, place);
            if (const JsonValue* children = node.find("children")) {
                const std::vector<JsonValue>& list = input_.checks().list(*children, quoted("children"));
                for (std::size_t c = list.size(); c-- > 0;) {
                    open.push_back({&list[c], place});
                }
            }
        }
    }

    void read_node(const JsonValue& node, const GltfNodePlace& place) {
        if (node.find("skin") != nullptr) {
            input_.note("nodes with a skin", "their meshes are read without it");
        }
        if (input_.extension(node, "EXT_mesh_gpu_instancing") != nullptr) {
            input_.note("nodes with many instances (EXT_mesh_gpu_instancing)",
                        "one is read; export each instance as a node of its own");
        }
        if (const JsonValue* mesh = node.find("mesh")) {
            meshes_.read_mesh(*mesh, place.place);
        }
        if (const JsonValue* camera = node.find("camera")) {
            read_gltf_camera(input_, *camera, place);
        }
        if (const JsonValue* light = input_.extension(node, "KHR_lights_punctual")) {
            read_gltf_light(input_, input_.checks().required(*light, quoted("KHR_lights_punctual"), "light"), place);
        }
    }

    GltfInput input_;
    GltfMeshes meshes_;
    std::vector<JsonValue> own_indices_; ///< of nodes, for a file without scenes
};

class GltfReader final : public Reader {
  public:
    explicit GltfReader(const Parameters&) {}

    std::vector<std::string> extensions() const override { return {"gltf", "glb"}; }

    PolygonSoup read(const std::filesystem::path& file) const override { return parse(read_file(file), file); }

    PolygonSoup parse(std::string_view content, const std::filesystem::path& name) const override {
        PolygonSoup soup;
        soup.file = name.string();
        soup.up = Vec3::UnitY();
        soup.says_up = true;
        soup.unit = 1.0;
        GltfScene(content, name, soup).read();
        return soup;
    }
};

} // namespace

DIFUSA_PLUGIN(reader, "gltf", GltfReader,
              "glTF 2.0 scenes with textures, lights and camera (.gltf .glb); 683 lm are taken as 1 W.", {})
