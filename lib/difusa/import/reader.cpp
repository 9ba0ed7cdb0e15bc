#include <difusa/import/reader.h>

#include <difusa/core/error.h>
#include <difusa/import/text_scanner.h>
#include <difusa/plugin/registry.h>

#include <algorithm>

namespace difusa {

PolygonSoup read_soup(const Registry& registry, const std::filesystem::path& file) {
    std::string extension = lower_case(file.extension().string());
    extension.erase(0, extension.empty() ? 0 : 1);

    std::vector<std::string> known;
    for (const std::string& name : registry.names(kind_of<Reader>())) {
        const std::shared_ptr<Reader> reader = registry.create<Reader>(name);
        for (const std::string& claimed : reader->extensions()) {
            if (claimed == extension) {
                PolygonSoup soup = reader->read(file);
                soup.files.insert(soup.files.begin(), file);
                return soup;
            }
            known.push_back("." + claimed);
        }
    }
    check_readable(file);        // a missing file is reported before an unknown extension
    known.emplace_back(".json"); // scenes, handled by read_scene
    std::sort(known.begin(), known.end());
    std::string list;
    for (const std::string& each : known) {
        list += (list.empty() ? "" : " ") + each;
    }
    for (const RefusedPlugin& refused : registry.refused()) {
        list += " (refused: " + refused.file.filename().string() + ": " + refused.reason + ")";
    }
    throw InputError(file.string() + ": " +
                     (extension.empty() ? "the name has no extension" : "no reader handles this extension") +
                     "; there are readers for: " + (list.empty() ? "nothing (no reader plugin was found)" : list) +
                     ". Convert the mesh, or rename the file if it is in one of these formats");
}

} // namespace difusa
