// Polygons with materials, as stored in scene files, and the shapes that scenes are built from. Standard C++ only, so
// that scenes can be generated before anything else is built.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace scenes {

struct Vector {
    double x = 0.0, y = 0.0, z = 0.0;
};

struct Colour {
    double r = 0.0, g = 0.0, b = 0.0;
};

struct Material {
    std::string name;
    Colour reflectance;       ///< linear, 0 to 1
    Colour emission;          ///< emitted radiosity, W/m²
    Colour mirror = {};       ///< specular reflectance
    std::string thermal = {}; ///< members of its entry in the scene file, which replaces the above there
    double exponent = 0.0;    ///< of the Phong lobe in which `mirror` is reflected; 0: as by a mirror
};

struct Face {
    std::vector<unsigned> corners; ///< counterclockwise seen from the front
    unsigned material = 0;
};

/// Polygons that share their corners: no two points coincide.
class Surface {
  public:
    std::vector<Material> materials;
    std::vector<std::string> remarks; ///< description and origin of the scene: comment lines for its files

    const std::vector<Vector>& points() const { return points_; }
    const std::vector<Face>& faces() const { return faces_; }
    std::size_t triangle_count() const;

    /// Adds a material and returns its number.
    unsigned add(Material material);

    /// The number of the point at this position, added if there is none.
    unsigned point(const Vector& place);

    void face(std::vector<unsigned> corners, unsigned material);
    void polygon(const std::vector<Vector>& corners, unsigned material);

  private:
    std::vector<Vector> points_;
    std::vector<Face> faces_;
    std::map<std::array<double, 3>, unsigned> number_;
};

/// Sides of a box, in the order in which its materials are given.
enum Side : unsigned { x_low, x_high, y_low, y_high, z_low, z_high };

/// The surface of a box of nx × ny × nz lattice cells, two triangles per cell, watertight; `place` gives the position
/// of lattice point (i, j, k). Fronts are outside unless `inward`.
void add_lattice_box(Surface& surface, const std::array<int, 3>& cells,
                     const std::function<Vector(int, int, int)>& place, const std::array<unsigned, 6>& material,
                     bool inward);

/// The box between two corners, each side divided into equal cells.
void add_box(Surface& surface, const Vector& low, const Vector& high, const std::array<int, 3>& cells,
             const std::array<unsigned, 6>& material, bool inward);

/// A ball of 12 n² triangles of about equal size, points on the sphere, fronts outside: a cube projected onto it.
void add_ball(Surface& surface, const Vector& centre, double radius, int n, unsigned material);

} // namespace scenes
