// Plugin kind "reader": turns a mesh file into a polygon soup.
#pragma once

#include <difusa/repair/polygon_soup.h>

#include <filesystem>
#include <string>
#include <vector>

namespace difusa {

class Registry;

class Reader {
  public:
    virtual ~Reader() = default;

    /// File name extensions this reader handles, lower case without the dot: {"off", "coff"}.
    virtual std::vector<std::string> extensions() const = 0;

    /// Reads the whole file, checking only what the format itself requires; out-of-range indices, NaN and the like are
    /// left to the diagnosis. Memory use is bounded by a multiple of the file's size, whatever its header promises.
    /// Throws InputError naming file and line (or byte offset) and the remedy.
    virtual PolygonSoup read(const std::filesystem::path& file) const = 0;

    /// The same from memory; `name` is for messages and for finding neighbouring files (MTL), which the
    /// reader enters in PolygonSoup::files.
    virtual PolygonSoup parse(std::string_view content, const std::filesystem::path& name) const = 0;
};

/// Reads `file` with the registered reader for its extension (upper or lower case), and enters it in
/// PolygonSoup::files.
/// Throws InputError if the file cannot be opened or no reader handles the extension (listing the known ones).
PolygonSoup read_soup(const Registry& registry, const std::filesystem::path& file);

} // namespace difusa
