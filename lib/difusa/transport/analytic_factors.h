// Form factors from a point to surface without rays, in closed form, where what occludes it is simple.
#pragma once

#include <difusa/rays/shaft.h>
#include <difusa/rays/visible_part.h>
#include <difusa/transport/surfel_tree.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace difusa {

/// Looks for the largest groups of surfels in sight of a point that nothing occludes (rays/shaft.h), whose form factors
/// are then closed contour integrals (rays/lambert.h); of small flat groups that a few triangles hide in part, the part
/// in sight is found (rays/visible_part.h). In place of the light of each surfel counts the mean over the group: groups
/// are small enough for the error of this to be below the noise of the rays that they replace, whatever the light. With
/// A the area, ΔK the range of the kernel over the group and sigma the deviation of the light within it, that error is
/// at most about A ΔK sigma / sqrt(12), and the noise of N independent rays sigma sqrt(F/N); 64 or more even
/// ones have that of sqrt(N)/8 times as many.
class AnalyticFactors {
  public:
    /// `rays`: how many each point sends out. Keeps references.
    AnalyticFactors(const Mesh& mesh, const Surfels& surfels, std::size_t rays, const Execution& execution);

    const SurfelTree& tree() const { return tree_; }

    /// A group of surfels and its form factor.
    using Factor = std::pair<Index, double>;

    /// Buffers of one thread.
    struct Worker {
        std::vector<std::pair<Index, bool>> open; ///< groups to look at, and whether it is known that nothing occludes
        std::size_t steps = 0; ///< all that were looked at, and the faces that may hide a part of them
        std::vector<Index> blockers;
        VisiblePart visible; ///< of a polygon
    };

    /// The groups that x sees, and how much of them; none contains another. What x sees of groups that are not among
    /// them and have no part in common with these is left to rays.
    void find(const SurfacePoint& x, std::vector<Factor>& found, Worker& worker) const;

  private:
    struct View;
    enum class Facing { away, partly, wholly };
    /// Of a patch as a point sees it.
    struct Measure {
        Facing facing = Facing::away;
        double factor = 0.0;                                                ///< unoccluded
        double least = std::numeric_limits<double>::infinity(), most = 0.0; ///< kernel, where it was looked at
    };
    AnalyticFactors(const Mesh& mesh, const Surfels& surfels, const std::vector<Exposure>& exposures,
                    const std::vector<std::uint8_t>& overlaid, std::size_t rays);
    void look(const View& view, Index group, bool open, std::vector<Factor>& found, Worker& worker) const;
    Measure measure_polygon(const View& view, const SurfelTree::Node& node) const;
    Measure measure_outline(const View& view, const SurfelTree::Node& node) const;
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
