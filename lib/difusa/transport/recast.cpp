#include <difusa/transport/recast.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/rays/few_boxes.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered_rows.h>
#include <difusa/transport/mirrored.h>
#include <difusa/transport/skylight.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace difusa {

namespace {

using Box = FewBoxes::Box;

/// Where rays are suspected of meeting something that differs.
struct Suspects {
    FewBoxes before, after; ///< marked triangles
    FewBoxes cut;           ///< surfels in place that are divided otherwise
    FewBoxes mirrors;       ///< mirrors after the motion
};

/// Boxes of regions, of those triangles for which `choose` is true.
template <class Choose> FewBoxes boxes_where(const Mesh& mesh, const Choose& choose) {
    std::vector<Box> by_region(mesh.region_count);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (choose(t)) {
            by_region[mesh.region[t]].extend(mesh.box(t));
        }
    }
    std::erase_if(by_region, [](const Box& box) { return box.isEmpty(); });
    return {std::move(by_region), mesh.magnitude()};
}

/// Around surfels on unmarked triangles that have no number.
FewBoxes boxes_of_cut(const Mesh& mesh, const Surfels& surfels, const std::vector<Index>& numbers,
                      std::span<const char> marked) {
    std::vector<Box> boxes;
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < numbers.size(); ++s) {
        if (numbers[s] != none) {
            continue;
        }
        surfels.pieces(s, pieces);
        if (marked[pieces.front().triangle] == 0) { // so are all of its pieces
            boxes.push_back(surfels.box_of_cell(s));
        }
    }
    return {std::move(boxes), mesh.magnitude()};
}

/// Updates rows, as one thread.
class RecastRows {
  public:
    struct Task {
        const LightTransport& transport;
        const GatherScene &before, &after;
        std::span<const char> marked;
        Suspects suspects;
        std::vector<Index> numbers; ///< of the surfels before: after
        bool same_numbers = false;
    };

    RecastRows(const Task& task, const DirectionPool& pool, GatheredRows& rows)
        : task_(task), rows_(rows), around_(task.after.tracer, pool), in_mirrors_(task.after.tracer) {}

    void update(std::size_t j, RecastCount& count) {
        const SurfacePoint& point = task_.after.points[j];
        if (task_.marked[point.face] != 0) {
            take_all(j, count);
            return;
        }
        around_.aim(point, j);
        suspect(point);
        if (!suspects_.empty() && !rows_.has_lists()) {
            take_all(j, count); // sums of different weights depend on their order
            return;
        }
        count.anew += suspects_.size();
        count.kept += around_.count() - suspects_.size();
        const bool only_mirrors = std::all_of(suspects_.begin(), suspects_.end(),
                                              [](const Suspect& each) { return each.why == through_mirror; });
        if (only_mirrors) { // also if there are none
            rows_.keep(j, task_.transport, task_.numbers, task_.same_numbers, scratch_);
        } else {
            cast_suspects(count);
            exchange(j);
        }
        look_into_mirrors(j, count);
    }

  private:
    enum Suspicion : std::uint8_t { through_before = 1, through_after = 2, through_cut = 4, through_mirror = 8 };

    /// What a ray before or after ends on.
    struct End {
        Hit hit;
        bool known = false;
    };
    struct Suspect {
        std::size_t ray = 0;
        std::uint8_t why = 0; ///< Suspicion
        End before, after;
    };

    void take_all(std::size_t j, RecastCount& count) {
        around_.look(task_.after.points[j], j);
        rows_.set(j, around_, scratch_);
        count.anew += around_.count();
        count.cast += around_.count();
    }

    /// Finds the suspected rays, in order.
    void suspect(const SurfacePoint& point) {
        const Suspects& all = task_.suspects;
        const Vec3& n = task_.after.tracer.mesh().normals[point.face];
        const std::array<const FewBoxes*, 4> kinds{&all.before, &all.after, &all.cut, &all.mirrors};
        const std::span<const Ray> rays = around_.rays();
        why_.assign(rays.size(), 0);
        suspects_.clear();
        bool any = false;
        for (unsigned kind = 0; kind < kinds.size(); ++kind) {
            kinds[kind]->above(point.position, n, boxes_);
            for (const Box& box : boxes_) {
                any = true;
                const BoxFrom from(box, rays.front().origin); // of all
                for (std::size_t d = 0; d < rays.size(); ++d) {
                    why_[d] |= static_cast<std::uint8_t>(from.is_met(rays[d].direction) ? 1U << kind : 0U);
                }
            }
        }
        for (std::size_t d = 0; any && d < rays.size(); ++d) {
            if (why_[d] != 0) {
                suspects_.push_back({d, why_[d], {}, {}});
            }
        }
    }

