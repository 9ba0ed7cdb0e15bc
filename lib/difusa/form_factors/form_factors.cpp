#include <difusa/form_factors/form_factors.h>

#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/form_factors/pair_exchange.h>
#include <difusa/form_factors/target_tree.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

/// Triangles of a large surface that one task computes.
constexpr std::size_t triangles_in_task = 16;

/// Exchange areas of some triangles of one surface with surfaces of at least its number.
struct ExchangeRow {
    std::vector<Index> column;
    std::vector<double> value;
    std::vector<float> error;
};

struct Task {
    std::size_t first, last; ///< in the order of ranks
    Index surface;
};

/// Everything that all tasks read.
struct ExchangeProblem {
    const Mesh& mesh;
    const Surfaces& surfaces;
    double tolerance;
    double rounding;
    std::vector<double> area;   ///< of the surfaces
    std::vector<Index> by_rank; ///< triangles in the order of their surfaces
    std::vector<Index> rank;    ///< of each triangle
    std::vector<Index> parts;   ///< flat_parts
    ObstacleSet obstacles;
    TargetTree tree;
    std::vector<PolygonEnd> ends; ///< of the triangles

    /// The share of the tolerance of a pair of surfaces that a pair of their triangles may take, as an area.
    double allowed(Index p, Index q) const {
        const double A_I = area[surfaces.of[p]], A_J = area[surfaces.of[q]];
        return tolerance * mesh.areas[p] * mesh.areas[q] / std::max(A_I, A_J);
    }
};

/// The exchange areas of triangles, one after the other, with those of higher rank. Scratch of one thread.
class ExchangeWorker {
  public:
    ExchangeWorker(const ExchangeProblem& problem, const Execution& execution)
        : problem_(problem), pair_(problem.ends, problem.rounding, execution), sum_(problem.surfaces.size()),
          seen_(problem.surfaces.size(), 0) {}

    void run(const Task& task, ExchangeRow& row) {
        for (std::size_t k = task.first; k < task.last; ++k) {
            add_triangle(problem_.by_rank[k]);
        }
        std::sort(touched_.begin(), touched_.end());
        row.column.reserve(touched_.size());
        row.value.reserve(touched_.size());
        row.error.reserve(touched_.size());
        for (const Index j : touched_) {
            row.column.push_back(j);
            row.value.push_back(sum_[j].value);
            row.error.push_back(static_cast<float>(sum_[j].error));
            sum_[j] = {};
            seen_[j] = 0;
        }
        touched_.clear();
    }

    const FormFactorCounts& counts() const { return pair_.counts; }

  private:
    void add_triangle(Index p) {
        p_ = p;
        const PolygonEnd& P = problem_.ends[p];
        pair_.between.clear();
        for (const Obstacle& obstacle : problem_.obstacles.all()) {
            if (obstacle.rises_above(P.plane, problem_.rounding)) {
                pair_.between.push_back(&obstacle);
            }
        }
        visit(0, 0, pair_.between.size());
    }

    /// The triangles under a node; obstacles [first, last) may come between.
    void visit(Index number, std::size_t first, std::size_t last) {
        const TargetTree::Node& node = problem_.tree.node(number);
        const PolygonEnd& P = problem_.ends[p_];
        const double rounding = problem_.rounding;
        if (node.highest <= problem_.rank[p_] ||
            std::all_of(node.corner.begin(), node.corner.end(),
                        [&](const Vec3& c) { return P.plane.height(c) <= rounding; })) {
            return;
        }
        const std::span<const Vec3> own = P.polygon.corners();
        if (node.flat &&
            std::all_of(own.begin(), own.end(), [&](const Vec3& c) { return node.plane.height(c) <= rounding; })) {
            return;
        }
        const std::size_t before = pair_.between.size();
        if (!pair_.narrow(own, node.corner, first, last)) {
            ++pair_.counts.hidden;
            pair_.between.resize(before);
            return;
        }
        const std::size_t after = pair_.between.size();
        if (node.right != none) {
            visit(number + 1, before, after);
            visit(node.right, before, after);
        } else {
            for (Index i = node.first; i < node.last; ++i) {
                const Index q = problem_.tree.order()[i];
                if (problem_.rank[q] > problem_.rank[p_]) {
                    add_pair(q, before, after);
                }
            }
        }
        pair_.between.resize(before);
    }

