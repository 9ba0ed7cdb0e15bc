// Readers of meshes for the targets that leave plugins out: there are none.
#include <difusa/core/error.h>
#include <difusa/import/reader.h>

namespace difusa {

PolygonSoup read_soup(const Registry& /*registry*/, const std::filesystem::path& file) {
    throw InputError(file.string() + ": is not read here");
}

} // namespace difusa