    bool is_marked(const Hit& hit) const { return hit.face != none && task_.marked[hit.face] != 0; }

    /// Casts those rays that are `wanted`.
    template <class Wanted>
    void cast(const GatherScene& scene, End Suspect::*end, const Wanted& wanted, RecastCount& count) {
        which_.clear();
        rays_.clear();
        for (Suspect& suspect : suspects_) {
            if (wanted(suspect)) {
                which_.push_back(&suspect);
                rays_.push_back(around_.rays()[suspect.ray]);
            }
        }
        hits_.resize(rays_.size());
        scene.tracer.first_hits(rays_, hits_);
        for (std::size_t i = 0; i < which_.size(); ++i) {
            which_[i]->*end = {hits_[i], true};
        }
        count.cast += rays_.size();
    }

    /// Finds the hits of suspected rays before and after. A ray that does not pass through what was marked meets the
    /// rest of the surface as it does without that, and one cast is enough.
    void cast_suspects(RecastCount& count) {
        cast(
            task_.before, &Suspect::before, [](const Suspect& each) { return (each.why & through_before) != 0; },
            count);
        cast(
            task_.after, &Suspect::after,
            [this](const Suspect& each) {
                return (each.why & through_after) != 0 ||
                       (each.before.known ? is_marked(each.before.hit) : (each.why & through_cut) != 0);
            },
            count);
        cast(
            task_.before, &Suspect::before,
            [this](const Suspect& each) { return each.after.known && !each.before.known && is_marked(each.after.hit); },
            count);
        for (Suspect& each : suspects_) {
            if (each.before.known != each.after.known) {
                (each.before.known ? each.after : each.before).hit = (each.before.known ? each.before : each.after).hit;
            }
        }
    }

    /// Where a ray ended, as a bin of the transport before.
    Index bin_before(const Suspect& suspect) const {
        const Hit& hit = suspect.before.hit;
        if (hit.face == none) {
            const auto surfels = static_cast<Index>(task_.before.surfels.size());
            return rows_.bin_of(hit, around_.rays()[suspect.ray].direction) - rows_.first_sky() + surfels;
        }
        return hit.front ? task_.before.surfels.at(hit.face, hit.u, hit.v) : none;
    }

    Index number_after(Index bin) const {
        const std::size_t surfels = task_.numbers.size();
        return bin < surfels ? task_.numbers[bin] : bin - static_cast<Index>(surfels) + rows_.first_sky();
    }

    /// Takes the hits before out of the list of point j, and puts in those after.
    void exchange(std::size_t j) {
        gone_.clear();
        come_.clear();
        for (const Suspect& each : suspects_) {
            if (!each.before.known && !each.after.known) {
                continue;
            }
            if (const Index bin = bin_before(each); bin != none) {
                gone_.push_back(bin);
            }
            if (const Index bin = rows_.bin_of(each.after.hit, around_.rays()[each.ray].direction); bin != none) {
                come_.push_back(bin);
            }
        }
        std::sort(gone_.begin(), gone_.end());
        std::sort(come_.begin(), come_.end());
        dynamic_cast<const HitLists&>(plain_part(*task_.transport.W)).row(j, kept_);
        auto next = gone_.begin();
        std::size_t left = 0;
        for (const Index bin : kept_) {
            if (next != gone_.end() && *next == bin) {
                ++next;
                continue;
            }
            const Index number = number_after(bin);
            if (number == none) {
                break;
            }
            kept_[left++] = number;
        }
        if (next != gone_.end() || left + gone_.size() != kept_.size()) {
            throw InputError("the transport is not that of the surface before the motion: the rays of point " +
                             std::to_string(j) + " end elsewhere");
        }
        kept_.resize(left);
        scratch_.bin.resize(left + come_.size());
        std::merge(kept_.begin(), kept_.end(), come_.begin(), come_.end(), scratch_.bin.begin());
        rows_.set_bins(j, scratch_.bin);
    }

