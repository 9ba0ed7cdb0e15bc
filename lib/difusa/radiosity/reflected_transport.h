// The operator of the radiosity equation: irradiance at the points -> reflected radiosity of the surface -> irradiance
// at the points.
#pragma once

#include <difusa/algebra/linear_operator.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/transport/light_transport.h>

#include <mutex>

namespace difusa {

/// T = D diag(rho) P Π. Column c of an operand is reflected by column c modulo #channels of rho.
class ReflectedTransport final : public LinearOperator {
  public:
    /// `reflectance`: #surfels by #channels. Keeps references.
    ReflectedTransport(const Discretisation& discretisation, const LightTransport& transport, const Values& reflectance)
        : discretisation_(discretisation), transport_(transport), reflectance_(reflectance) {}

    std::size_t rows() const override { return transport_.points(); }
    std::size_t columns() const override { return transport_.points(); }
    void apply(const Values& h, Values& y, const Execution& execution) const override;
    void apply_single(const SingleValues& h, Values& y, const Execution& execution) const override;
    bool prefers_single() const override { return transport_.W->prefers_single(); }
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;
    Eigen::Index column_period() const override { return reflectance_.cols(); }
    std::size_t entry_count() const override;

    /// A is D, or the form factors between pairs; Q the rest, diag(rho) P Π or M diag(rho) P Π. Null if the projection
    /// is not local, or the transport not stored.
    std::shared_ptr<const Factors> factors(const Execution& execution) const override;

  private:
    /// What a product needs besides its operands: the radiosity of the bins, and coefficients.
    struct Scratch {
        Values on_bins;
        SingleValues single_on_bins, single_coefficients, single_between;
    };
    /// That of the last product, unless another thread has it.
    Scratch take_scratch() const;
    void give_back(Scratch scratch) const;

    const Discretisation& discretisation_;
    const LightTransport& transport_;
    const Values& reflectance_;
    mutable std::mutex guard_; ///< of `scratch_`
    mutable Scratch scratch_;  ///< the memory of the last product serves the next one
};

} // namespace difusa
