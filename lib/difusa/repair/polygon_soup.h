// The content of a mesh file before any checks: polygons over points, doubles kept, nothing dropped.
#pragma once

#include <difusa/core/types.h>
#include <difusa/mesh/repetition.h>
#include <difusa/scene/camera.h>
#include <difusa/scene/lights.h>
#include <difusa/scene/material.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace difusa {

/// One of several mesh files that make up a scene. Its faces and points are those up to the next part's first ones.
struct SoupPart {
    std::string file;
    std::size_t first_face = 0, first_point = 0;
    std::string name = {}; ///< given by the scene file, or empty
};

/// Of a corner without texture coordinates.
inline const TextureCoordinates unplaced = TextureCoordinates::Constant(std::numeric_limits<double>::quiet_NaN());

/// A polygon soup. Face f has the corners `corners[first_corner[f]] .. corners[first_corner[f+1]-1]`, point
/// numbers from 0 in the order of the file; they may be out of range (kept as read, `none` if negative).
struct PolygonSoup {
    std::string file;                         ///< the path the user gave, for messages
    std::vector<Vec3> points;                 ///< #P
    std::vector<Index> corners;               ///< #C
    std::vector<std::size_t> first_corner{0}; ///< #F + 1

    std::vector<Material> materials;    ///< materials and distinct face colours of the file
    std::vector<Index> face_material;   ///< #F, number in `materials`, or `none` (the caller's default)
    std::vector<Rgb> point_reflectance; ///< empty, or #P: vertex colours as linear reflectance

    bool colours_by_material =
        false; ///< vertex colours apply to materials that request them, not to faces without a material

    /// Empty, or #C: texture coordinates of the corners; `unplaced` where the file has none.
    std::vector<TextureCoordinates> corner_texture;

    Lights lights;
    /// Suns given by their time alone, by number, and how strong they are under a clear sky: in W/m² of all that they
    /// radiate, and of light. Which one holds is known once all lights are (`photometric`).
    struct ClearSun {
        std::size_t number;
        double radiated, light;
    };
    std::vector<ClearSun> clear_suns;
    std::optional<Camera> camera;
    Vec3 up = Vec3::UnitZ();                ///< unit, upwards: as the file says, or as most files of its format
    bool says_up = false;                   ///< the file or the standard of its format says so
    std::optional<double> unit;             ///< metres per unit of length, if the standard of the format says so
    bool photometric = false;               ///< lights are measured in lumens, candelas, lux, or cd/m²
    std::optional<Rgb> default_reflectance; ///< for faces without a material; absent: the caller's
    std::optional<double> surroundings;     ///< temperature in K of what a thermal scene is in

    Repetition repetition; ///< symmetry planes and periods, as the scene file gives them

    /// Positions in the file, for messages: line numbers from 1 (0 = unknown: binary files).
    std::vector<std::uint32_t> point_line; ///< empty, or #P
    std::vector<std::uint32_t> face_line;  ///< empty, or #F

    /// Empty, or the mesh files the soup was assembled from, in order.
    std::vector<SoupPart> parts;

    /// Notes of the reader for the user ("2 lines of kind `l` carry no surface").
    std::vector<std::string> notes;
    std::string undefined_note; ///< that of `notes` about faces whose materials are names alone; "": there is none

    /// Every file that was read: the mesh or scene file itself, what it names, and what those name. None may be
    /// overwritten by what is made from them.
    std::vector<std::filesystem::path> files;

    std::size_t face_count() const { return first_corner.size() - 1; }
    /// True if faces without a material take their reflectance from their corner colours.
    bool faces_are_painted() const { return !point_reflectance.empty() && !colours_by_material; }

    /// True if face f takes its reflectance from its corner colours: its material says so, or it has none and the
    /// points have colours for such faces.
    bool painted(std::size_t f) const {
        const Index material = face_material[f];
        return material == none || materials[material].is_undefined ? faces_are_painted()
                                                                    : materials[material].vertex_colours;
    }
    std::span<const Index> face(std::size_t f) const {
        return {corners.data() + first_corner[f], first_corner[f + 1] - first_corner[f]};
    }
    void add_face(std::span<const Index> face_corners, Index material, std::uint32_t line) {
        corners.insert(corners.end(), face_corners.begin(), face_corners.end());
        first_corner.push_back(corners.size());
        face_material.push_back(material);
        face_line.push_back(line);
    }
};

} // namespace difusa
