// The basis averaged over surfels: P_si = mean of phi_i over surfel s. It maps the coefficients of a function to its
// means over the surfels.
#pragma once

#include <difusa/algebra/linear_operator.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/surfels.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// #surfels by #S, stored in 6 bytes per entry: weights are multiples of 2^-18, and if the basis sums to one its rows
/// do so exactly, so that constants are reproduced without rounding. A planar surfel is represented by its centroid
/// (exact for functions linear over it), one of many triangles by a few points of equal area.
class BasisAverages final : public LinearOperator {
  public:
    /// Throws UsageError if a basis function is not below 7 in magnitude, ResourceError for more than 2^26 sites or
    /// 2^32 entries.
    BasisAverages(const Basis& basis, const Surfels& surfels, const Execution& execution);

    std::size_t rows() const override { return first_.size() - 1; }
    std::size_t columns() const override { return columns_; }

    /// True if no basis function is nonzero on the surfel.
    bool is_empty(Index s) const { return first_[s] == first_[s + 1]; }

    /// P_si of one surfel, by ascending site.
    void row(Index s, BasisRow& row) const;

    /// Size in bytes.
    std::size_t bytes() const { return first_.size() * sizeof(std::uint32_t) + entries_.size() * sizeof(Entry); }

    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;
    std::size_t entry_count() const override { return entries_.size(); }

    /// y = rho ∘ (P x), and rows of zeros after these up to `rows` of them. `rho`: #surfels by #channels, for columns
    /// of x of which column c is reflected by channel c modulo #channels.
    void reflect(const Values& x, const Values& rho, std::size_t rows, Values& y, const Execution& execution) const;
    void reflect(const SingleValues& x, const Values& rho, std::size_t rows, SingleValues& y,
                 const Execution& execution) const;

  private:
    template <class Operand>
    void reflect_rows(const Operand& x, const Values& rho, std::size_t rows, Operand& y,
                      const Execution& execution) const;

    /// 26 bits of the site, then 22 of the weight in units of 2^-18, in two's complement.
    struct Entry {
        static constexpr int site_bits = 26;
        static constexpr double unit = 0x1p-18;
        std::array<std::uint16_t, 3> bits;

        Entry(Index site, std::int32_t units);
        Index site() const { return static_cast<Index>(all() & ((std::uint64_t{1} << site_bits) - 1)); }
        /// The sign bit of the weight is brought to the top.
        double weight() const {
            return unit * static_cast<double>(static_cast<std::int64_t>(all() << 16U) >> (16 + site_bits));
        }
        std::uint64_t all() const { return bits[0] | std::uint64_t{bits[1]} << 16U | std::uint64_t{bits[2]} << 32U; }
    };
    /// Row s.
    std::span<const Entry> entries_of(std::size_t s) const {
        return std::span(entries_).subspan(first_[s], first_[s + 1] - first_[s]);
    }

    std::size_t columns_;
    std::vector<std::uint32_t> first_; ///< #surfels + 1
    std::vector<Entry> entries_;
};

} // namespace difusa
