#include <difusa/radiosity/contraction.h>

#include <difusa/algebra/spectral_radius.h>
#include <difusa/core/fingerprint.h>
#include <difusa/radiosity/reflected_transport.h>
#include <difusa/transport/glossy_transport.h>
#include <difusa/transport/mirrored.h>

#include <algorithm>

namespace difusa {

namespace {

constexpr int arnoldi_steps = 40;
constexpr double arnoldi_tolerance = 1e-5;

/// What an operator does to one of the channels: coloured mirrors and glossy surfaces tell them apart by their columns.
class OneChannel final : public LinearOperator {
  public:
    OneChannel(const LinearOperator& all, Eigen::Index channel, Eigen::Index channels)
        : all_(all), channel_(channel), channels_(channels) {}

    std::size_t rows() const override { return all_.rows(); }
    std::size_t columns() const override { return all_.columns(); }
    std::size_t entry_count() const override { return all_.entry_count(); }
    void apply(const Values& x, Values& y, const Execution& execution) const override {
        Values result;
        all_.apply(spread(x), result, execution);
        y = result.col(channel_);
    }
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override {
        Values result;
        all_.apply_transpose(spread(x), result, execution);
        y = result.col(channel_);
    }

  private:
    Values spread(const Values& x) const {
        DIFUSA_REQUIRE(x.cols() == 1);
        Values all = Values::Zero(x.rows(), channels_);
        all.col(channel_) = x;
        return all;
    }
    const LinearOperator& all_;
    Eigen::Index channel_, channels_;
};

} // namespace

std::uint64_t reflectance_fingerprint(const Values& reflectance) {
    Fingerprint fingerprint;
    fingerprint.add(static_cast<std::uint64_t>(reflectance.cols()));
    for (Eigen::Index i = 0; i < reflectance.size(); ++i) {
        fingerprint.add(reflectance.data()[i]);
    }
    return fingerprint.value();
}

Contraction contraction_of(const Discretisation& discretisation, const LightTransport& transport, const Values& rho,
                           const Execution& execution) {
    Contraction found;
    // What harmonics of direction give may be negative, so that their sums are no bounds.
    if (discretisation.projection->is_mean() && discretisation.basis->partition_of_unity() &&
        glossy_part(*transport.W) == nullptr) {
        Values norms; // row sums of T, which bound the radius: neither Π nor P increases them
        transport.gather(rho, {}, norms, execution);
        found.radius = norms.maxCoeff();
        found.is_bound = true;
        if (found.dies_out()) {
            return found;
        }
    }
    found.is_bound = false;
    const auto radius_of = [&](const Values& channel) {
        const ReflectedTransport one(discretisation, transport, channel);
        return spectral_radius(one, arnoldi_steps, arnoldi_tolerance, execution);
    };
    const auto radius_of_channel = [&](Eigen::Index c) {
        if (!tells_channels_apart(*transport.W)) {
            return radius_of(rho.col(c));
        }
        const ReflectedTransport all(discretisation, transport, rho);
        return spectral_radius(OneChannel(all, c, rho.cols()), arnoldi_steps, arnoldi_tolerance, execution);
    };
    // More reflectance, more light: the largest of all channels everywhere stands for each of them.
    found.radius = radius_of(rho.rowwise().maxCoeff());
    if (!found.dies_out() && rho.cols() > 1) {
        found.radius = 0.0;
        for (Eigen::Index c = 0; c < rho.cols(); ++c) {
            found.radius = std::max(found.radius, radius_of_channel(c));
        }
    }
    return found;
}

} // namespace difusa
