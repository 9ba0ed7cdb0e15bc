#include <difusa/radiosity/reflected_transport.h>

#include <difusa/algebra/factors.h>
#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>
#include <difusa/transport/pairwise.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

namespace difusa {

namespace {

/// Adds multiples of sparse rows, and gives the sum as a sparse row.
class RowSum {
  public:
    explicit RowSum(std::size_t columns) : sum_(columns, 0.0), is_used_(columns, 0) {}

    void add(double factor, const SparseRows::Row& row) {
        for (std::size_t k = 0; k < row.column.size(); ++k) {
            add(row.column[k], factor * row.value[k]);
        }
    }
    void add(Index column, double value) {
        if (is_used_[column] == 0) {
            is_used_[column] = 1;
            used_.push_back(column);
        }
        sum_[column] += value;
    }
    /// The sum, which begins again at 0.
    void take(SparseRows::Row& row) {
        std::sort(used_.begin(), used_.end());
        row.column = used_;
        row.value.clear();
        for (const Index column : used_) {
            row.value.push_back(sum_[column]);
            sum_[column] = 0.0;
            is_used_[column] = 0;
        }
        used_.clear();
    }

  private:
    std::vector<double> sum_;
    std::vector<std::uint8_t> is_used_;
    std::vector<Index> used_;
};

/// P Π, which is P without a projection: the means over the surfels of what is 1 at one point and 0 at the others.
SparseRows averages_of_points(const BasisAverages& P, const std::optional<SparseRows>& projection,
                              const Execution& execution) {
    SparseRows product(P.rows(), projection ? projection->columns() : P.columns());
    parallel_for(P.rows(), 1024, Unreported(execution), [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        RowSum sum(projection ? product.columns() : 0);
        for (std::size_t s = begin; s < end; ++s) {
            P.row(static_cast<Index>(s), row);
            if (!projection) {
                product.row(s) = {row.element, row.weight};
                continue;
            }
            for (std::size_t i = 0; i < row.element.size(); ++i) {
                sum.add(row.weight[i], projection->row(row.element[i]));
            }
            sum.take(product.row(s));
        }
    });
    return product;
}

/// diag(rho) R, from the columns of R.
SparseColumns reflected(SparseColumns R, const Values& rho) {
    const Values one = std::move(R.value);
    R.value.resize(one.rows(), rho.cols());
    for (Eigen::Index e = 0; e < one.rows(); ++e) {
        R.value.row(e) = one(e, 0) * rho.row(R.row[static_cast<std::size_t>(e)]);
    }
    return R;
}

/// M diag(rho) R, from the columns of M and R. Entries that vanish for all channels are kept: no value decides about
/// the pattern.
SparseColumns distributed(const SparseColumns& M, const SparseColumns& R, const Values& rho, std::size_t rows) {
    SparseColumns product;
    product.first.push_back(0);
    std::vector<Values> values; // of each column
    Values sum = Values::Zero(static_cast<Eigen::Index>(rows), rho.cols());
    std::vector<std::uint8_t> is_used(rows, 0);
    std::vector<Index> used;
    for (std::size_t i = 0; i < R.columns(); ++i) {
        used.clear();
        for (std::size_t e = R.first[i]; e < R.first[i + 1]; ++e) {
            const Index s = R.row[e];
            for (std::size_t m = M.first[s]; m < M.first[s + 1]; ++m) {
                const Index k = M.row[m];
                if (is_used[k] == 0) {
                    is_used[k] = 1;
                    used.push_back(k);
                }
                sum.row(k) +=
                    M.value(static_cast<Eigen::Index>(m), 0) * R.value(static_cast<Eigen::Index>(e), 0) * rho.row(s);
            }
        }
        std::sort(used.begin(), used.end());
        values.emplace_back(static_cast<Eigen::Index>(used.size()), rho.cols());
        for (std::size_t u = 0; u < used.size(); ++u) {
            values.back().row(static_cast<Eigen::Index>(u)) = sum.row(used[u]);
            sum.row(used[u]).setZero();
            is_used[used[u]] = 0;
        }
        product.row.insert(product.row.end(), used.begin(), used.end());
        product.first.push_back(product.row.size());
    }
    product.value.resize(static_cast<Eigen::Index>(product.row.size()), rho.cols());
    for (std::size_t i = 0; i < R.columns(); ++i) {
        product.value.middleRows(static_cast<Eigen::Index>(product.first[i]), values[i].rows()) = values[i];
        values[i].resize(0, 0);
    }
    return product;
}

} // namespace

ReflectedTransport::Scratch ReflectedTransport::take_scratch() const {
    const std::lock_guard lock(guard_);
    return std::exchange(scratch_, {});
}

void ReflectedTransport::give_back(Scratch scratch) const {
    const std::lock_guard lock(guard_);
    scratch_ = std::move(scratch);
}

void ReflectedTransport::apply(const Values& h, Values& y, const Execution& execution) const {
    const Projection& projection = *discretisation_.projection;
    Scratch scratch = take_scratch();
    Values& on_bins = scratch.on_bins; // those of the sky reflect nothing
    discretisation_.averages->reflect(projection.is_identity() ? h : projection.coefficients(h, execution),
                                      reflectance_, transport_.W->columns(), on_bins, execution);
    transport_.W->apply(on_bins, y, execution);
    give_back(std::move(scratch));
}

void ReflectedTransport::apply_single(const SingleValues& h, Values& y, const Execution& execution) const {
    const Projection& projection = *discretisation_.projection;
    Scratch scratch = take_scratch();
    const SingleValues* coefficients = &h;
    if (!projection.is_identity()) {
        projection.coefficients(h, scratch.single_coefficients, scratch.single_between, execution);
        coefficients = &scratch.single_coefficients;
    }
    SingleValues& on_bins = scratch.single_on_bins;
    discretisation_.averages->reflect(*coefficients, reflectance_, transport_.W->columns(), on_bins, execution);
    transport_.W->apply_single(on_bins, y, execution);
    give_back(std::move(scratch));
}

void ReflectedTransport::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    Values at_bins;
    transport_.W->apply_transpose(x, at_bins, execution);
    Values b = at_bins.topRows(static_cast<Eigen::Index>(transport_.surfels));
    const Eigen::Index channels = reflectance_.cols();
    for_blocks(b.rows(), execution, [&](Eigen::Index first, Eigen::Index count, Eigen::Index) {
        for (Eigen::Index s = first; s < first + count; ++s) {
            for (Eigen::Index c = 0; c < b.cols(); ++c) {
                b(s, c) *= reflectance_(s, c % channels);
            }
        }
    });
    Values coefficients;
    discretisation_.averages->apply_transpose(b, coefficients, execution);
    y = discretisation_.projection->transposed(coefficients);
}

