#include <difusa/mesh/lobe_harmonics.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>
#include <difusa/core/even_sequence.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

constexpr std::size_t angles = 257;    ///< of the table, from 0 to pi/2
constexpr std::size_t samples = 4096;  ///< of the integral over the lobe
constexpr std::size_t rest_nodes = 64; ///< of that over the rest, which is smooth

} // namespace

LobeHarmonics::LobeHarmonics(const GlossyLobe& lobe, const SphericalHarmonics& harmonics) : order_(harmonics.order()) {
    DIFUSA_REQUIRE(order_ <= most_order);
    for (int l = 0; l <= order_; ++l) {
        for (int m = l % 2; m <= l; m += 2) {
            bands_.push_back({l, m});
            numbers_.push_back(SphericalHarmonics::number(l, m));
            if (m > 0) {
                numbers_.push_back(SphericalHarmonics::number(l, -m));
            }
        }
    }
    std::vector<double> Y(harmonics.count());
    // What grazing light leaves of the rest, which only harmonics with m = 0 have; of other light it is a multiple.
    std::vector<double> rest(harmonics.count(), 0.0);
    const QuadratureRule rule = gauss_legendre(rest_nodes);
    for (std::size_t k = 0; k < rule.size(); ++k) {
        const double z = rule.node[k];
        harmonics.at({std::sqrt(1.0 - z * z), 0.0, z}, Y);
        for (int l = 0; l <= order_; l += 2) {
            const std::size_t number = SphericalHarmonics::number(l, 0);
            rest[number] +=
                2.0 * std::numbers::pi * 2.0 * std::numbers::pi * rule.weight[k] * lobe.rest(0.0, z) * Y[number];
        }
    }
    const double lost_at_grazing = 1.0 - lobe.reflected(0.0);
    table_.assign(angles * bands_.size(), 0.0);
    double squares = 0.0;
    for (std::size_t a = 0; a < angles; ++a) {
        const double angle = 0.5 * std::numbers::pi * static_cast<double>(a) / static_cast<double>(angles - 1);
        const Vec3 in(std::sin(angle), 0.0, std::max(0.0, std::cos(angle)));
        double* const row = &table_[a * bands_.size()];
        for (std::size_t s = 0; s < samples; ++s) {
            const auto [u, v] = even_point<2>(s, {0.5, 0.5});
            const GlossyLobe::Draw drawn = lobe.draw_lobe(in, u, v);
            if (!(drawn.weight > 0.0)) {
                continue;
            }
            harmonics.at(drawn.direction, Y);
            const double factor = 2.0 * std::numbers::pi * drawn.weight / static_cast<double>(samples);
            for (std::size_t b = 0; b < bands_.size(); ++b) {
                row[b] += factor * Y[SphericalHarmonics::number(bands_[b].l, bands_[b].m)];
            }
            if (a == 0) { // ∫ (pi f)² dω, twice for the mirror image
                squares += factor * std::numbers::pi * lobe.value(Vec3::UnitZ(), in, drawn.direction);
            }
        }
        const double share = lost_at_grazing > 0.0 ? (1.0 - lobe.reflected(in.z())) / lost_at_grazing : 0.0;
        for (std::size_t b = 0; b < bands_.size(); ++b) {
            row[b] += bands_[b].m == 0 ? share * rest[SphericalHarmonics::number(bands_[b].l, 0)] : 0.0;
        }
    }
    double held = 0.0;
    for (std::size_t b = 1; b < bands_.size(); ++b) {
        held += bands_[b].m == 0 ? table_[b] * table_[b] : 0.0;
    }
    const double mean = table_[0] * table_[0];
    resolved_ = squares - mean > 1e-3 * mean ? std::min(1.0, held / (squares - mean)) : 1.0;
}

void LobeHarmonics::at(const Vec3& in, std::span<double> F) const {
    const double angle = std::acos(std::clamp(in.z(), 0.0, 1.0));
    const double place = angle / (0.5 * std::numbers::pi) * static_cast<double>(angles - 1);
    const std::size_t a = std::min(static_cast<std::size_t>(place), angles - 2);
    const double along = place - static_cast<double>(a);
    const double* const low = &table_[a * bands_.size()];
    const double* const high = low + bands_.size();
    const double across = std::hypot(in.x(), in.y());
    const double cosine = across > 0.0 ? in.x() / across : 1.0, sine = across > 0.0 ? in.y() / across : 0.0;
    std::array<std::array<double, 2>, most_order + 1> turns; // cosine and sine of m phi
    turns[0] = {1.0, 0.0};
    for (int m = 1; m <= order_; ++m) {
        const auto& [c, s] = turns[static_cast<std::size_t>(m) - 1];
        turns[static_cast<std::size_t>(m)] = {c * cosine - s * sine, c * sine + s * cosine};
    }
    std::size_t k = 0;
    for (std::size_t b = 0; b < bands_.size(); ++b) {
        const double value = (1.0 - along) * low[b] + along * high[b];
        const auto& [c, s] = turns[static_cast<std::size_t>(bands_[b].m)];
        F[k++] = value * c;
        if (bands_[b].m > 0) {
            F[k++] = value * s;
        }
    }
}

double LobeHarmonics::even() {
    return std::sqrt(4.0 * std::numbers::pi);
}

} // namespace difusa