    void look_into_mirrors(std::size_t j, RecastCount& count) {
        rays_.clear();
        weights_.clear();
        for (const Suspect& each : suspects_) {
            if ((each.why & through_mirror) != 0) {
                rays_.push_back(around_.rays()[each.ray]);
                weights_.push_back(around_.weights()[each.ray]);
            }
        }
        if (rays_.empty()) {
            return;
        }
        in_mirrors_.look(rays_, weights_);
        rows_.set_in_mirrors(j, in_mirrors_, scratch_);
        count.cast += rays_.size();
    }

    const Task& task_;
    GatheredRows& rows_;
    Hemisphere around_;
    ChosenRays in_mirrors_;
    GatheredRows::Scratch scratch_;
    std::vector<Box> boxes_;
    std::vector<std::uint8_t> why_; ///< of each ray: Suspicion
    std::vector<Suspect> suspects_;
    std::vector<Suspect*> which_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<double> weights_;
    std::vector<Index> gone_, come_, kept_;
};

} // namespace

LightTransport recast(const LightTransport& transport, const GatherScene& before, const GatherScene& after,
                      std::span<const char> marked, const Directions& directions, std::size_t rays, std::uint64_t seed,
                      RecastCount& count, const Execution& execution) {
    const Mesh &old_mesh = before.tracer.mesh(), &mesh = after.tracer.mesh();
    DIFUSA_REQUIRE(old_mesh.triangles.size() == mesh.triangles.size() && marked.size() == mesh.triangles.size());
    DIFUSA_REQUIRE(before.points.size() == after.points.size() && transport.points() == after.points.size());
    const DirectionPool pool(directions, rays, seed);
    const std::size_t all = after.points.size() * pool.count();
    const auto* const lists = dynamic_cast<const HitLists*>(&plain_part(*transport.W));
    const bool fits = transport.rays == all && transport.surfels == before.surfels.size() &&
                      transport.W->columns() == before.surfels.size() + SkyParts::count &&
                      (pool.equal_weights() ? lists != nullptr && lists->rays() == pool.count()
                                            : plain_part(*transport.W).entries() != nullptr);
    if (!fits) {
        throw InputError("the transport is not that of these points, rays and surfels");
    }
    if (mesh.magnitude() != old_mesh.magnitude() || mesh.repetition.any()) {
        count.anew += all;
        count.cast += all;
        return gathered(after.tracer, after.points, after.surfels, directions, rays, seed, execution);
    }
    const LightTransport by_rays = by_rays_alone(transport); // shares of rows are kept
    RecastRows::Task task{by_rays, before, after, marked, {}, before.surfels.numbers_in(after.surfels, marked)};
    const auto is_marked = [&](Index t) { return marked[t] != 0; };
    task.suspects = {boxes_where(old_mesh, is_marked), boxes_where(mesh, is_marked),
                     boxes_of_cut(old_mesh, before.surfels, task.numbers, marked),
                     boxes_where(mesh, [&](Index t) { return mesh.mirrors.kind(t) != none; })};
    task.same_numbers = before.surfels.size() == after.surfels.size();
    for (Index s = 0; s < task.numbers.size() && task.same_numbers; ++s) {
        task.same_numbers = task.numbers[s] == s || task.numbers[s] == none; // what has none is in no row that is kept
    }
    const SkyBins sky{SkyParts::count, SkyParts::at};
    const std::size_t grain = lists != nullptr ? lists->rows_per_block() : 16;
    GatheredRows rows(after.tracer, after.points, after.surfels, sky, pool, grain);
    std::vector<RecastCount> counts((after.points.size() + grain - 1) / grain);
    parallel_for(after.points.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        RecastRows update(task, pool, rows);
        for (std::size_t j = begin; j < end; ++j) {
            update.update(j, counts[begin / grain]);
        }
        rows.close_block(begin);
    });
    for (const RecastCount& each : counts) {
        count.anew += each.anew;
        count.kept += each.kept;
        count.cast += each.cast;
    }
    return rows.finish();
}

} // namespace difusa
