// A linear operator as an action: solvers and bounds need no matrix.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>

#include <cstddef>
#include <memory>

namespace difusa {

class SparseRows;
struct Factors;

class LinearOperator {
  public:
    virtual ~LinearOperator() = default;
    virtual std::size_t rows() const = 0;
    virtual std::size_t columns() const = 0;

    /// y = A x for each column of x (#columns by any number); y is resized and must not be x. Bit-identical for any
    /// number of threads.
    virtual void apply(const Values& x, Values& y, const Execution& execution) const = 0;

    /// y = A x for an operand in single precision: what `apply` gives for the same numbers but for rounding, whatever
    /// columns are beside one.
    virtual void apply_single(const SingleValues& x, Values& y, const Execution& execution) const {
        apply(Values(x.cast<double>()), y, execution);
    }

    /// Whether such products take less time than others, if there are many columns.
    virtual bool prefers_single() const { return false; }

    /// Whichever of the two takes such operands.
    void apply_to(const Values& x, Values& y, const Execution& execution) const { apply(x, y, execution); }
    void apply_to(const SingleValues& x, Values& y, const Execution& execution) const { apply_single(x, y, execution); }

    /// y = Aᵀ x for each column of x (#rows by any number), likewise.
    virtual void apply_transpose(const Values& x, Values& y, const Execution& execution) const = 0;

    /// 0, or p: what becomes of column c of x depends on c modulo p alone, so that whole sets of p columns may be left
    /// out.
    virtual Eigen::Index column_period() const { return 0; }

    /// The entries, for callers that need rows or columns; null if they are compressed, composed or elsewhere.
    virtual const SparseRows* entries() const { return nullptr; }

    /// The operator as a product of stored matrices (algebra/factors.h), for methods that relax one unknown after the
    /// other; null if it has none. Made anew by each call. Throws ResourceError if memory does not suffice.
    virtual std::shared_ptr<const Factors> factors(const Execution& /*execution*/) const { return nullptr; }

    /// How many stored entries a product with one column multiplies; those of the factors of a product add up.
    virtual std::size_t entry_count() const = 0;
};

} // namespace difusa
