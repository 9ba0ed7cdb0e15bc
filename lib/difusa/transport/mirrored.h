// Transport with mirrors: what a point sees directly, and what it sees in mirrors.
#pragma once

#include <difusa/algebra/channel_rows.h>
#include <difusa/algebra/linear_operator.h>

#include <memory>
#include <utility>

namespace difusa {

/// W = plain + in_mirrors. Values have the channels in turn (algebra/channel_rows.h) if the mirrors are coloured.
class MirroredTransport final : public LinearOperator {
  public:
    MirroredTransport(std::shared_ptr<const LinearOperator> plain, std::shared_ptr<const ChannelRows> in_mirrors)
        : plain_(std::move(plain)), in_mirrors_(std::move(in_mirrors)) {}

    const std::shared_ptr<const LinearOperator>& plain() const { return plain_; }
    const std::shared_ptr<const ChannelRows>& in_mirrors() const { return in_mirrors_; }

    std::size_t rows() const override { return plain_->rows(); }
    std::size_t columns() const override { return plain_->columns(); }
    std::size_t entry_count() const override { return plain_->entry_count() + in_mirrors_->entry_count(); }

    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;

  private:
    std::shared_ptr<const LinearOperator> plain_;
    std::shared_ptr<const ChannelRows> in_mirrors_;
};

/// Transport of which a part is known better than by rays (analytic_transport.h).
class RefinedTransport : public LinearOperator {
  public:
    virtual const LinearOperator& by_rays() const = 0; ///< all of it, by rays alone

    /// The variance that each ray brings in, so that the mean over the rays of a row has this over their number:
    /// #rows by #columns of x.
    virtual Values variance_of_rays(const Values& x, const Execution& execution) const = 0;
};

/// Transport that adds what glossy surfaces reflect to another one (glossy_transport.h).
class GlossyAddition : public LinearOperator {
  public:
    virtual const LinearOperator& matt() const = 0; ///< the other one
    virtual int channels() const = 0;               ///< 1 if the reflectances of gloss are grey, else 3
};

/// The part of W that goes neither over mirrors nor over glossy surfaces: W itself if there are none. By rays alone.
const LinearOperator& plain_part(const LinearOperator& W);

/// The same as refined transport, or null if it is by rays alone.
const RefinedTransport* refined_part(const LinearOperator& W);

/// The other part; null if there are no mirrors.
std::shared_ptr<const ChannelRows> part_in_mirrors(const LinearOperator& W);

/// True if mirrors or glossy surfaces are coloured: then columns of what W is applied to have the channels in turn.
bool tells_channels_apart(const LinearOperator& W);

} // namespace difusa