    void add_pair(Index q, std::size_t first, std::size_t last) {
        const Estimate exchange = pair_.of(p_, q, first, last, problem_.allowed(p_, q));
        if (exchange.value > 0.0) {
            const Index surface = problem_.surfaces.of[q];
            if (seen_[surface] == 0) {
                seen_[surface] = 1;
                touched_.push_back(surface);
            }
            sum_[surface] += exchange;
        }
    }

    const ExchangeProblem& problem_;
    Index p_ = none;
    PairExchange pair_;
    std::vector<Estimate> sum_; ///< #surfaces
    std::vector<char> seen_;    ///< #surfaces
    std::vector<Index> touched_;
};

std::vector<Index> in_order_of_surfaces(const Surfaces& surfaces) {
    std::vector<Index> order(surfaces.of.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return surfaces.of[a] < surfaces.of[b]; });
    return order;
}

std::vector<Index> inverse_of(const std::vector<Index>& order) {
    std::vector<Index> rank(order.size());
    for (Index k = 0; k < order.size(); ++k) {
        rank[order[k]] = k;
    }
    return rank;
}

std::vector<Task> tasks_of(const ExchangeProblem& problem) {
    std::vector<Task> tasks;
    for (std::size_t k = 0; k < problem.by_rank.size(); ++k) {
        const Index surface = problem.surfaces.of[problem.by_rank[k]];
        if (tasks.empty() || tasks.back().surface != surface || k - tasks.back().first >= triangles_in_task) {
            tasks.push_back({k, k, surface});
        }
        tasks.back().last = k + 1;
    }
    return tasks;
}

/// Of an exchange area, and of the two form factors that follow from it.
constexpr double bytes_of_exchange = 3.0 * (sizeof(Index) + sizeof(double) + sizeof(float));

/// Makes room for every row of form factors.
void reserve(FormFactors& F, const std::vector<Task>& tasks, const std::vector<ExchangeRow>& parts) {
    std::vector<std::size_t> count(F.rows.size(), 0); // at most: several parts of a surface may have the same column
    for (std::size_t k = 0; k < tasks.size(); ++k) {
        count[tasks[k].surface] += parts[k].column.size();
        for (const Index j : parts[k].column) {
            count[j] += j == tasks[k].surface ? 0 : 1;
        }
    }
    for (std::size_t i = 0; i < count.size(); ++i) {
        const std::size_t most = std::min(count[i], count.size());
        F.rows[i].column.reserve(most);
        F.rows[i].factor.reserve(most);
        F.rows[i].error.reserve(most);
    }
}

/// Row i of the exchange areas with surfaces j >= i becomes part of the rows i and j of form factors.
FormFactors assembled(const std::vector<Task>& tasks, std::vector<ExchangeRow>& parts, std::vector<double> area) {
    FormFactors F;
    F.rows.resize(area.size());
    reserve(F, tasks, parts);
    // Tasks are in the order of surfaces: what row i receives from lower ones is there, in order, before its own.
    std::vector<Estimate> sum(area.size());
    const auto add = [&](std::size_t i, Index j, double exchange, double error) {
        FormFactors::Row& row = F.rows[i];
        row.column.push_back(j);
        row.factor.push_back(exchange / area[i]);
        row.error.push_back(static_cast<float>(error / area[i]));
    };
    for (std::size_t k = 0; k < tasks.size();) {
        const Index i = tasks[k].surface;
        std::vector<Index> columns;
        for (; k < tasks.size() && tasks[k].surface == i; ++k) {
            for (std::size_t e = 0; e < parts[k].column.size(); ++e) {
                const Index j = parts[k].column[e];
                if (sum[j].value == 0.0) {
                    columns.push_back(j);
                }
                sum[j] += {parts[k].value[e], parts[k].error[e]};
            }
            parts[k] = {};
        }
        std::sort(columns.begin(), columns.end());
        for (const Index j : columns) {
            const Estimate exchange = sum[j];
            sum[j] = {};
            if (j == i) { // light goes both ways between its triangles
                add(i, i, 2.0 * exchange.value, 2.0 * exchange.error);
            } else {
                add(i, j, exchange.value, exchange.error);
                add(j, i, exchange.value, exchange.error);
            }
        }
    }
    F.area = std::move(area);
    return F;
}

} // namespace

