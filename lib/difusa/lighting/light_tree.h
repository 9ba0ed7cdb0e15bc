// A tree over many small lights, so that evaluating all of them at a point costs about the logarithm of their number
// (after Walter et al., "Lightcuts", 2005, and Conty Estevez and Kulla, "Importance Sampling of Many Lights with
// Adaptive Tree Splitting", 2018).
#pragma once

#include <difusa/core/random.h>
#include <difusa/mesh/mesh.h>

#include <optional>
#include <span>
#include <vector>

namespace difusa {

/// Triangles that emit from their fronts. Each node summarises the light of all triangles below it.
class LightTree {
  public:
    /// `power[i]` > 0 belongs to triangles[i]. Keeps a reference to the mesh.
    LightTree(const Mesh& mesh, std::span<const Index> triangles, std::span<const double> power);

    /// A randomly chosen light: its index in `triangles`, and the probability of the choice.
    struct Pick {
        Index light = none;
        double probability = 0.0;
    };

    /// Writes nodes that together hold every light that can reach a surface element at x with normal n, each exactly
    /// once: a single light, or several in a ball that x sees under an angle (diameter over distance of the centre)
    /// below `opening`.
    void cut(const Vec3& x, const Vec3& n, double opening, std::vector<Index>& nodes) const;

    /// A light that stands for `weight` lights like it; 1: for itself alone.
    struct Representative {
        Index light = none; ///< index in `triangles`
        double weight = 0.0;
    };

    /// A part of the tree that is still to be represented, and the interval of picks that falls to it.
    struct Part {
        Index node = none;
        double begin = 0.0, end = 0.0;
    };

    /// Lights whose weighted contributions to a surface element at x with normal n add up, in the mean, to those of all
    /// lights. The nodes of a cut share about `count` picks, at least one each, in proportion to what x can receive
    /// from them; so do the nodes below. Where the picks are as many as the lights, these stand for themselves, and
    /// nothing is left to chance. Picks are evenly spaced along the tree. `scratch`, `parts`: scratch.
    void represent(const Vec3& x, const Vec3& n, double opening, double count, RandomStream& stream,
                   std::vector<Index>& scratch, std::vector<Part>& parts, std::vector<Representative>& chosen) const;

    /// Chooses a light of the node, roughly in proportion to what x can receive from it, with the random number u in
    /// [0, 1). Every light that can reach x has a positive probability; with the remaining probability nothing is
    /// chosen: the search ended among lights that cannot reach x.
    std::optional<Pick> pick(Index node, const Vec3& x, const Vec3& n, double u) const;

    static constexpr Index root = 0;

  private:
    struct Node {
        Vec3 centre = Vec3::Zero(); ///< of a bounding ball of the lights
        double radius = 0.0;
        Vec3 axis = Vec3::Zero();                  ///< of a bounding cone of their normals
        double cos_spread = 1.0, sin_spread = 0.0; ///< of its half angle
        double power = 0.0;
        Index first = 0, last = 0; ///< range of lights in `order_`
        Index right = none;        ///< none: a leaf of one light; the left child follows its parent
    };

    Index build(const Mesh& mesh, std::span<const Index> triangles, std::span<const double> power, Index first,
                Index last);
    double importance(const Node& node, const Vec3& x, const Vec3& n) const;

    std::vector<Node> nodes_;
    std::vector<Index> order_; ///< the lights, those of a node being contiguous
};

} // namespace difusa
