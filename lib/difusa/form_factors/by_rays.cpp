#include <difusa/form_factors/by_rays.h>

#include <difusa/core/error.h>
#include <difusa/core/even_sequence.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/mesh/surface_sampling.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace difusa {

namespace {

/// Hits of the rays of one surface. Scratch of one thread.
class RayCount {
  public:
    RayCount(const Tracer& tracer, const Surfaces& surfaces, const DirectionPool& pool, std::uint64_t seed)
        : tracer_(tracer), surfaces_(surfaces), seed_(seed), hemisphere_(tracer, pool), now_(surfaces.size(), 0.0),
          sum_(surfaces.size(), 0.0), squares_(surfaces.size(), 0.0), seen_(surfaces.size(), 0) {}

    /// Adds triangle t, which is `share` of its surface.
    void add(Index t, std::size_t points, double share) {
        const Mesh& mesh = tracer_.mesh();
        // Shifted at random for each triangle: the errors of those of one surface average out.
        RandomStream stream(seed_, "form factor points", t);
        const double shift_u = stream.uniform(), shift_v = stream.uniform();
        for (std::size_t k = 0; k < points; ++k) {
            const auto [u, v] = even_point<2>(k, {shift_u, shift_v});
            hemisphere_.look(uniform_point(mesh, t, u, v), t * points + k);
            std::vector<Index> met;
            hemisphere_.for_each(
                [&](const Hit& hit, double weight) {
                    const Index j = surfaces_.of[hit.face];
                    if (now_[j] == 0.0) {
                        met.push_back(j);
                    }
                    now_[j] += weight;
                },
                [](const Vec3&, double) {});
            for (const Index j : met) {
                if (seen_[j] == 0) {
                    seen_[j] = 1;
                    touched_.push_back(j);
                }
                moments_.emplace_back(j, now_[j]);
                now_[j] = 0.0;
            }
        }
        // Of each surface: mean over the points, and the variance of that mean; a point that does not see it counts 0.
        std::stable_sort(moments_.begin(), moments_.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        const auto n = static_cast<double>(points);
        for (std::size_t e = 0; e < moments_.size();) {
            const Index j = moments_[e].first;
            double first = 0.0, second = 0.0;
            for (; e < moments_.size() && moments_[e].first == j; ++e) {
                first += moments_[e].second;
                second += moments_[e].second * moments_[e].second;
            }
            sum_[j] += share * first / n;
            squares_[j] += share * share * std::max(0.0, second - first * first / n) / (n * (n - 1.0));
        }
        moments_.clear();
    }

    void take(FormFactors::Row& row) {
        std::sort(touched_.begin(), touched_.end());
        for (const Index j : touched_) {
            row.column.push_back(j);
            row.factor.push_back(sum_[j]);
            row.error.push_back(static_cast<float>(std::sqrt(squares_[j])));
            sum_[j] = squares_[j] = 0.0;
            seen_[j] = 0;
        }
        touched_.clear();
    }

  private:
    const Tracer tracer_;
    const Surfaces& surfaces_;
    std::uint64_t seed_;
    Hemisphere hemisphere_;
    std::vector<double> now_, sum_, squares_; ///< #surfaces
    std::vector<char> seen_;                  ///< #surfaces
    std::vector<Index> touched_;
    std::vector<std::pair<Index, double>> moments_;
};

} // namespace

FormFactors form_factors_by_rays(const Tracer& tracer, const Surfaces& surfaces, const DirectionPool& pool,
                                 std::size_t points, std::uint64_t seed, const Execution& execution) {
    if (points < 2) {
        throw UsageError("form factors by rays: at least two points on each triangle are needed, as their errors are "
                         "estimated from the differences between them");
    }
    execution.phase("form factors");
    const Mesh& mesh = tracer.mesh();
    FormFactors F;
    F.area = surfaces.areas(mesh);
    F.rows.resize(surfaces.size());
    std::vector<std::vector<Index>> members(surfaces.size());
    for (Index t = 0; t < surfaces.of.size(); ++t) {
        members[surfaces.of[t]].push_back(t);
    }
    std::vector<RayCount> workers(execution.threads, RayCount(tracer, surfaces, pool, seed));
    parallel_for(F.size(), 1, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        for (std::size_t i = begin; i < end; ++i) {
            for (const Index t : members[i]) {
                workers[worker].add(t, points, mesh.areas[t] / F.area[i]);
            }
            workers[worker].take(F.rows[i]);
        }
    });
    return F;
}

} // namespace difusa
