// Sensors that lie on the surface, moved off it: rays must not start in a face.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/mesh/mesh.h>
#include <difusa/radiosity/sensors.h>

namespace difusa {

/// Moves sensors off all faces that they lie on: edges and corners have several, to each of which the same applies.
class SensorLift {
  public:
    /// Distance from a face, relative to the scene's diameter, of a sensor that lies on it. So much is the rounding of
    /// coordinates that other programs write.
    static constexpr double touching = 1e-6;

    /// Keeps a reference.
    explicit SensorLift(const Mesh& mesh);

    /// Where the sensor measures: its position, if it lies on no face, or else twice `touching` off those it lies on,
    /// on the side that it belongs to. That is the front, unless it is planar and faces away from it: then it is the
    /// side that it is on, and the back if it is in the plane itself, to within the rounding of coordinates. Where
    /// faces contradict each other, as those of a sheet with two sides do, the one that faces most nearly as the
    /// sensor does decides.
    Vec3 operator()(const Sensor& sensor) const;

  private:
    const Mesh& mesh_;
    BoxTree faces_;
    double near_, rounding_;
};

} // namespace difusa
