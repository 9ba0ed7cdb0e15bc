#include <difusa/discretisation/site_grid.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace difusa {

namespace {

constexpr std::size_t darts_at_once = 1024;
constexpr double least_steps = 64.0; ///< the least spacing, in steps of the coordinates

enum class State : char { waiting, accepted, rejected };

bool comes_before(std::span<const Dart> darts, Index i, Index j) {
    return darts[i].priority != darts[j].priority ? darts[i].priority < darts[j].priority : i < j;
}

} // namespace

double coordinate_step(const Mesh& mesh) {
    const double most = mesh.magnitude();
    return std::nextafter(most, std::numeric_limits<double>::infinity()) - most;
}

SiteGrid::SiteGrid(const Mesh& mesh, double spacing, std::size_t limit)
    : mesh_(mesh), spacing_(spacing), limit_(limit), hash_(mesh.low, spacing) {
    if (!(mesh.diameter() / (2.0 * spacing) < 0x1p30)) {
        throw ResourceError("a spacing of " + text_of(spacing) + " is too small for a scene of diameter " +
                            text_of(mesh.diameter()) + "; give a larger --spacing");
    }
    if (const double step = coordinate_step(mesh); !(spacing > least_steps * step)) {
        throw InputError("the scene is so far from the origin that its coordinates, up to " +
                         text_of(mesh.magnitude()) + ", are known to " + text_of(step) +
                         " only, too coarse for sites " + text_of(spacing) +
                         " apart: move it to the origin, or give a larger --spacing");
    }
}

bool SiteGrid::too_close(const SurfacePoint& x, Index region, const SpatialHash::Item& other) const {
    // Site distance is never below the Euclidean distance; most points are already too far by that.
    return (x.position - other.position).squaredNorm() <= (1.0 + 1e-9) * spacing_ * spacing_ &&
           site_distance(x.position, x.normal, region, other.position, mesh_.normals[other.face],
                         mesh_.region[other.face]) < spacing_;
}

bool SiteGrid::conflicts(const SurfacePoint& x) const {
    const Index region = mesh_.region[x.face];
    return hash_.any_near(x.position, region,
                          [&](Index, const SpatialHash::Item& site) { return too_close(x, region, site); });
}

bool SiteGrid::covers(Index face, const std::array<Vec3, 3>& corners) const {
    // A site that covers the piece is within the spacing of its first corner.
    const Index region = mesh_.region[face];
    const Vec3& normal = mesh_.normals[face];
    const double farthest = spacing_ * spacing_;
    return hash_.any_near(corners[0], region, [&](Index, const SpatialHash::Item& site) {
        const double squared =
            std::max({(corners[0] - site.position).squaredNorm(), (corners[1] - site.position).squaredNorm(),
                      (corners[2] - site.position).squaredNorm()});
        if (squared > farthest || mesh_.region[site.face] != region) {
            return false;
        }
        const double cosine = mesh_.normals[site.face].dot(normal);
        const double reach = spacing_ * cosine;
        return cosine > perpendicular && squared <= reach * reach;
    });
}

void SiteGrid::insert(std::span<const Dart> darts, const Execution& execution) {
    std::vector<Index> waiting(darts.size());
    std::iota(waiting.begin(), waiting.end(), Index{0});
    while (!waiting.empty()) {
        waiting = without_conflict(darts, std::move(waiting), execution);
        std::vector<Index> lot = waiting;
        SpatialHash hash = hash_of(darts, lot, execution);
        // Where darts are dense, each conflicts with many: the first few usually decide about the others.
        constexpr double crowded = 16.0;
        const double crowd = hash.crowding();
        if (crowd > crowded) {
            const auto before = [&](Index i, Index j) { return comes_before(darts, i, j); };
            const auto few = static_cast<std::size_t>(0.5 * crowded / crowd * static_cast<double>(lot.size())) + 1;
            const auto end = lot.begin() + static_cast<std::ptrdiff_t>(std::min(few, lot.size()));
            std::nth_element(lot.begin(), end - 1, lot.end(), before);
            const Index last = *(end - 1);
            lot = waiting;
            std::erase_if(lot, [&](Index i) { return before(last, i); });
            std::erase_if(waiting, [&](Index i) { return !before(last, i); });
            hash = hash_of(darts, lot, execution);
        } else {
            waiting.clear();
        }
        accept(darts, first_come(darts, lot, hash, execution), execution);
    }
}

