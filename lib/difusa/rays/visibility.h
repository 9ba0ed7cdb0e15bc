// Plugin kind "visibility": the first surface hit by a ray, and whether two points see each other.
#pragma once

#include <difusa/mesh/mesh.h>

#include <cstdint>
#include <limits>
#include <span>

namespace difusa {

/// A half-line. If it starts on a face, that face and all faces in the same plane (within rounding, see `OwnPlane`) are
/// not hit: a ray that leaves a plane does not return to it.
struct Ray {
    Vec3 origin;
    Vec3 direction;    ///< need not be unit; Hit::t is in units of its length
    Index face = none; ///< the face it starts on, or none
};

/// The first hit of a ray on the surface, from either side. Where the surface goes on beyond its mesh
/// (mesh/repetition.h), t is along the ray in the unfolded surface, and face, u and v are those of the original.
struct Hit {
    Index face = none;                                  ///< none: the ray escapes
    bool front = false;                                 ///< hit on the side that receives and sends light
    bool cut_off = false;                               ///< it does not escape, but was not followed to its end
    double t = std::numeric_limits<double>::infinity(); ///< position = origin + t direction
    double u = 0.0, v = 0.0;                            ///< as SurfacePoint
};

/// Which of two hits of one ray counts: the nearer one, but a front takes precedence over a back up to `slack` nearer
/// in t, so that each side of a wall without thickness sees its own sheet, however the t are rounded; of two equal ones
/// the lower face number, whatever the search order.
inline bool comes_before(const Hit& a, const Hit& b, double slack) {
    const double t_a = a.front ? a.t : a.t + slack, t_b = b.front ? b.t : b.t + slack;
    return t_a < t_b || (t_a == t_b && a.face < b.face);
}

/// The open segment between two surface points; the face of each (if any) is exempt as for rays.
struct Segment {
    Vec3 from, to;
    Index from_face = none, to_face = none;
};

/// A visibility engine over one mesh. Queries are const and may run on many threads at once. Faces block from both
/// sides.
class Visibility {
  public:
    virtual ~Visibility() = default;

    /// Builds the search structure. `mesh` must outlive the engine. Called once, before any query.
    virtual void build(const Mesh& mesh) = 0;

    /// hits[i] = first hit of rays[i]. The spans have the same length.
    virtual void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const = 0;

    /// blocked[i] = 1 if a face lies between the ends of segments[i], else 0.
    virtual void occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const = 0;
};

} // namespace difusa
