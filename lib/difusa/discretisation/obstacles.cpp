#include <difusa/discretisation/obstacles.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace difusa {

namespace {

using Box = BoxTree::Box;

/// Looks for points of a region, and of what is lifted off it, on both sides of a triangle's plane.
class Sides {
  public:
    Sides(const Mesh& mesh, Index plane, const SightReach& reach, double rounding)
        : mesh_(mesh), normal_(mesh.normals[plane]), foot_(mesh.corner(plane, 0)), rounding_(rounding) {
        const bool flat = reach.plane != none;
        const double up = reach.lift * (flat ? normal_.dot(mesh.normals[reach.plane]) : 1.0);
        low_ = flat ? std::min(up, 0.0) : -up;
        high_ = std::max(up, 0.0);
    }

    bool both() const { return below_ && above_; }

    /// False if nothing in the box adds to what is known.
    bool matters(const Box& box) const {
        const double middle = normal_.dot(box.center() - foot_), half = 0.5 * normal_.cwiseAbs().dot(box.sizes());
        return (!below_ && middle - half + low_ < -rounding_) || (!above_ && middle + half + high_ > rounding_);
    }

    void see(Index triangle) {
        for (int k = 0; k < 3; ++k) {
            const double height = normal_.dot(mesh_.corner(triangle, k) - foot_);
            below_ = below_ || height + low_ < -rounding_;
            above_ = above_ || height + high_ > rounding_;
        }
    }

  private:
    const Mesh& mesh_;
    const Vec3 &normal_, &foot_;
    double rounding_, low_ = 0.0, high_ = 0.0;
    bool below_ = false, above_ = false;
};

/// True if no point of triangle F is between the plane of a flat region and that of what is lifted off it.
bool is_off(const Mesh& mesh, Index F, const SightReach& reach, double rounding) {
    const Vec3 &normal = mesh.normals[reach.plane], &foot = mesh.corner(reach.plane, 0);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int k = 0; k < 3; ++k) {
        const double height = normal.dot(mesh.corner(F, k) - foot);
        low = std::min(low, height);
        high = std::max(high, height);
    }
    return high < -rounding || low > reach.lift + rounding;
}

} // namespace

std::vector<Index> planes_of_regions(const Mesh& mesh, const RegionTrees& trees, double rounding) {
    std::vector<Index> planes(mesh.region_count, none);
    for (Index region = 0; region < mesh.region_count; ++region) {
        const std::span<const Index> members = trees.members(region);
        const auto largest = std::max_element(members.begin(), members.end(),
                                              [&](Index s, Index t) { return mesh.areas[s] < mesh.areas[t]; });
        const Vec3 &normal = mesh.normals[*largest], &foot = mesh.corner(*largest, 0);
        const bool flat = std::all_of(members.begin(), members.end(), [&](Index t) {
            const auto near = [&](int k) { return std::abs(normal.dot(mesh.corner(t, k) - foot)) <= rounding; };
            return near(0) && near(1) && near(2);
        });
        planes[region] = flat ? *largest : none;
    }
    return planes;
}

std::vector<char> closed_regions(const Mesh& mesh) {
    std::vector<char> closed(mesh.region_count, 1);
    for (std::size_t side = 0; side < mesh.twin.size(); ++side) {
        const Index region = mesh.region[side / 3], twin = mesh.twin[side];
        if (twin == none || mesh.region[twin / 3] != region) {
            closed[region] = 0;
        }
    }
    return closed;
}

Obstacles::Obstacles(const Mesh& mesh, std::shared_ptr<const RegionTrees> trees, std::vector<SightReach> reach,
                     double rounding)
    : mesh_(mesh), trees_(std::move(trees)), reach_(std::move(reach)), rounding_(rounding) {}

bool Obstacles::may_obstruct(Index F, Index region) const {
    const SightReach& here = reach_[region];
    const Box own = mesh_.box(F), &whole = trees_->box(region);
    // Lines of sight stay in the box of the region, but for the lift of their ends.
    if (!(here.around > 0.0) || !own.intersects(grown(whole, here.lift + rounding_))) {
        return false;
    }
    Sides sides(mesh_, F, here, rounding_);
    if (!sides.matters(whole) || (here.plane != none && is_off(mesh_, F, here, rounding_))) {
        return false;
    }
    const Box near = grown(own, here.around);
    trees_->triangles(region).visit_where([&](const Box& box) { return box.intersects(near) && sides.matters(box); },
                                          [&](Index T) {
                                              sides.see(T);
                                              return sides.both();
                                          });
    return sides.both();
}

bool Obstacles::any(Index region) const {
    const Box around = grown(trees_->box(region), reach_[region].lift + rounding_);
    return visit_others(
        region, [&](const Box& box) { return box.intersects(around); },
        [&](Index T) { return may_obstruct(T, region); });
}

bool FoldSearch::unfolded(const SurfacePoint& p, double radius) {
    const Index region = mesh_.region[p.face];
    const auto within = [&](const Box& box) { return box.squaredExteriorDistance(p.position) < radius * radius; };
    std::size_t count = 0;
    const bool turned = trees_.triangles(region).visit_where(within, [&](Index T) {
        ++count;
        return mesh_.normals[T].dot(p.normal) <= perpendicular;
    });
    if (turned) {
        return false;
    }
    if (++search_ == 0) {
        std::fill(seen_.begin(), seen_.end(), 0);
        search_ = 1;
    }
    std::size_t reached = 0;
    open_.assign(1, p.face);
    seen_[p.face] = search_;
    while (!open_.empty()) {
        const std::size_t T = open_.back();
        open_.pop_back();
        ++reached;
        for (std::size_t side = 3 * T; side < 3 * T + 3; ++side) {
            const Index next = mesh_.twin[side] == none ? none : mesh_.twin[side] / 3;
            if (next != none && mesh_.region[next] == region && seen_[next] != search_ && within(mesh_.box(next))) {
                seen_[next] = search_;
                open_.push_back(next);
            }
        }
    }
    return reached == count;
}

} // namespace difusa
