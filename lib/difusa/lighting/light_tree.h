// A tree over many small lights, so that what a point receives from all of them costs about the logarithm of their
// number (after Walter et al., "Lightcuts", 2005, and Conty Estevez and Kulla, "Importance Sampling of Many Lights with
// Adaptive Tree Splitting", 2018).
#pragma once

#include <difusa/mesh/mesh.h>

#include <optional>
#include <span>
#include <vector>

namespace difusa {

/// Triangles that emit from their fronts. Nodes hold the light of all triangles below them.
class LightTree {
  public:
    /// `power[i]` > 0 belongs to triangles[i]. Keeps a reference to the mesh.
    LightTree(const Mesh& mesh, std::span<const Index> triangles, std::span<const double> power);

    /// A light chosen at random: its place in `triangles`, and with which probability it was chosen.
    struct Pick {
        Index light = none;
        double probability = 0.0;
    };

    /// Writes nodes that together hold every light which can reach a surface element at x with normal n, each once: a
    /// single light, or several in a ball that x sees under an angle (diameter over distance of the centre) below
    /// `opening`.
    void cut(const Vec3& x, const Vec3& n, double opening, std::vector<Index>& nodes) const;

    /// Chooses a light of the node, about in proportion to what x can receive from it, with the random number u in
    /// [0, 1). Each that can reach x has a positive probability; with what is left to 1 nothing is chosen: the search
    /// ended among lights that cannot.
    std::optional<Pick> pick(Index node, const Vec3& x, const Vec3& n, double u) const;

    static constexpr Index root = 0;

  private:
    struct Node {
        Vec3 centre = Vec3::Zero(); ///< of a ball around the lights
        double radius = 0.0;
        Vec3 axis = Vec3::Zero(); ///< of a cone around their normals
        double spread = 0.0;      ///< half its angle
        double power = 0.0;
        Index first = 0, last = 0; ///< lights, in `order_`
        Index right = none;        ///< none: a leaf of one light; the left child follows its parent
    };

    Index build(const Mesh& mesh, std::span<const Index> triangles, std::span<const double> power, Index first,
                Index last);
    double importance(const Node& node, const Vec3& x, const Vec3& n) const;

    std::vector<Node> nodes_;
    std::vector<Index> order_; ///< the lights, such that those of a node are neighbours
};

} // namespace difusa
