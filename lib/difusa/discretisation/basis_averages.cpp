#include <difusa/discretisation/basis_averages.h>

#include <difusa/algebra/column_panels.h>
#include <difusa/algebra/transpose_sum.h>
#include <difusa/algebra/wide_vectors.h>
#include <difusa/core/error.h>
#include <difusa/core/even_sequence.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace difusa {

namespace {

constexpr std::int32_t one = std::int32_t{1} << 18U;
constexpr std::size_t block = 1024;
constexpr std::size_t points_of_cluster = 4;

/// Sample points that represent the surfel.
void representatives(const Surfels& surfels, Index s, std::vector<Surfels::Piece>& pieces,
                     std::vector<SurfacePoint>& points) {
    points.clear();
    points.push_back(surfels.centre(s, pieces));
    if (pieces.size() == 1) {
        return;
    }
    points.clear();
    for (std::size_t i = 0; i < points_of_cluster; ++i) {
        const double share = (static_cast<double>(i) + 0.5) / points_of_cluster;
        points.push_back(surfels.point_on(pieces, share, fraction(0.5 + static_cast<double>(i) * even_steps<2>[0])));
    }
}

/// Makes the weights sum to 1: the largest takes the rounding errors of all.
void round_to_one(std::vector<std::pair<Index, std::int32_t>>& row) {
    const auto largest =
        std::max_element(row.begin(), row.end(), [](const auto& x, const auto& y) { return x.second < y.second; });
    std::int32_t missing = one;
    for (const auto& [site, units] : row) {
        missing -= units;
    }
    largest->second += missing;
}

/// `count` columns of a row of P x from the entries of P; x has `width` columns. Weights, of 21 bits, are exact in
/// single precision, too.
template <int count, class Entry, class Number>
void average_columns(std::span<const Entry> entries, const Number* from, Eigen::Index width, Number* out) {
    Number sum[count] = {};
    for (const Entry& entry : entries) {
        one_term_at_a_time();
        const auto weight = static_cast<Number>(entry.weight());
        const Number* const source = from + static_cast<Eigen::Index>(entry.site()) * width;
        for (int c = 0; c < count; ++c) {
            sum[c] += weight * source[c];
        }
    }
    for (int c = 0; c < count; ++c) {
        out[c] = sum[c];
    }
}

/// A row of P x from the entries of P.
template <class Entry, class Operand>
void average(std::span<const Entry> entries, const Operand& x, typename Operand::Scalar* out) {
    for_panels<96, 24, 21, 8, 7, 3, 1>(x.cols(), [&](auto count, Eigen::Index c) {
        average_columns<count>(entries, x.data() + c, x.cols(), out + c);
    });
}

/// Multiplies number c by reflectance c modulo #channels. `factors`: memory for a multiple of them, so many that
/// vectors of them can be multiplied.
template <class Number>
void scale(const double* reflectance, Eigen::Index channels, std::vector<Number>& factors, Number* numbers,
           Eigen::Index width) {
    const auto period = static_cast<Eigen::Index>(factors.size());
    Number* __restrict const repeated = factors.data();
    for (Eigen::Index c = 0; c < period; c += channels) {
        for (Eigen::Index channel = 0; channel < channels; ++channel) {
            repeated[c + channel] = static_cast<Number>(reflectance[channel]);
        }
    }
    for (Eigen::Index first = 0; first < width; first += period) {
        const Eigen::Index count = std::min(period, width - first);
        Number* __restrict const some = numbers + first;
        for (Eigen::Index c = 0; c < count; ++c) {
            some[c] *= repeated[c];
        }
    }
}

} // namespace

BasisAverages::Entry::Entry(Index site, std::int32_t units) : bits{} {
    const std::uint64_t all = site | static_cast<std::uint64_t>(std::int64_t{units}) << site_bits;
    for (unsigned part = 0; part < 3; ++part) {
        bits[part] = static_cast<std::uint16_t>(all >> (16U * part));
    }
}