SpatialHash SiteGrid::hash_of(std::span<const Dart> darts, std::span<const Index> of,
                              const Execution& execution) const {
    SpatialHash hash(mesh_.low, spacing_);
    append(darts, of, hash, execution);
    return hash;
}

void SiteGrid::append(std::span<const Dart> darts, std::span<const Index> of, SpatialHash& hash,
                      const Execution& execution) const {
    hash.append(
        of.size(),
        [&](std::size_t k) {
            const SurfacePoint& x = darts[of[k]].place;
            return SpatialHash::Item{x.position, x.face, none};
        },
        [&](Index face) { return mesh_.region[face]; }, execution);
}

std::vector<Index> SiteGrid::without_conflict(std::span<const Dart> darts, std::vector<Index> of,
                                              const Execution& execution) const {
    parallel_for(of.size(), darts_at_once, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t k = begin; k < end; ++k) {
            of[k] = conflicts(darts[of[k]].place) ? none : of[k];
        }
    });
    std::erase(of, none);
    return of;
}

std::vector<Index> SiteGrid::first_come(std::span<const Dart> darts, std::span<const Index> of, const SpatialHash& hash,
                                        const Execution& execution) const {
    // A dart is rejected once an earlier dart in conflict with it is accepted, and accepted once all of those are
    // rejected. The first pending dart can always be decided, so this terminates; and the outcome does not depend on
    // when each is decided, so it does not matter which decisions of other threads are visible.
    std::vector<State> state(of.size(), State::waiting);
    const auto decide = [&](Index k) {
        const SurfacePoint& x = darts[of[k]].place;
        const Index region = mesh_.region[x.face];
        bool waits = false;
        const bool rejected = hash.any_near(x.position, region, [&](Index other, const SpatialHash::Item& item) {
            if (!comes_before(darts, of[other], of[k])) {
                return false;
            }
            const State its = std::atomic_ref<State>(state[other]).load(std::memory_order_relaxed);
            if (its == State::rejected || !too_close(x, region, item)) {
                return false;
            }
            waits = waits || its == State::waiting;
            return its == State::accepted;
        });
        if (rejected || !waits) {
            std::atomic_ref<State>(state[k]).store(rejected ? State::rejected : State::accepted,
                                                   std::memory_order_relaxed);
        }
    };
    std::vector<Index> waiting(of.size());
    std::iota(waiting.begin(), waiting.end(), Index{0});
    while (!waiting.empty()) {
        parallel_for(waiting.size(), darts_at_once, execution.silent(),
                     [&](std::size_t begin, std::size_t end, unsigned) {
                         for (std::size_t i = begin; i < end; ++i) {
                             decide(waiting[i]);
                         }
                     });
        std::erase_if(waiting, [&](Index k) { return state[k] != State::waiting; });
    }
    std::vector<Index> accepted;
    for (std::size_t k = 0; k < of.size(); ++k) {
        if (state[k] == State::accepted) {
            accepted.push_back(of[k]);
        }
    }
    return accepted;
}

void SiteGrid::accept(std::span<const Dart> darts, std::span<const Index> of, const Execution& execution) {
    if (sites_.size() + of.size() > limit_) {
        throw ResourceError("more than " + std::to_string(limit_) + " sites are needed at spacing " +
                            text_of(spacing_) +
                            ", for which memory does not suffice; give a larger --spacing, or fewer "
                            "--sites");
    }
    for (const Index i : of) {
        sites_.push_back(darts[i].place);
    }
    append(darts, of, hash_, execution);
}

} // namespace difusa