std::size_t FormFactors::nonzeros() const {
    std::size_t count = 0;
    for (const Row& row : rows) {
        count += row.column.size();
    }
    return count;
}

std::optional<std::size_t> FormFactors::find(std::size_t i, std::size_t j) const {
    const std::vector<Index>& column = rows[i].column;
    const auto found = std::lower_bound(column.begin(), column.end(), j);
    return found != column.end() && *found == j ? std::optional(static_cast<std::size_t>(found - column.begin()))
                                                : std::nullopt;
}

double FormFactors::at(std::size_t i, std::size_t j) const {
    const std::optional<std::size_t> entry = find(i, j);
    return entry ? rows[i].factor[*entry] : 0.0;
}

double FormFactors::row_sum(std::size_t i) const {
    return std::accumulate(rows[i].factor.begin(), rows[i].factor.end(), 0.0);
}

double FormFactors::row_error(std::size_t i) const {
    return std::accumulate(rows[i].error.begin(), rows[i].error.end(), 0.0);
}

FormFactorLaws check_laws(const FormFactors& F, double tolerance) {
    FormFactorLaws laws;
    for (std::size_t i = 0; i < F.size(); ++i) {
        const double sum = F.row_sum(i);
        laws.least_row_sum = i == 0 ? sum : std::min(laws.least_row_sum, sum);
        laws.largest_row_sum = i == 0 ? sum : std::max(laws.largest_row_sum, sum);
        const FormFactors::Row& row = F.rows[i];
        for (std::size_t e = 0; e < row.column.size(); ++e) {
            const Index j = row.column[e];
            const double difference = std::abs(F.area[i] * row.factor[e] - F.area[j] * F.at(j, i));
            laws.reciprocity = std::max(laws.reciprocity, difference / std::min(F.area[i], F.area[j]));
            laws.largest_error = std::max(laws.largest_error, double{row.error[e]});
            laws.above_tolerance += row.error[e] > tolerance ? 1 : 0;
        }
    }
    return laws;
}

void check_tolerance(const FormFactorOptions& options) {
    if (!(options.tolerance > 0.0 && std::isfinite(options.tolerance))) {
        throw UsageError("form factors: the tolerance must be positive and finite, not " + text_of(options.tolerance));
    }
}

FormFactors form_factors(const Mesh& mesh, const Surfaces& surfaces, const FormFactorOptions& options,
                         const Execution& execution, FormFactorCounts* counts) {
    check_tolerance(options);
    DIFUSA_REQUIRE(surfaces.of.size() == mesh.triangles.size());
    execution.phase("form factors");
    const std::vector<Index> order = in_order_of_surfaces(surfaces), rank = inverse_of(order);
    const std::vector<Index> parts = flat_parts(mesh);
    const ExchangeProblem problem{
        mesh,
        surfaces,
        options.tolerance,
        plane_rounding(mesh),
        surfaces.areas(mesh),
        order,
        rank,
        parts,
        ObstacleSet(mesh.convex ? std::vector<Blocker>() : blockers_of(mesh, parts, execution)),
        TargetTree(mesh, parts, rank),
        ends_of(mesh)};
    const std::vector<Task> tasks = tasks_of(problem);
    std::vector<ExchangeRow> rows(tasks.size());
    std::vector<ExchangeWorker> workers(execution.threads, ExchangeWorker(problem, execution));
    const std::size_t memory = execution.memory_left();
    std::atomic<std::size_t> exchanges = 0; // how many see each other is known only once they are computed
    parallel_for(tasks.size(), 1, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        for (std::size_t k = begin; k < end; ++k) {
            workers[worker].run(tasks[k], rows[k]);
            const std::size_t so_far = exchanges += rows[k].column.size();
            require_memory(bytes_of_exchange * static_cast<double>(so_far), memory,
                           "those of the form factors between " + std::to_string(surfaces.size()) +
                               " surfaces that are computed so far",
                           "join faces to fewer surfaces (--surfaces material), or compute factors between groups "
                           "(--layout grouped)");
        }
    });
    if (counts != nullptr) {
        for (const ExchangeWorker& worker : workers) {
            *counts += worker.counts();
        }
    }
    return assembled(tasks, rows, problem.area);
}

} // namespace difusa
