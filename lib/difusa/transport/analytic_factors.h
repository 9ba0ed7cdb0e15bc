// Form factors from a point to surface without rays, in closed form, where what occludes it is simple.
#pragma once

#include <difusa/rays/polygon_in_sight.h>
#include <difusa/transport/surfel_tree.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace difusa {

/// Looks for the largest groups of surfels in sight of a point that nothing occludes (rays/shaft.h), whose form factors
/// are then closed contour integrals (rays/lambert.h); of small flat groups that a few triangles hide in part, the part
/// in sight is found (rays/polygon_in_sight.h). Over a group the kernel counts as linear, with its exact integral and
/// with the slope that it has between the corners: groups are so small that the error of this is far below the noise of
/// the rays that they replace, whatever the light. With A the area, ΔK the deviation of the kernel from linear and
/// sigma that of the light within the group from its mean, this error is at most A ΔK sigma, and the noise of N
/// independent rays sigma sqrt(F/N); 64 or more even ones have that of sqrt(N)/8 times as many. It has to be far below,
/// since it is not as random as noise: kernels are often greatest where the light is.
class AnalyticFactors {
  public:
    /// `rays`: how many each point sends out. Keeps references.
    AnalyticFactors(const Mesh& mesh, const Surfels& surfels, std::size_t rays, const Execution& execution);

    const SurfelTree& tree() const { return tree_; }

    using Factor = GroupFactor;

    /// The kernel at a place.
    struct Sample {
        Vec3 place;
        double kernel;
    };

    /// Buffers of one thread.
    struct Worker {
        std::vector<std::pair<Index, bool>> open; ///< groups to look at, and whether it is known that nothing occludes
        std::size_t steps = 0; ///< all that were looked at, and the faces that may hide a part of them
        PolygonInSight sight;
        std::vector<Sample> samples; ///< of the kernel over a group
    };

    /// The groups that x sees, and how much of them; none contains another. What x sees of groups that are not among
    /// them and have no part in common with these is left to rays.
    void find(const SurfacePoint& x, std::vector<Factor>& found, Worker& worker) const;

  private:
    struct View;
    struct Linear;
    enum class Facing { away, partly, wholly };
    /// Of a patch as a point sees it.
    struct Measure {
        Facing facing = Facing::away;
        double factor = 0.0; ///< unoccluded
    };
    AnalyticFactors(const Mesh& mesh, const Surfels& surfels, const std::vector<Exposure>& exposures,
                    const std::vector<std::uint8_t>& overlaid, std::size_t rays);
    void look(const View& view, Index group, bool open, std::vector<Factor>& found, Worker& worker) const;
    Measure measure_polygon(const View& view, const SurfelTree::Node& node, std::vector<Sample>& samples) const;
    Measure measure_outline(const View& view, const SurfelTree::Node& node, std::vector<Sample>& samples) const;
    SurfacePoint along(const SurfelTree::Edge& edge, double part) const;
    static Vec3 slope_of(std::span<const Sample> samples, const Vec3& centre, double mean);
    bool stands_on(const SurfelTree::Node& node, const std::vector<Index>& faces) const;
    bool reaches_behind(const View& view, const SurfelTree::Node& node) const;
    std::optional<double> visible_factor(const View& view, const SurfelTree::Node& node, double factor,
                                         Worker& worker) const;

    const Mesh& mesh_;
    SurfelTree tree_;
    Shafts shafts_;
    BoxTree faces_;
    double rays_; ///< independent ones that have the noise of those asked for
    double rounding_;
};

} // namespace difusa