BasisAverages::BasisAverages(const Basis& basis, const Surfels& surfels, const Execution& execution)
    : columns_(basis.size()), first_(surfels.size() + 1, 0) {
    if (columns_ > std::size_t{1} << Entry::site_bits) {
        throw ResourceError("more than 2^26 sites: give fewer --sites");
    }
    const std::size_t blocks = (surfels.size() + block - 1) / block;
    std::vector<std::vector<Entry>> parts(blocks);
    parallel_for(blocks, 1, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<Surfels::Piece> pieces;
        std::vector<SurfacePoint> points;
        std::vector<BasisRow> rows;
        std::vector<std::pair<Index, double>> sums;
        std::vector<std::pair<Index, std::int32_t>> row;
        for (std::size_t b = begin; b < end; ++b) {
            for (std::size_t s = b * block; s < std::min((b + 1) * block, surfels.size()); ++s) {
                representatives(surfels, static_cast<Index>(s), pieces, points);
                rows.resize(points.size());
                basis.evaluate(points, rows);
                sums.clear();
                for (std::size_t p = 0; p < points.size(); ++p) {
                    for (std::size_t i = 0; i < rows[p].element.size(); ++i) {
                        sums.emplace_back(rows[p].element[i], rows[p].weight[i] / static_cast<double>(points.size()));
                    }
                }
                std::sort(sums.begin(), sums.end());
                row.clear();
                double exact = 0.0;
                for (std::size_t i = 0; i < sums.size();) {
                    const Index site = sums[i].first;
                    double weight = 0.0;
                    for (; i < sums.size() && sums[i].first == site; ++i) {
                        weight += sums[i].second;
                    }
                    exact += weight;
                    if (!(std::abs(weight) < 7.0)) {
                        throw UsageError("a basis function has the value " + text_of(weight) +
                                         " somewhere: only values below 7 in magnitude can be averaged");
                    }
                    row.emplace_back(site, static_cast<std::int32_t>(std::lround(weight / Entry::unit)));
                }
                if (std::abs(exact - 1.0) < 1e-9 && !row.empty()) {
                    round_to_one(row);
                }
                for (const auto& [site, units] : row) {
                    if (units != 0) {
                        parts[b].emplace_back(site, units);
                    }
                }
                first_[s + 1] = static_cast<std::uint32_t>(parts[b].size());
            }
        }
    });
    std::size_t total = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
        for (std::size_t s = b * block; s < std::min((b + 1) * block, surfels.size()); ++s) {
            first_[s + 1] += static_cast<std::uint32_t>(total);
        }
        total += parts[b].size();
        if (total > std::numeric_limits<std::uint32_t>::max()) {
            throw ResourceError("the averages of the basis have more than 2^32 entries: give fewer --sites, or a "
                                "basis whose functions reach less far (--neighbours)");
        }
    }
    entries_.reserve(total);
    for (std::vector<Entry>& part : parts) {
        entries_.insert(entries_.end(), part.begin(), part.end());
        part = {};
    }
}

void BasisAverages::row(Index s, BasisRow& row) const {
    row.clear();
    for (const Entry& entry : entries_of(s)) {
        row.element.push_back(entry.site());
        row.weight.push_back(entry.weight());
    }
}

void BasisAverages::apply(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    y.resize(static_cast<Eigen::Index>(rows()), x.cols());
    parallel_for(rows(), block, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        with_wide_vectors([&] {
            for (std::size_t s = begin; s < end; ++s) {
                average(entries_of(s), x, y.row(static_cast<Eigen::Index>(s)).data());
            }
        });
    });
}

void BasisAverages::reflect(const Values& x, const Values& rho, std::size_t rows, Values& y,
                            const Execution& execution) const {
    reflect_rows(x, rho, rows, y, execution);
}

void BasisAverages::reflect(const SingleValues& x, const Values& rho, std::size_t rows, SingleValues& y,
                            const Execution& execution) const {
    reflect_rows(x, rho, rows, y, execution);
}

template <class Operand>
void BasisAverages::reflect_rows(const Operand& x, const Values& rho, std::size_t rows, Operand& y,
                                 const Execution& execution) const {
    using Number = typename Operand::Scalar;
    const Eigen::Index width = x.cols(), channels = rho.cols(), period = std::min(8 * channels, width);
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_ && rows >= this->rows());
    DIFUSA_REQUIRE(static_cast<std::size_t>(rho.rows()) == this->rows() && width % channels == 0);
    y.resize(static_cast<Eigen::Index>(rows), width);
    parallel_for(rows, block, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        with_wide_vectors([&] {
            std::vector<Number> factors(static_cast<std::size_t>(period));
            for (std::size_t s = begin; s < end; ++s) {
                Number* const out = y.row(static_cast<Eigen::Index>(s)).data();
                if (s >= this->rows()) {
                    std::fill(out, out + width, Number{0});
                    continue;
                }
                average(entries_of(s), x, out);
                scale(rho.row(static_cast<Eigen::Index>(s)).data(), channels, factors, out, width);
            }
        });
    });
}

void BasisAverages::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == rows());
    sum_transposed(rows(), columns_, x.cols(), y, execution, [&](std::size_t s, Values& sum) {
        for (const Entry& entry : entries_of(s)) {
            sum.row(entry.site()) += entry.weight() * x.row(static_cast<Eigen::Index>(s));
        }
    });
}

} // namespace difusa
