// Shared by all parts of the glTF reader: the file, members with defaults, the soup to fill, notes.
#pragma once

#include <difusa/import/gltf_file.h>
#include <difusa/repair/polygon_soup.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// False for extensions that are neither supported nor irrelevant to diffuse light.
bool is_known_gltf_extension(std::string_view extension);

class GltfInput {
  public:
    /// `content` and `soup` must outlive the object.
    GltfInput(std::string_view content, const std::filesystem::path& name, PolygonSoup& soup)
        : file_(content, name), soup_(soup) {}

    GltfFile& file() { return file_; }
    const JsonChecks& checks() const { return file_.checks(); }
    PolygonSoup& soup() { return soup_; }

    /// Throws InputError for a file that requires an unsupported extension.
    void check_extensions() const;

    // Members of an object, with default values for missing ones.
    double number(const JsonValue& object, const char* name, double otherwise) const;
    Vec3 vector(const JsonValue& object, const char* name, const Vec3& otherwise) const;
    std::string text(const JsonValue& object, const char* name, const std::string& otherwise) const;

    /// The extension of an object, or null.
    const JsonValue* extension(const JsonValue& object, std::string_view name) const;

    /// Counts something the user should know; `where`: a material or mesh by its name.
    void note(const std::string& what, const std::string& meaning, const std::string& where = {},
              std::size_t amount = 1);

    /// A note in the soup for each `what`, in order of first appearance.
    void write_notes();

  private:
    struct Count {
        std::string what, meaning;
        std::size_t count = 0;
        std::vector<std::string> where; ///< distinct ones, as many as are named
        bool more = false;
    };
    GltfFile file_;
    PolygonSoup& soup_;
    std::vector<Count> counts_;
};

} // namespace difusa
