// Rays in the unfolded surface of a mesh that goes on beyond symmetry planes and periods (mesh/repetition.h). A ray
// that leaves the cell goes on in it from where the wall it has passed leads back to: reflected, or displaced.
#pragma once

#include <difusa/rays/visibility.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace difusa {

/// An engine around another one, which knows the mesh alone. Rays and segments are those of the unfolded surface: they
/// may start and end anywhere in it. Those that start on a face start on the mesh itself. The plane of a face is exempt
/// only as long as a ray is in the cell where it starts: a face may see its own image.
class UnfoldedVisibility final : public Visibility {
  public:
    /// Walls passed in a row: a ray between that many empty cells of an infinite series is cut off.
    static constexpr std::size_t most_walls = 1024;

    explicit UnfoldedVisibility(std::shared_ptr<Visibility> engine) : engine_(std::move(engine)) {}

    void build(const Mesh& mesh) override;
    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;
    void occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const override;

  private:
    struct Way;
    bool is_outside(const Vec3& p) const;
    Way way_from(const Vec3& origin, const Vec3& direction, bool on_face) const;
    template <class Visit> bool walk(Way way, const Visit& visit) const;
    Hit first_hit_beyond(const Ray& ray, bool from_here) const;
    bool is_blocked(const Segment& segment) const;

    /// Of the unfolded surface, in a direction in which it ends.
    struct Extent {
        Vec3 direction = Vec3::UnitZ();
        double low = 0.0, high = 0.0;
    };
    std::shared_ptr<Visibility> engine_;
    const Mesh* mesh_ = nullptr;
    std::vector<Extent> extents_;
    double rounding_ = 0.0;
};

/// Builds the engine over the mesh, and if that goes on beyond its triangles, puts one around it that knows.
std::shared_ptr<Visibility> built_over(const Mesh& mesh, std::shared_ptr<Visibility> engine);

} // namespace difusa
