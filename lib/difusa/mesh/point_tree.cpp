#include <difusa/mesh/point_tree.h>

#include <difusa/core/error.h>

#include <nanoflann.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

/// The points in the interface nanoflann expects.
struct PointCloud {
    std::span<const SurfacePoint> points;
    std::vector<Index> members;

    std::size_t kdtree_get_point_count() const { return members.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const {
        return points[members[i]].position[static_cast<Eigen::Index>(axis)];
    }
    template <class Box> bool kdtree_get_bbox(Box& /*box*/) const { return false; }
};

/// What a search for the lower envelope keeps, as nanoflann asks: a point counts as far as it may lower the least.
class LowestCone {
  public:
    using DistanceType = double;

    /// `any`: the first point that lowers it is enough.
    LowestCone(std::span<const Index> members, std::span<const double> value, double smallest, double slope,
               double most, bool any = false)
        : members_(members), value_(value), smallest_(smallest), slope_(slope), least_(most), any_(any) {
        reach();
    }

    double least() const { return least_; }

    std::size_t size() const { return 1; }
    bool full() const { return true; }
    double worstDist() const { return farthest_; }
    bool addPoint(double squared_distance, Index point) {
        if (const double height = value_[members_[point]] + slope_ * std::sqrt(squared_distance); height < least_) {
            least_ = height;
            reach();
            return !any_; // false ends the search
        }
        return true;
    }

  private:
    void reach() {
        const double far = std::max(0.0, least_ - smallest_) / slope_;
        farthest_ = far * far;
    }

    std::span<const Index> members_;
    std::span<const double> value_;
    double smallest_, slope_, least_, farthest_ = 0.0;
    bool any_;
};

std::vector<Index> numbers_to(std::size_t count) {
    std::vector<Index> numbers(count);
    std::iota(numbers.begin(), numbers.end(), Index{0});
    return numbers;
}

} // namespace

struct PointTree::Tree {
    Tree(std::span<const SurfacePoint> points, std::vector<Index> members)
        : cloud{points, std::move(members)}, index(3, cloud) {}

    PointCloud cloud;
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>, PointCloud, 3> index;
};

PointTree::PointTree(std::span<const SurfacePoint> points, std::vector<Index> members)
    : tree_(std::make_unique<Tree>(points, std::move(members))) {}

PointTree::PointTree(std::span<const SurfacePoint> points) : PointTree(points, numbers_to(points.size())) {}

PointTree::~PointTree() = default;
PointTree::PointTree(PointTree&&) noexcept = default;
PointTree& PointTree::operator=(PointTree&&) noexcept = default;

std::size_t PointTree::size() const {
    return tree_->cloud.members.size();
}

std::size_t PointTree::nearest(const Vec3& p, std::span<Index> numbers, std::span<double> squared) const {
    const std::size_t room = std::min({numbers.size(), squared.size(), size()});
    if (room == 0) {
        return 0; // nanoflann always writes to the last entry
    }
    const std::size_t count = tree_->index.knnSearch(p.data(), room, numbers.data(), squared.data());
    for (Index& number : numbers.first(count)) {
        number = tree_->cloud.members[number];
    }
    return count;
}

double PointTree::envelope(const Vec3& p, std::span<const double> value, double smallest, double slope,
                           double most) const {
    LowestCone lowest(tree_->cloud.members, value, smallest, slope, most);
    if (size() > 0) {
        tree_->index.findNeighbors(lowest, p.data(), nanoflann::SearchParams());
    }
    return lowest.least();
}

double PointTree::first_below(const Vec3& p, std::span<const double> value, double smallest, double slope,
                              double limit) const {
    LowestCone lowest(tree_->cloud.members, value, smallest, slope, limit, true);
    if (size() > 0 && smallest < limit) {
        tree_->index.findNeighbors(lowest, p.data(), nanoflann::SearchParams());
    }
    return lowest.least();
}

Index PointTree::nearest(const Vec3& p) const {
    DIFUSA_REQUIRE(size() > 0);
    Index number = none;
    double squared = 0.0;
    nearest(p, std::span(&number, 1), std::span(&squared, 1));
    return number;
}

} // namespace difusa
