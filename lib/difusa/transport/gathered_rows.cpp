#include <difusa/transport/gathered_rows.h>

#include <difusa/core/error.h>
#include <difusa/transport/mirrored.h>

#include <algorithm>

namespace difusa {

namespace {

/// A row of weights by bin.
void put(const std::vector<Index>& bin, const std::vector<double>& weight, std::vector<std::pair<Index, double>>& order,
         SparseRows::Row& row) {
    order.clear();
    for (std::size_t k = 0; k < bin.size(); ++k) {
        order.emplace_back(bin[k], weight[k]);
    }
    std::sort(order.begin(), order.end());
    std::size_t distinct = 0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        distinct += k == 0 || order[k].first != order[k - 1].first ? 1U : 0U;
    }
    row.column.reserve(distinct);
    row.value.reserve(distinct);
    for (const auto& [column, share] : order) {
        if (row.column.empty() || row.column.back() != column) {
            row.column.push_back(column);
            row.value.push_back(0.0);
        }
        row.value.back() += share;
    }
}

} // namespace

GatheredRows::GatheredRows(const Tracer& tracer, std::span<const SurfacePoint> all, const Surfels& surfels,
                           const SkyBins& sky, const DirectionPool& pool, std::size_t rows_per_block)
    : surfels_(surfels), sky_(sky), pool_(pool), first_sky_(static_cast<Index>(surfels.size())) {
    const std::size_t points = all.size();
    const std::size_t columns = surfels.size() + sky.count;
    transport_.surfels = surfels.size();
    transport_.sky.assign(points, 0.0);
    transport_.back.assign(points, 0.0);
    transport_.rays = points * pool.count();
    if (pool.equal_weights()) {
        lists_ = std::make_shared<HitLists>(points, columns, pool.count(), rows_per_block);
    } else {
        weighted_ = std::make_shared<SparseRows>(points, columns);
    }
    if (const Mirrors& mirrors = tracer.mesh().mirrors; mirrors.any()) {
        in_mirrors_ = std::make_shared<ChannelRows>(points, columns, mirrors.is_grey() ? 1 : 3);
        const auto count = static_cast<Eigen::Index>(points);
        transport_.back_in_mirrors.setZero(count, in_mirrors_->channels());
        transport_.cut_off.setZero(count, in_mirrors_->channels());
    } else if (!tracer.mesh().repetition.endless.empty()) {
        transport_.back_in_mirrors.setZero(static_cast<Eigen::Index>(points), 1);
        transport_.cut_off.setZero(static_cast<Eigen::Index>(points), 1);
    }
    if (tracer.mesh().glossy.any()) {
        glossy_ = std::make_shared<GlossyRays>(tracer.mesh(), surfels, all);
    }
}

void GatheredRows::set(std::size_t j, const Sight& around, Scratch& scratch) {
    std::vector<Index>& bin = scratch.bin;
    std::vector<double>& share = scratch.weight;
    bin.clear();
    share.clear();
    double front = 0.0, sky = 0.0;
    around.for_each(
        [&](const Hit& hit, double weight) {
            bin.push_back(surfels_.at(hit.face, hit.u, hit.v));
            share.push_back(weight);
            front += weight;
        },
        [&](const Vec3& direction, double weight) {
            bin.push_back(first_sky_ + sky_.at(direction));
            share.push_back(weight);
            sky += weight;
        });
    if (lists_) {
        set_bins(j, bin);
    } else {
        transport_.sky[j] = sky;
        transport_.back[j] = bin.size() == around.count() ? 0.0 : std::max(0.0, 1.0 - front - sky);
        put(bin, share, scratch.order, weighted_->row(j));
    }
    if (glossy_) {
        glossy_->set(j, around, [&](const Hit& hit, const Vec3& direction) { return bin_of(hit, direction); });
    }
    if (in_mirrors_) {
        set_in_mirrors(j, around, scratch);
    } else if (transport_.cut_off.rows() > 0) {
        const double cut_off = around.cut_off();
        transport_.cut_off(static_cast<Eigen::Index>(j), 0) = cut_off;
        transport_.back[j] = std::max(0.0, transport_.back[j] - cut_off);
    }
}

void GatheredRows::set_bins(std::size_t j, std::vector<Index>& bins) {
    const double weight = 1.0 / static_cast<double>(pool_.count());
    double front = 0.0, sky = 0.0;
    for (const Index bin : bins) {
        (bin < first_sky_ ? front : sky) += weight;
    }
    transport_.sky[j] = sky;
    transport_.back[j] = bins.size() == pool_.count() ? 0.0 : std::max(0.0, 1.0 - front - sky);
    lists_->set(j, bins);
}

void GatheredRows::keep(std::size_t j, const LightTransport& from, const std::vector<Index>& numbers, bool same,
                        Scratch& scratch) {
    const auto number_of = [&](Index bin) {
        const Index number =
            bin < numbers.size() ? numbers[bin] : bin - static_cast<Index>(numbers.size()) + first_sky_;
        DIFUSA_REQUIRE(number != none, "a ray that is kept ends where the surface has changed");
        return number;
    };
    transport_.sky[j] = from.sky[j];
    transport_.back[j] = from.back[j];
    const LinearOperator& plain = plain_part(*from.W);
    if (lists_) {
        const auto& lists = dynamic_cast<const HitLists&>(plain);
        if (same) {
            lists_->copy(j, lists);
            return;
        }
        lists.row(j, scratch.bin);
        for (Index& bin : scratch.bin) {
            bin = number_of(bin);
        }
        lists_->set(j, scratch.bin);
        return;
    }
    SparseRows::Row& row = weighted_->row(j);
    row = plain.entries()->row(j);
    for (Index& column : row.column) { // surfels that stay keep their order
        column = number_of(column);
    }
}

void GatheredRows::set_in_mirrors(std::size_t j, const Sight& around, Scratch& scratch) {
    auto& entries = scratch.reflected;
    const int channels = in_mirrors_->channels();
    entries.clear();
    around.for_each_in_mirrors(
        [&](const Hit& hit, double weight, const Rgb& colour) {
            entries.emplace_back(surfels_.at(hit.face, hit.u, hit.v), weight * colour);
        },
        [&](const Vec3& direction, double weight, const Rgb& colour) {
            entries.emplace_back(first_sky_ + sky_.at(direction), weight * colour);
        },
        [&](double weight, const Rgb& colour, bool cut_off) {
            Values& lost = cut_off ? transport_.cut_off : transport_.back_in_mirrors;
            lost.row(static_cast<Eigen::Index>(j)) += (weight * colour.head(channels)).matrix().transpose();
        });
    in_mirrors_->set(j, entries);
}

void GatheredRows::close_block(std::size_t first_row) {
    if (lists_) {
        lists_->close_block(first_row);
    }
}

LightTransport GatheredRows::finish() {
    transport_.bytes = lists_ ? lists_->bytes() : weighted_->bytes();
    transport_.W = lists_ ? std::static_pointer_cast<const LinearOperator>(lists_) : weighted_;
    if (in_mirrors_) {
        transport_.bytes += in_mirrors_->bytes();
        transport_.W = std::make_shared<MirroredTransport>(transport_.W, in_mirrors_);
    }
    if (glossy_) {
        transport_.bytes += glossy_->bytes();
        transport_.glossy = std::move(glossy_);
    }
    return std::move(transport_);
}

} // namespace difusa
