// Sensors that lie on the surface, moved off it: rays must not start in a face.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/mesh/mesh.h>
#include <difusa/radiosity/sensors.h>

namespace difusa {

/// Moves sensors off all faces that they lie on: edges and corners have several.
class SensorLift {
  public:
    /// Distance from a face, relative to the scene's diameter, of a sensor that lies on it. So much is the rounding of
    /// coordinates that other programs write.
    static constexpr double touching = 1e-6;

    /// Whether a planar sensor that faces away from a face may be behind it.
    enum class Back {
        in_plane, ///< if it is in the face's plane, to within the rounding of double precision, or already behind it:
                  ///< on the underside of a sheet
        never
    };

    /// Keeps a reference.
    explicit SensorLift(const Mesh& mesh);

    /// The sensor itself, if it lies on no face, or else where it is twice `touching` off those it lies on, in front of
    /// them but for `back`. It is moved off one face after the other, first off those that face most nearly as a planar
    /// sensor does, then as `towards`, then off the nearest, so that it may leave others behind: of two faces back to
    /// back, the first counts.
    Sensor operator()(Sensor sensor, const Vec3& towards, Back back) const;

  private:
    const Mesh& mesh_;
    BoxTree faces_;
    double near_, rounding_;
};

} // namespace difusa
