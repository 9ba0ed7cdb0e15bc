#include <difusa/algebra/channel_rows.h>

#include <difusa/algebra/transpose_sum.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <algorithm>

namespace difusa {

ChannelRows::ChannelRows(const Packed& packed) : columns_(packed.columns), channels_(packed.channels) {
    if (channels_ != 1 && channels_ != 3) {
        throw InputError("there are neither one nor three channels");
    }
    rows_ = unpacked_rows(
        packed, static_cast<std::size_t>(channels_), [](double v) { return v >= 0.0 && v <= 1.0 + 1e-9; },
        "are not from 0 to 1");
}

ChannelRows::Packed ChannelRows::packed() const {
    return {packed_rows(rows_, columns_), channels_};
}

void ChannelRows::set(std::size_t i, std::vector<std::pair<Index, Rgb>>& entries) {
    std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    Row& row = rows_[i];
    row = {};
    for (const auto& [column, colour] : entries) {
        if (row.column.empty() || row.column.back() != column) {
            row.column.push_back(column);
            row.value.resize(row.value.size() + static_cast<std::size_t>(channels_), 0.0);
        }
        for (int c = 0; c < channels_; ++c) {
            row.value[row.value.size() - static_cast<std::size_t>(channels_ - c)] += colour[c];
        }
    }
    row.column.shrink_to_fit();
    row.value.shrink_to_fit();
}

std::size_t ChannelRows::bytes() const {
    std::size_t sum = rows_.size() * sizeof(Row);
    for (const Row& row : rows_) {
        sum += row.column.size() * sizeof(Index) + row.value.size() * sizeof(double);
    }
    return sum;
}

std::size_t ChannelRows::entry_count() const {
    std::size_t sum = 0;
    for (const Row& row : rows_) {
        sum += row.column.size();
    }
    return sum;
}

void ChannelRows::check_width(const Values& x) const {
    DIFUSA_REQUIRE(channels_ == 1 || x.cols() == 1 || x.cols() % channels_ == 0);
}

template <class Act>
void ChannelRows::for_each_factor(const Row& row, std::size_t k, Eigen::Index width, const Act& act) const {
    const double* const value = row.value.data() + k * static_cast<std::size_t>(channels_);
    if (channels_ == 3 && width == 1) {
        act(0, std::max({value[0], value[1], value[2]}));
        return;
    }
    for (Eigen::Index c = 0; c < width; ++c) {
        act(c, value[c % channels_]);
    }
}

void ChannelRows::apply(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    check_width(x);
    const Eigen::Index width = x.cols();
    y.resize(static_cast<Eigen::Index>(rows()), width);
    parallel_for(rows(), 64, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const Row& row = rows_[i];
            auto out = y.row(static_cast<Eigen::Index>(i));
            out.setZero();
            for (std::size_t k = 0; k < row.column.size(); ++k) {
                const auto source = x.row(static_cast<Eigen::Index>(row.column[k]));
                for_each_factor(row, k, width, [&](Eigen::Index c, double factor) { out[c] += factor * source[c]; });
            }
        }
    });
}

void ChannelRows::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == rows());
    check_width(x);
    sum_transposed(rows(), columns_, x.cols(), y, execution, [&](std::size_t i, Values& sum) {
        const Row& row = rows_[i];
        const auto source = x.row(static_cast<Eigen::Index>(i));
        for (std::size_t k = 0; k < row.column.size(); ++k) {
            auto out = sum.row(static_cast<Eigen::Index>(row.column[k]));
            for_each_factor(row, k, x.cols(), [&](Eigen::Index c, double factor) { out[c] += factor * source[c]; });
        }
    });
}

} // namespace difusa