std::size_t ReflectedTransport::entry_count() const {
    return transport_.W->entry_count() + discretisation_.averages->entry_count() +
           discretisation_.projection->entry_count();
}

std::shared_ptr<const Factors> ReflectedTransport::factors(const Execution& execution) const {
    const Projection& projection = *discretisation_.projection;
    const std::shared_ptr<const SparseRows> S = pairwise_parts(*transport_.W).form_factors;
    const std::optional<SparseRows> matrix = projection.matrix();
    if ((!projection.is_identity() && !matrix) || (!S && !RowReader(*transport_.W).any())) {
        return nullptr;
    }
    const auto surfels = static_cast<Eigen::Index>(transport_.surfels);
    auto factors = std::make_shared<Factors>();
    const SparseRows averages = averages_of_points(*discretisation_.averages, matrix, execution);
    SparseColumns R = columns_of(averages, averages.columns(), execution);
    require_memory(2.0 * static_cast<double>(R.row.size()) *
                       (sizeof(Index) + static_cast<double>(reflectance_.cols()) * sizeof(double)),
                   execution.memory_left(), "the rows and columns of the transport",
                   "use --solver krylov, or give fewer --sites");
    if (S) {
        factors->A = S;
        factors->middle = S->columns();
        const SparseRows M = pairwise_distribution(*transport_.W);
        factors->Q = distributed(columns_of(M, M.columns(), execution), R, reflectance_, factors->middle);
    } else {
        factors->A = transport_.W;
        factors->middle = transport_.surfels;
        factors->Q = reflected(std::move(R), reflectance_);
    }
    // What an irradiance of 1 at one point makes the surface reflect: Πᵀ Pᵀ (rho ∘ area).
    Values reflecting = reflectance_;
    for (Eigen::Index s = 0; s < surfels; ++s) {
        const double area = discretisation_.surfels->area(static_cast<Index>(s));
        reflecting.row(s) *= area;
        factors->area += area;
    }
    Values coefficients;
    discretisation_.averages->apply_transpose(reflecting, coefficients, execution);
    factors->power = projection.transposed(coefficients);
    return factors;
}

} // namespace difusa
