// From a point of space to the nearest point of a mesh's surface.
#pragma once

#include <difusa/mesh/mesh.h>
#include <difusa/mesh/nearest_surface.h>

#include <optional>

namespace difusa {

/// A tree over the triangles of a mesh, which must outlive it. Searches may run in parallel.
class SurfaceFinder {
  public:
    struct Found {
        SurfacePoint point;    ///< with the normal of its face
        double distance = 0.0; ///< from the point of space
    };

    explicit SurfaceFinder(const Mesh& mesh) : mesh_(mesh), surface_(mesh.points, mesh.triangles) {}

    /// The nearest surface point; with a normal (unit), the nearest on triangles that turn from it by less than 90°,
    /// and on an edge the one on the side that the normal points to. Nothing if no triangle faces that way.
    std::optional<Found> nearest(const Vec3& position, const Vec3& normal = Vec3::Zero()) const;

  private:
    const Mesh& mesh_;
    const NearestSurface surface_;
};

} // namespace difusa
