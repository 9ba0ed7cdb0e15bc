// A square operator as the product of two stored matrices, T = A Q, whose rows and columns can be used one at a time:
// what methods need that relax one unknown after the other.
#pragma once

#include <difusa/algebra/hit_lists.h>
#include <difusa/algebra/sparse_rows.h>
#include <difusa/core/types.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace difusa {

/// The rows of an operator that is stored entry by entry: SparseRows or HitLists. The operator must outlive it.
class RowReader {
  public:
    explicit RowReader(const LinearOperator& W) : lists_(dynamic_cast<const HitLists*>(&W)), entries_(W.entries()) {}

    /// False if the operator is stored otherwise.
    bool any() const { return lists_ != nullptr || entries_ != nullptr; }

    /// The entries of row j by ascending column; a column may be repeated, its entries then add up.
    void row(std::size_t j, std::vector<Index>& columns, std::vector<double>& weights) const {
        if (lists_ != nullptr) {
            lists_->row(j, columns);
            weights.assign(columns.size(), 1.0 / static_cast<double>(lists_->rays()));
        } else {
            columns = entries_->row(j).column;
            weights = entries_->row(j).value;
        }
    }

  private:
    const HitLists* lists_;
    const SparseRows* entries_;
};

/// A sparse matrix by columns, each of whose entries has a value for each channel, or the same for all.
struct SparseColumns {
    std::vector<std::size_t> first; ///< #columns + 1
    std::vector<Index> row;         ///< #entries, ascending in each column
    Values value;                   ///< #entries by #channels

    std::size_t columns() const { return first.size() - 1; }
    std::size_t bytes() const {
        return first.size() * sizeof(std::size_t) + row.size() * sizeof(Index) +
               static_cast<std::size_t>(value.size()) * sizeof(double);
    }
};

/// The columns of A below `count`, for operators that a RowReader can read. Throws ResourceError, before anything is
/// allocated, if memory does not suffice.
SparseColumns columns_of(const LinearOperator& A, std::size_t count, const Execution& execution);

/// T = A Q for each channel; column c of an operand is that of channel c modulo #channels.
struct Factors {
    std::shared_ptr<const LinearOperator> A; ///< n rows that a RowReader can read
    std::size_t middle = 0;                  ///< columns of A that count; the others are multiplied with nothing
    SparseColumns Q;                         ///< `middle` by n
    Values power; ///< n by #channels: what the whole surface reflects for an irradiance of 1 W/m² at the point, in m²
    double area = 0.0; ///< of the surface, m²

    std::size_t size() const { return Q.columns(); }
    Eigen::Index channels() const { return Q.value.cols(); }

    /// The diagonal of T: n by #channels.
    Values diagonal(const Execution& execution) const;

    /// The columns of A that count (columns_of): a column of T is a sum of them.
    SparseColumns columns_of_A(const Execution& execution) const { return columns_of(*A, middle, execution); }
};

} // namespace difusa
