// The container of glTF 2.0 files: JSON and binary buffers, and safe reading of numbers from them.
#pragma once

#include <difusa/import/json_tree.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// An array of vectors in a buffer of a glTF file, which must outlive it.
class GltfAccessor {
  public:
    /// How the numbers of a vector are stored: the component types of glTF.
    enum class Component : std::uint16_t { int8 = 5120, uint8, int16, uint16, uint32 = 5125, float32 };

    std::size_t count() const { return count_; }
    std::size_t components() const { return components_; }
    Component component() const { return component_; }

    /// Component k of vector i < count(), normalised to [0,1] or [-1,1] if the file says so.
    double at(std::size_t i, std::size_t k) const;

  private:
    friend class GltfFile;
    std::size_t count_ = 0, components_ = 1, stride_ = 0, size_ = 1; ///< size: bytes of a component
    Component component_ = Component::float32;
    bool normalized_ = false;
    const char* data_ = nullptr; ///< null: zeros
    // Some vectors may be replaced by others (sparse accessors).
    std::vector<std::uint32_t> replaced_; ///< ascending
    const char* replacements_ = nullptr;
};

class GltfFile {
  public:
    /// Text (.gltf) or binary (.glb), detected from its first bytes. `content` must outlive the object.
    /// Throws InputError naming file and line for anything that is not glTF 2.0.
    GltfFile(std::string_view content, const std::filesystem::path& name);

    const JsonValue& root() const { return root_; }
    const JsonChecks& checks() const { return checks_; }

    /// Entry `index`, a value of the file, of the root's list `list`. Throws InputError if there is none.
    const JsonValue& entry(const char* list, const JsonValue& index) const;

    /// The accessor `index` of `components` numbers ("at least" with one more: colours have 3 or 4), all of whose
    /// vectors are in its buffer. One without a buffer, consisting of zeros, has no more vectors than the file has
    /// bytes.
    GltfAccessor accessor(const JsonValue& index, const std::string& what, std::size_t components,
                          bool one_more = false);

    /// The bytes of a buffer view.
    std::string_view bytes(const JsonValue& view_index);

    /// The bytes of a "data:" URI; nothing for other URIs.
    std::optional<std::string> embedded(const JsonValue& uri) const;

    /// The file a relative URI refers to; empty if there is none. Throws InputError for a URI with a scheme.
    std::filesystem::path beside(const JsonValue& uri);

    /// All files that `beside` has found, buffers included.
    const std::vector<std::filesystem::path>& files() const { return files_; }

  private:
    struct View {
        std::string_view bytes;
        std::size_t stride; ///< 0: not given
    };
    void split_binary(std::string_view content);
    std::string_view buffer(const JsonValue& index);
    View view(const JsonValue& index);
    void read_sparse(const JsonValue& sparse, GltfAccessor& accessor);
    std::size_t whole(const JsonValue& object, const char* name, std::size_t otherwise) const;

    JsonChecks checks_;
    std::filesystem::path folder_;
    JsonValue root_;
    std::string_view json_, binary_;
    bool has_binary_ = false;
    std::size_t size_ = 0;                             ///< bytes of the file and of its external buffers
    std::vector<std::optional<std::string>> contents_; ///< of external buffers
    std::vector<std::filesystem::path> files_;
};

} // namespace difusa
