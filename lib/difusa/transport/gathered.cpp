#include <difusa/transport/gathered.h>

#include <difusa/algebra/hit_lists.h>
#include <difusa/algebra/sparse_rows.h>
#include <difusa/core/parallel.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/mirrored.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace difusa {

namespace {

/// The bins of one point's rays, with their weights.
struct Bins {
    std::vector<Index> bin;
    std::vector<double> weight;
};

/// What the points see in mirrors.
class InMirrors {
  public:
    InMirrors(const Surfels& surfels, const SkyBins& sky, const Mirrors& mirrors, std::size_t points,
              LightTransport& transport)
        : surfels_(surfels), sky_(sky), channels_(mirrors.is_grey() ? 1 : 3), transport_(transport),
          rows_(std::make_shared<ChannelRows>(points, surfels.size() + sky.count, channels_)) {
        const auto count = static_cast<Eigen::Index>(points);
        transport.back_in_mirrors.setZero(count, channels_);
        transport.cut_off.setZero(count, channels_);
    }

    /// Sets the row of point j to what `around` has seen; `entries` is scratch.
    void set(std::size_t j, const Hemisphere& around, std::vector<std::pair<Index, Rgb>>& entries) {
        entries.clear();
        const auto first_sky = static_cast<Index>(surfels_.size());
        around.for_each_in_mirrors(
            [&](const Hit& hit, double weight, const Rgb& colour) {
                entries.emplace_back(surfels_.at(hit.face, hit.u, hit.v), weight * colour);
            },
            [&](const Vec3& direction, double weight, const Rgb& colour) {
                entries.emplace_back(first_sky + sky_.at(direction), weight * colour);
            },
            [&](double weight, const Rgb& colour, bool cut_off) {
                Values& lost = cut_off ? transport_.cut_off : transport_.back_in_mirrors;
                lost.row(static_cast<Eigen::Index>(j)) += (weight * colour.head(channels_)).matrix().transpose();
            });
        rows_->set(j, entries);
    }

    std::shared_ptr<const ChannelRows> rows() const { return rows_; }

  private:
    const Surfels& surfels_;
    const SkyBins& sky_;
    int channels_;
    LightTransport& transport_;
    std::shared_ptr<ChannelRows> rows_;
};

/// A row of weights by bin.
void put(Bins& bins, std::vector<std::pair<Index, double>>& order, SparseRows::Row& row) {
    order.clear();
    for (std::size_t k = 0; k < bins.bin.size(); ++k) {
        order.emplace_back(bins.bin[k], bins.weight[k]);
    }
    std::sort(order.begin(), order.end());
    std::size_t distinct = 0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        distinct += k == 0 || order[k].first != order[k - 1].first ? 1U : 0U;
    }
    row.column.reserve(distinct);
    row.value.reserve(distinct);
    for (const auto& [bin, weight] : order) {
        if (row.column.empty() || row.column.back() != bin) {
            row.column.push_back(bin);
            row.value.push_back(0.0);
        }
        row.value.back() += weight;
    }
}

} // namespace

LightTransport gathered(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels,
                        const SkyBins& sky_bins, const Directions& directions, std::size_t rays, std::uint64_t seed,
                        const Execution& execution) {
    const DirectionPool pool(directions, rays, seed);
    const std::size_t columns = surfels.size() + sky_bins.count;
    // A range of a few thousand rays: short enough to stop soon when cancelled.
    const std::size_t grain = std::clamp<std::size_t>(4096 / pool.count(), 1, 16);
    LightTransport transport;
    transport.surfels = surfels.size();
    transport.sky.assign(points.size(), 0.0);
    transport.back.assign(points.size(), 0.0);
    transport.rays = points.size() * pool.count();
    auto lists = pool.equal_weights() ? std::make_shared<HitLists>(points.size(), columns, pool.count(), grain)
                                      : std::shared_ptr<HitLists>();
    auto weighted = lists ? std::shared_ptr<SparseRows>() : std::make_shared<SparseRows>(points.size(), columns);
    const Mirrors& mirrors = tracer.mesh().mirrors;
    std::optional<InMirrors> in_mirrors;
    if (mirrors.any()) {
        in_mirrors.emplace(surfels, sky_bins, mirrors, points.size(), transport);
    }
    const auto first_sky = static_cast<Index>(surfels.size());
    parallel_for(points.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        Hemisphere around(tracer, pool);
        Bins bins;
        std::vector<std::pair<Index, double>> order;
        std::vector<std::pair<Index, Rgb>> reflected;
        for (std::size_t j = begin; j < end; ++j) {
            around.look(points[j], j);
            bins.bin.clear();
            bins.weight.clear();
            double front = 0.0, sky = 0.0;
            around.for_each(
                [&](const Hit& hit, double weight) {
                    bins.bin.push_back(surfels.at(hit.face, hit.u, hit.v));
                    bins.weight.push_back(weight);
                    front += weight;
                },
                [&](const Vec3& direction, double weight) {
                    bins.bin.push_back(first_sky + sky_bins.at(direction));
                    bins.weight.push_back(weight);
                    sky += weight;
                });
            transport.sky[j] = sky;
            transport.back[j] = bins.bin.size() == around.count() ? 0.0 : std::max(0.0, 1.0 - front - sky);
            if (lists) {
                lists->set(j, bins.bin);
            } else {
                put(bins, order, weighted->row(j));
            }
            if (in_mirrors) {
                in_mirrors->set(j, around, reflected);
            }
        }
        if (lists) {
            lists->close_block(begin);
        }
    });
    transport.bytes = lists ? lists->bytes() : weighted->bytes();
    transport.W = lists ? std::static_pointer_cast<const LinearOperator>(lists) : weighted;
    if (in_mirrors) {
        transport.bytes += in_mirrors->rows()->bytes();
        transport.W = std::make_shared<MirroredTransport>(transport.W, in_mirrors->rows());
    }
    return transport;
}

LightTransport gathered(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels,
                        const Directions& directions, std::size_t rays, std::uint64_t seed,
                        const Execution& execution) {
    return gathered(tracer, points, surfels, {SkyParts::count, SkyParts::at}, directions, rays, seed, execution);
}

} // namespace difusa
