#include <difusa/transport/skylight.h>

#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/parallel.h>
#include <difusa/scene/sky_parts.h>

#include <algorithm>
#include <map>
#include <utility>

namespace difusa {

SkylightTransport::SkylightTransport(std::shared_ptr<const HitLists> by_rays, std::size_t surfels,
                                     std::vector<double> scale, std::vector<double> share, SparseRows skylight)
    : by_rays_(std::move(by_rays)), surfels_(surfels), scale_(std::move(scale)), share_(std::move(share)),
      skylight_(std::move(skylight)) {}

Values SkylightTransport::without_sky(const Values& x) const {
    Values dark = x;
    dark.bottomRows(x.rows() - static_cast<Eigen::Index>(surfels_)).setZero();
    return dark;
}

void SkylightTransport::scale_rows(Values& y) const {
    for (Eigen::Index j = 0; j < y.rows(); ++j) {
        y.row(j) *= scale_[static_cast<std::size_t>(j)];
    }
}

void SkylightTransport::apply(const Values& x, Values& y, const Execution& execution) const {
    by_rays_->apply(without_sky(x), y, execution);
    scale_rows(y);
    Values sky;
    skylight_.apply(x, sky, execution);
    y += sky;
}

void SkylightTransport::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    Values scaled = x;
    scale_rows(scaled);
    by_rays_->apply_transpose(scaled, y, execution);
    y.bottomRows(y.rows() - static_cast<Eigen::Index>(surfels_)).setZero();
    Values sky;
    skylight_.apply_transpose(x, sky, execution);
    y += sky;
}

/// That of a ray which meets a surfel, times the share of such rays; of the rays to openings there is none to tell of.
Values SkylightTransport::variance_of_rays(const Values& x, const Execution& execution) const {
    const Values surface = without_sky(x);
    Values mean, square, all_mean, all_square;
    by_rays_->apply(surface, mean, execution);
    by_rays_->apply(surface.cwiseAbs2(), square, execution);
    by_rays_->apply(x, all_mean, execution);
    by_rays_->apply(x.cwiseAbs2(), all_square, execution);
    Values variance(mean.rows(), mean.cols());
    for (Eigen::Index j = 0; j < mean.rows(); ++j) {
        const auto row = static_cast<std::size_t>(j);
        const double share = share_[row];
        variance.row(j) = share < 0.0
                              ? Eigen::RowVectorXd(all_square.row(j) - all_mean.row(j).cwiseAbs2())
                              : Eigen::RowVectorXd(scale_[row] * scale_[row] *
                                                   (square.row(j) - mean.row(j).cwiseAbs2() / std::max(share, 1e-300)));
    }
    return variance.cwiseMax(0.0);
}

std::size_t SkylightTransport::bytes() const {
    return (scale_.size() + share_.size()) * sizeof(double) + skylight_.bytes();
}

LightTransport with_skylight(LightTransport transport, const Tracer& tracer, std::span<const SurfacePoint> points,
                             const Directions& directions, std::uint64_t seed, const Execution& execution) {
    const Mesh& mesh = tracer.mesh();
    if (dynamic_cast<const HitLists*>(transport.W.get()) == nullptr || mesh.mirrors.any() || mesh.glossy.any() ||
        mesh.repetition.any() ||
        std::all_of(transport.sky.begin(), transport.sky.end(), [](double share) { return share == 0.0; })) {
        return transport;
    }
    execution.phase("rays to openings");
    auto openings = SkyOpenings::find(tracer, points, directions, seed, execution);
    transport.segments += openings ? openings->rays() : 0;
    return with_skylight(std::move(transport), tracer, points, {SkyParts::count, SkyParts::at}, std::move(openings),
                         seed, execution);
}

LightTransport with_skylight(LightTransport transport, const Tracer& tracer, std::span<const SurfacePoint> points,
                             const SkyBins& sky, std::shared_ptr<const SkyOpenings> openings, std::uint64_t seed,
                             const Execution& execution) {
    auto lists = std::dynamic_pointer_cast<const HitLists>(transport.W);
    if (!openings || !lists) {
        return transport;
    }
    const auto first_sky = static_cast<Index>(transport.surfels);
    const std::size_t rays = lists->rays(), count = std::max<std::size_t>(32, rays / 4);
    std::vector<double> scale(points.size(), 1.0), share(points.size(), -1.0);
    SparseRows skylight(points.size(), lists->columns());
    std::vector<std::size_t> cast(points.size(), 0);
    parallel_for(points.size(), 64, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        SkyOpenings::View view;
        std::vector<Index> bins;
        std::map<Index, double> parts; // of the sky
        for (std::size_t j = begin; j < end; ++j) {
            RandomStream stream(seed, "rays to openings", j);
            parts.clear();
            lists->row(j, bins);
            const auto surface = std::count_if(bins.begin(), bins.end(), [&](Index bin) { return bin < first_sky; });
            const double each = 1.0 / static_cast<double>(rays);
            const double back = static_cast<double>(rays - bins.size()) * each;
            const double others = static_cast<double>(surface) * each + back;
            transport.back[j] = back;
            if (others > 0.0 && view.look(tracer, *openings, points[j], count, stream)) {
                double seen = 0.0;
                view.for_each([&](const Vec3& direction, double weight) {
                    parts[first_sky + sky.at(direction)] += weight;
                    seen += weight;
                });
                scale[j] = std::max(0.0, 1.0 - seen) / others;
                share[j] = others;
                transport.sky[j] = seen;
                transport.back[j] *= scale[j];
                cast[begin] += count;
            } else {
                for (const Index bin : bins) {
                    if (bin >= first_sky) {
                        parts[bin] += each;
                    }
                }
                transport.sky[j] = static_cast<double>(bins.size() - static_cast<std::size_t>(surface)) * each;
            }
            for (const auto& [bin, weight] : parts) {
                skylight.row(j).column.push_back(bin);
                skylight.row(j).value.push_back(weight);
            }
        }
    });
    for (const std::size_t each : cast) {
        transport.segments += each;
    }
    transport.openings = std::move(openings);
    auto W = std::make_shared<const SkylightTransport>(std::move(lists), transport.surfels, std::move(scale),
                                                       std::move(share), std::move(skylight));
    transport.bytes += W->bytes();
    transport.W = std::move(W);
    return transport;
}

} // namespace difusa
