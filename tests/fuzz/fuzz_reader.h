// What every reader must hold to for any input: a sound soup or an InputError, within memory in proportion to it.
#pragma once

#include <difusa/core/error.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/plugin.h>

#include <cstdio>
#include <cstdlib>

namespace fuzz {

inline void hold(bool holds, const char* what) {
    if (!holds) {
        std::fprintf(stderr, "broken promise: %s\n", what);
        std::abort();
    }
}

/// No container has more than `most` entries, or thrice as many corners: each costs the file at least one byte.
inline void check(const difusa::PolygonSoup& soup, std::size_t most) {
    const std::size_t points = soup.points.size(), faces = soup.face_count();
    hold(!soup.first_corner.empty() && soup.first_corner.front() == 0, "the first face begins at corner 0");
    hold(soup.first_corner.back() == soup.corners.size(), "the last face ends at the last corner");
    for (std::size_t f = 0; f < faces; ++f) {
        hold(soup.first_corner[f] <= soup.first_corner[f + 1], "faces follow one another");
    }
    hold(soup.face_material.size() == faces, "one material for each face");
    for (const difusa::Index material : soup.face_material) {
        hold(material == difusa::none || material < soup.materials.size(), "materials of faces exist");
    }
    hold(soup.face_line.empty() || soup.face_line.size() == faces, "lines for all faces or none");
    hold(soup.point_line.empty() || soup.point_line.size() == points, "lines for all points or none");
    hold(soup.point_reflectance.empty() || soup.point_reflectance.size() == points, "colours for all points or none");
    for (const difusa::Rgb& colour : soup.point_reflectance) {
        hold((colour >= 0.0).all() && (colour <= 1.0).all(), "reflectances of points are within [0,1]");
    }
    hold(soup.corner_texture.empty() || soup.corner_texture.size() == soup.corners.size(),
         "texture coordinates for all corners or none");
    hold(points <= most && faces <= most && soup.corners.size() <= 3 * most, "memory in proportion to the file");
}

/// Reads the input with the reader of a plugin. `most`: see `check`; 0: the size.
inline void read(const difusa::PluginDescription& plugin, const std::uint8_t* data, std::size_t size,
                 std::size_t most = 0) {
    const std::unique_ptr<difusa::Reader> reader(static_cast<difusa::Reader*>(plugin.create(difusa::Parameters{})));
    try {
        check(reader->parse({reinterpret_cast<const char*>(data), size}, "no-such-directory/input"),
              most == 0 ? size : most);
    } catch (const difusa::InputError& error) {
        hold(std::string_view(error.what()).find("input") != std::string_view::npos, "messages name the file");
    }
}

} // namespace fuzz
