// Visibility by testing every triangle: the reference the fast engines are tested against, and the cheapest engine for
// a handful of triangles.
#pragma once

#include <difusa/rays/own_plane.h>
#include <difusa/rays/visibility.h>

#include <optional>

namespace difusa {

class BruteForceVisibility final : public Visibility {
  public:
    void build(const Mesh& mesh) override;
    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const override;

  private:
    const Mesh* mesh_ = nullptr;
    std::optional<OwnPlane> own_plane_;
};

/// The ray of a segment: from `from` with direction `to - from`, so that `to` is at t = 1.
inline Ray ray_of(const Segment& segment) {
    return {segment.from, segment.to - segment.from, segment.from_face};
}

/// Whether a face hit at `t` along `ray_of(segment)` lies strictly between the ends, excluding faces in the planes of
/// the ends.
inline bool blocks(const Segment& segment, const Mesh& mesh, const OwnPlane& own_plane, Index face, double t) {
    if (!(t > 0.0 && t < 1.0)) {
        return false;
    }
    const Vec3 along = segment.to - segment.from;
    const auto height = [&](Index own, double part) {
        return own == none ? 0.0 : part * std::abs(mesh.normals[own].dot(along));
    };
    return !own_plane.exempts(segment.from_face, face, height(segment.from_face, t)) &&
           !own_plane.exempts(segment.to_face, face, height(segment.to_face, 1.0 - t));
}

} // namespace difusa
