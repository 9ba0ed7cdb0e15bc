// A surface with its lights and camera, as stored in a JSON scene file.
#pragma once

#include "surface.h"

#include <optional>
#include <vector>

namespace scenes {

struct Sun {
    Vector towards;
    Colour irradiance; ///< on a surface facing it, W/m²
};

struct PointLight {
    Vector position;
    Colour intensity; ///< W/sr
};

/// Radiances, W/(m² sr).
struct Sky {
    Colour zenith, horizon, ground;
};

struct Camera {
    Vector eye, look_at;
    double view_degrees = 40.0; ///< vertical
};

/// A plane of symmetry; the normal points to the side of the surface.
struct SymmetryPlane {
    Vector point, normal;
};

struct Scene {
    Surface surface;
    char up = 'z';
    std::vector<Sun> suns;
    std::vector<PointLight> points;
    std::optional<Sky> sky;
    std::vector<SymmetryPlane> symmetry;
    std::vector<Vector> periodic; ///< translations
    Camera camera;
};

} // namespace scenes
