// A linear operator as an action: solvers and bounds need no matrix.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>

#include <cstddef>

namespace difusa {

class SparseRows;

class LinearOperator {
  public:
    virtual ~LinearOperator() = default;
    virtual std::size_t rows() const = 0;
    virtual std::size_t columns() const = 0;

    /// y = A x for each column of x (#columns by any number); y is resized and must not be x. Bit-identical for any
    /// number of threads.
    virtual void apply(const Values& x, Values& y, const Execution& execution) const = 0;

    /// y = Aᵀ x for each column of x (#rows by any number), likewise.
    virtual void apply_transpose(const Values& x, Values& y, const Execution& execution) const = 0;

    /// The entries, for callers that need rows or columns; null if they are compressed, composed or elsewhere.
    virtual const SparseRows* entries() const { return nullptr; }
};

} // namespace difusa
