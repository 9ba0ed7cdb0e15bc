#include <difusa/rays/unfolded_visibility.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace difusa {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Orthonormal directions that complete the given ones to three.
std::vector<Vec3> complement(const std::vector<Vec3>& given) {
    std::vector<Vec3> all = given, others;
    while (all.size() < 3) {
        Vec3 best = Vec3::Zero();
        for (int k = 0; k < 3; ++k) {
            Vec3 candidate = Vec3::Unit(k);
            for (const Vec3& known : all) {
                candidate -= known.dot(candidate) * known;
            }
            best = candidate.squaredNorm() > best.squaredNorm() + 1e-9 ? candidate : best;
        }
        all.push_back(best.normalized());
        others.push_back(all.back());
    }
    return others;
}

} // namespace

/// A straight way through the unfolded surface, as it is seen in the cell it has come to.
struct UnfoldedVisibility::Way {
    Vec3 origin, direction;
    double leaves = infinity; ///< t beyond which it meets nothing
};

void UnfoldedVisibility::build(const Mesh& mesh) {
    engine_->build(mesh);
    mesh_ = &mesh;
    rounding_ = 0x1p-44 * mesh.magnitude();
    const double slack = 1e-5 * mesh.diameter();
    const std::vector<Repetition::Image> images = mesh.repetition.images(0);
    extents_.clear();
    for (const Vec3& direction : complement(mesh.repetition.endless)) {
        Extent extent{direction, infinity, -infinity};
        for (const Repetition::Image& image : images) {
            const Vec3 along = image.linear.transpose() * direction;
            const double centre = along.dot(0.5 * (mesh.low + mesh.high)) + direction.dot(image.offset);
            const double half = 0.5 * along.cwiseAbs().dot(mesh.high - mesh.low);
            extent.low = std::min(extent.low, centre - half - slack);
            extent.high = std::max(extent.high, centre + half + slack);
        }
        extents_.push_back(extent);
    }
}

bool UnfoldedVisibility::is_outside(const Vec3& p) const {
    const auto& walls = mesh_->repetition.walls;
    return std::any_of(walls.begin(), walls.end(),
                       [&](const Repetition::Wall& wall) { return wall.height(p) < -rounding_; });
}

/// `on_face`: it starts in the cell, whatever rounding says.
UnfoldedVisibility::Way UnfoldedVisibility::way_from(const Vec3& origin, const Vec3& direction, bool on_face) const {
    Way way{origin, direction};
    for (const Extent& extent : extents_) {
        const double at = extent.direction.dot(origin), speed = extent.direction.dot(direction);
        if (speed != 0.0) {
            way.leaves = std::min(way.leaves, ((speed > 0.0 ? extent.high : extent.low) - at) / speed);
        } else if (at < extent.low || at > extent.high) {
            way.leaves = -infinity;
        }
    }
    constexpr int most = 1 << 16; // far outside: it comes to the cell on its way, or not at all
    for (int k = 0; k < most && !on_face && is_outside(way.origin); ++k) {
        for (const Repetition::Wall& wall : mesh_->repetition.walls) {
            if (wall.height(way.origin) < -rounding_) {
                way.origin = wall.back(way.origin);
                way.direction = wall.turned(way.direction);
            }
        }
    }
    return way;
}

/// Calls `visit(way, cell, until)` in one cell after another, 0, 1, ..., until it returns true; `until`: t at which the
/// way passes a wall, infinite if it meets nothing in later cells. False if it was cut off.
template <class Visit> bool UnfoldedVisibility::walk(Way way, const Visit& visit) const {
    double t = 0.0;
    for (std::size_t cell = 0; cell <= most_walls; ++cell) {
        const Repetition::Wall* passed = nullptr;
        double until = infinity;
        for (const Repetition::Wall& wall : mesh_->repetition.walls) {
            const double rises = wall.normal.dot(way.direction);
            if (rises < 0.0) {
                const double at = std::max(t, -wall.height(way.origin) / rises);
                if (at < until) {
                    until = at;
                    passed = &wall;
                }
            }
        }
        const bool last = !(until < way.leaves);
        if (visit(way, cell, last ? infinity : until) || last) {
            return true;
        }
        t = until;
        way.origin = passed->back(way.origin);
        way.direction = passed->turned(way.direction);
    }
    return false;
}

/// `from_here`: the cell where it starts, too.
Hit UnfoldedVisibility::first_hit_beyond(const Ray& ray, bool from_here) const {
    Hit hit;
    const bool ends = walk(way_from(ray.origin, ray.direction, ray.face != none),
                           [&](const Way& way, std::size_t cell, double /*until*/) {
                               if (cell == 0 && !from_here) {
                                   return false;
                               }
                               const Ray part{way.origin, way.direction, none};
                               engine_->first_hits({&part, 1}, {&hit, 1});
                               return hit.face != none;
                           });
    hit.cut_off = !ends;
    return hit;
}

void UnfoldedVisibility::first_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    engine_->first_hits(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const bool elsewhere = rays[i].face == none && is_outside(rays[i].origin);
        if (elsewhere || hits[i].face == none) {
            hits[i] = first_hit_beyond(rays[i], elsewhere);
        }
    }
}

bool UnfoldedVisibility::is_blocked(const Segment& segment) const {
    std::uint8_t blocked = 0;
    const Vec3 direction = segment.to - segment.from;
    const Way start = way_from(segment.from, direction, segment.from_face != none);
    // A face in a wall ends the segments to it in either of the cells that it bounds.
    const double end = 1.0 - 4.0 * rounding_ / std::max(direction.norm(), 4.0 * rounding_);
    const bool ends = walk(start, [&](const Way& way, std::size_t cell, double until) {
        const bool last = !(until < end);
        const Segment part{way.origin, way.origin + way.direction, cell == 0 ? segment.from_face : none,
                           last ? segment.to_face : none};
        engine_->occluded({&part, 1}, {&blocked, 1});
        return blocked != 0 || last;
    });
    return blocked != 0 || !ends;
}

void UnfoldedVisibility::occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
        blocked[i] = is_blocked(segments[i]) ? 1 : 0;
    }
}

std::shared_ptr<Visibility> built_over(const Mesh& mesh, std::shared_ptr<Visibility> engine) {
    if (mesh.repetition.any()) {
        engine = std::make_shared<UnfoldedVisibility>(std::move(engine));
    }
    engine->build(mesh);
    return engine;
}

} // namespace difusa
