#include <difusa/algebra/factors.h>

#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>

namespace difusa {

Values Factors::diagonal(const Execution& execution) const {
    Values diagonal = Values::Zero(static_cast<Eigen::Index>(size()), channels());
    const RowReader rows(*A);
    parallel_for(size(), 64, Unreported(execution), [&](std::size_t begin, std::size_t end, unsigned) {
        Values spread = Values::Zero(static_cast<Eigen::Index>(middle), channels()); // column j of Q, all zeros between
        std::vector<Index> columns;
        std::vector<double> weights;
        for (std::size_t j = begin; j < end; ++j) {
            for (std::size_t e = Q.first[j]; e < Q.first[j + 1]; ++e) {
                spread.row(Q.row[e]) = Q.value.row(static_cast<Eigen::Index>(e));
            }
            rows.row(j, columns, weights);
            for (std::size_t k = 0; k < columns.size() && columns[k] < middle; ++k) {
                diagonal.row(static_cast<Eigen::Index>(j)) += weights[k] * spread.row(columns[k]);
            }
            for (std::size_t e = Q.first[j]; e < Q.first[j + 1]; ++e) {
                spread.row(Q.row[e]).setZero();
            }
        }
    });
    return diagonal;
}

SparseColumns columns_of(const LinearOperator& A, std::size_t count, const Execution& execution) {
    const RowReader rows(A);
    SparseColumns sorted;
    sorted.first.assign(count + 1, 0);
    std::vector<Index> columns;
    std::vector<double> weights;
    const auto for_entries = [&](const auto& act) {
        for (std::size_t j = 0; j < A.rows(); ++j) {
            rows.row(j, columns, weights);
            for (std::size_t k = 0; k < columns.size() && columns[k] < count; ++k) {
                act(j, columns[k], weights[k], k > 0 && columns[k] == columns[k - 1]);
            }
        }
        execution.check();
    };
    for_entries(
        [&](std::size_t, Index column, double, bool repeated) { sorted.first[column + 1] += repeated ? 0 : 1; });
    for (std::size_t s = 0; s < count; ++s) {
        sorted.first[s + 1] += sorted.first[s];
    }
    const std::size_t entries = sorted.first.back();
    require_memory(static_cast<double>(entries) * (sizeof(Index) + sizeof(double)), execution.memory_left(),
                   "the columns of the transport", "use --solver krylov, or give fewer --sites or --rays");
    sorted.row.resize(entries);
    sorted.value = Values::Zero(static_cast<Eigen::Index>(entries), 1);
    std::vector<std::size_t> next(sorted.first.begin(), sorted.first.end() - 1);
    for_entries([&](std::size_t j, Index column, double weight, bool repeated) {
        const std::size_t at = repeated ? next[column] - 1 : next[column]++;
        sorted.row[at] = static_cast<Index>(j);
        sorted.value(static_cast<Eigen::Index>(at), 0) += weight;
    });
    return sorted;
}

} // namespace difusa
