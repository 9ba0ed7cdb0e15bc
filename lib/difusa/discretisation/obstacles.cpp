#include <difusa/discretisation/obstacles.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

using Box = BoxTree::Box;

/// Looks for points of a region, and of what is lifted off it, on both sides of a triangle's plane.
class Sides {
  public:
    /// `member`: of the region.
    Sides(const Mesh& mesh, Index plane, Index member, const SightReach& reach, double rounding)
        : mesh_(mesh), normal_(mesh.normals[plane]), foot_(mesh.corner(plane, 0)), rounding_(rounding) {
        const double up = reach.lift * (reach.flat ? normal_.dot(mesh.normals[member]) : 1.0);
        low_ = reach.flat ? std::min(up, 0.0) : -up;
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

} // namespace

std::vector<char> flat_regions(const Mesh& mesh, const RegionTrees& trees, double rounding) {
    std::vector<char> flat(mesh.region_count, 1);
    for (Index region = 0; region < mesh.region_count; ++region) {
        const std::span<const Index> members = trees.members(region);
        const auto largest = std::max_element(members.begin(), members.end(),
                                              [&](Index s, Index t) { return mesh.areas[s] < mesh.areas[t]; });
        const Vec3 &normal = mesh.normals[*largest], &foot = mesh.corner(*largest, 0);
        for (const Index t : members) {
            for (int k = 0; k < 3; ++k) {
                if (std::abs(normal.dot(mesh.corner(t, k) - foot)) > rounding) {
                    flat[region] = 0;
                }
            }
        }
    }
    return flat;
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

std::vector<std::vector<Index>> find_obstacles(const Mesh& mesh, const RegionTrees& trees,
                                               std::span<const SightReach> reach, double rounding,
                                               const Execution& execution) {
    std::vector<std::vector<Index>> found(mesh.region_count);
    double highest = 0.0;
    for (const SightReach& each : reach) {
        highest = std::max(highest, each.lift + rounding);
    }
    if (mesh.region_count < 2 || mesh.convex) {
        return found;
    }
    const auto obstructed_by = [&](Index F, std::vector<Index>& regions) {
        const Box own = mesh.box(F);
        trees.regions().visit(grown(own, highest), [&](Index region, const Box& whole) {
            const SightReach& here = reach[region];
            // Lines of sight stay in the box of the region, but for the lift of their ends.
            if (region == mesh.region[F] || !(here.around > 0.0) ||
                !own.intersects(grown(whole, here.lift + rounding))) {
                return false;
            }
            const Box near = grown(own, here.around);
            Sides sides(mesh, F, trees.members(region)[0], here, rounding);
            if (!sides.matters(whole)) {
                return false;
            }
            trees.triangles(region).visit_where(
                [&](const Box& box) { return box.intersects(near) && sides.matters(box); },
                [&](Index T) {
                    sides.see(T);
                    return sides.both();
                });
            if (sides.both()) {
                regions.push_back(region);
            }
            return false;
        });
    };
    for (const auto& [region, triangle] : regions_by_triangle(mesh, obstructed_by, execution)) {
        found[region].push_back(triangle);
    }
    return found;
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
