// Nearest neighbours among points of a surface, by Euclidean distance.
#pragma once

#include <difusa/mesh/mesh.h>

#include <memory>
#include <span>
#include <vector>

namespace difusa {

class PointTree {
  public:
    /// A tree of the points with the numbers `members`. `points` must outlive the tree.
    PointTree(std::span<const SurfacePoint> points, std::vector<Index> members);

    /// A tree of all points.
    explicit PointTree(std::span<const SurfacePoint> points);

    ~PointTree();
    PointTree(PointTree&&) noexcept;
    PointTree& operator=(PointTree&&) noexcept;

    std::size_t size() const;

    /// Fills in the numbers of the points nearest to p and their squared distances, nearest first: as many as `numbers`
    /// and `squared` have room for, but no more than there are. Returns how many; the remaining entries are left
    /// unchanged.
    std::size_t nearest(const Vec3& p, std::span<Index> numbers, std::span<double> squared) const;

    /// The number of the nearest point; the tree must not be empty.
    Index nearest(const Vec3& p) const;

    /// The least of `most` and of value_j + slope |p - p_j| over the points: the lower envelope of cones on them.
    /// `value`: by number, none below `smallest`, which is what far points are left out by. `slope` > 0.
    double envelope(const Vec3& p, std::span<const double> value, double smallest, double slope, double most) const;

    /// The height at p of the first of these cones that a search finds below `limit`; `limit` if none is, up to
    /// rounding.
    double first_below(const Vec3& p, std::span<const double> value, double smallest, double slope, double limit) const;

  private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

} // namespace difusa
