#include <difusa/transport/skylight.h>

#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/scene/sky_parts.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

namespace difusa {

namespace {

/// The rays of a row that escape through openings: found again, for the row says in which parts of the sky rays end,
/// not where they leave the scene.
class ThroughOpenings {
  public:
    ThroughOpenings(const Tracer& tracer, const DirectionPool& pool, const SkyOpenings& openings, const SkyBins& sky)
        : tracer_(tracer), openings_(openings), sky_(sky), around_(tracer, pool) {}

    /// Of point j, whose rays end in these bins, in ascending order: takes those of the rays out of it.
    void remove(const SurfacePoint& x, std::size_t j, Index first_sky, std::vector<Index>& bins) {
        rays_.clear();
        if (!bins.empty() && bins.back() >= first_sky) {
            around_.aim(x, j);
            std::copy_if(around_.rays().begin(), around_.rays().end(), std::back_inserter(rays_),
                         [&](const Ray& ray) { return openings_.contain(ray.origin, ray.direction); });
        }
        hits_.resize(rays_.size());
        tracer_.first_hits(rays_, hits_);
        through_.clear();
        for (std::size_t d = 0; d < rays_.size(); ++d) {
            if (hits_[d].face == none) {
                through_.push_back(first_sky + sky_.at(rays_[d].direction));
            }
        }
        std::sort(through_.begin(), through_.end());
        left_.clear();
        std::set_difference(bins.begin(), bins.end(), through_.begin(), through_.end(), std::back_inserter(left_));
        bins.swap(left_);
    }

    std::size_t cast() const { return rays_.size(); } ///< for the last point

  private:
    const Tracer tracer_;
    const SkyOpenings& openings_;
    const SkyBins& sky_;
    Hemisphere around_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<Index> through_, left_;
};

/// The shares of a row that escape and that hit backs.
void count_shares(const HitLists& lists, std::size_t j, Index first_sky, std::vector<Index>& bins, double& sky,
                  double& back) {
    lists.row(j, bins);
    const double each = 1.0 / static_cast<double>(lists.rays());
    sky = 0.0;
    double front = 0.0; // summed as GatheredRows does
    for (const Index bin : bins) {
        (bin < first_sky ? front : sky) += each;
    }
    back = bins.size() == lists.rays() ? 0.0 : std::max(0.0, 1.0 - front - sky);
}

} // namespace

SkylightTransport::SkylightTransport(std::shared_ptr<const HitLists> by_rays, std::size_t surfels,
                                     std::vector<Row> rows, SparseRows skylight, std::size_t segments)
    : by_rays_(std::move(by_rays)), surfels_(surfels), rows_(std::move(rows)), skylight_(std::move(skylight)),
      segments_(segments) {}

Values SkylightTransport::without_sky(const Values& x) const {
    Values dark = x;
    dark.bottomRows(x.rows() - static_cast<Eigen::Index>(surfels_)).setZero();
    return dark;
}

void SkylightTransport::scale_rows(Values& y) const {
    for (Eigen::Index j = 0; j < y.rows(); ++j) {
        y.row(j) *= rows_[static_cast<std::size_t>(j)].scale;
    }
}

template <class Operand> bool SkylightTransport::is_sky_dark(const Operand& x) const {
    return (x.bottomRows(x.rows() - static_cast<Eigen::Index>(surfels_)).array() == 0).all();
}

void SkylightTransport::apply_single(const SingleValues& x, Values& y, const Execution& execution) const {
    if (!is_sky_dark(x)) {
        apply(Values(x.cast<double>()), y, execution);
        return;
    }
    by_rays_->apply_single(x, y, execution);
    scale_rows(y);
}

void SkylightTransport::apply(const Values& x, Values& y, const Execution& execution) const {
    if (is_sky_dark(x)) {
        by_rays_->apply(x, y, execution);
        scale_rows(y);
        return;
    }
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

/// That of a ray which meets a surfel, times the share of such rays, and that of an aimed ray, times the number of rays
/// over that of these: as if they were independent.
Values SkylightTransport::variance_of_rays(const Values& x, const Execution& execution) const {
    const Values surface = without_sky(x), sky = x - surface;
    Values mean, square, sky_mean, sky_square, seen, seen_square;
    by_rays_->apply(surface, mean, execution);
    by_rays_->apply(surface.cwiseAbs2(), square, execution);
    by_rays_->apply(sky, sky_mean, execution);
    by_rays_->apply(sky.cwiseAbs2(), sky_square, execution);
    skylight_.apply(x, seen, execution);
    skylight_.apply(x.cwiseAbs2(), seen_square, execution);
    const double rays = static_cast<double>(by_rays_->rays()),
                 per_aimed = rays / static_cast<double>(SkyOpenings::aimed(by_rays_->rays()));
    Values variance(mean.rows(), mean.cols());
    for (Eigen::Index j = 0; j < mean.rows(); ++j) {
        const Row& row = rows_[static_cast<std::size_t>(j)];
        if (row.share < 0.0) {
            variance.row(j) = square.row(j) + sky_square.row(j) - (mean.row(j) + sky_mean.row(j)).cwiseAbs2();
            continue;
        }
        const Eigen::RowVectorXd of_aimed = row.aimed_at * seen_square.row(j) - seen.row(j).cwiseAbs2();
        variance.row(j) =
            row.scale * row.scale * (square.row(j) - mean.row(j).cwiseAbs2() / std::max(row.share, 1e-300)) +
            per_aimed * of_aimed.cwiseMax(0.0);
    }
    return variance.cwiseMax(0.0);
}

std::size_t SkylightTransport::bytes() const {
    return rows_.size() * sizeof(Row) + skylight_.bytes();
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
    return with_skylight(std::move(transport), tracer, points, {SkyParts::count, SkyParts::at}, std::move(openings),
                         directions, seed, execution);
}

LightTransport with_skylight(LightTransport transport, const Tracer& tracer, std::span<const SurfacePoint> points,
                             const SkyBins& sky, std::shared_ptr<const SkyOpenings> openings,
                             const Directions& directions, std::uint64_t seed, const Execution& execution) {
    auto lists = std::dynamic_pointer_cast<const HitLists>(transport.W);
    if (!openings || !lists) {
        return transport;
    }
    const auto first_sky = static_cast<Index>(transport.surfels);
    const std::size_t rays = lists->rays(), count = SkyOpenings::aimed(rays);
    const DirectionPool pool(directions, rays, seed);
    DIFUSA_REQUIRE(pool.count() == rays, "the transport has other rays");
    std::vector<SkylightTransport::Row> rows(points.size());
    SparseRows skylight(points.size(), lists->columns());
    std::vector<std::size_t> cast(points.size(), 0);
    parallel_for(points.size(), 64, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        SkyOpenings::View view;
        ThroughOpenings through(tracer, pool, *openings, sky);
        std::vector<Index> bins;
        std::map<Index, double> parts; // of the sky
        for (std::size_t j = begin; j < end; ++j) {
            RandomStream stream(seed, "rays to openings", j);
            parts.clear();
            count_shares(*lists, j, first_sky, bins, transport.sky[j], transport.back[j]);
            const double each = 1.0 / static_cast<double>(rays), others = 1.0 - transport.sky[j];
            if (others > 0.0 && view.look(tracer, *openings, points[j], count, stream)) {
                double seen = 0.0;
                view.for_each([&](const Vec3& direction, double weight) {
                    parts[first_sky + sky.at(direction)] += weight;
                    seen += weight;
                });
                // Rays that escape elsewhere, as through a window that was not found, still count.
                through.remove(points[j], j, first_sky, bins);
                for (const Index bin : bins) {
                    if (bin >= first_sky) {
                        parts[bin] += each;
                        seen += each;
                    }
                }
                rows[j] = {std::max(0.0, 1.0 - seen) / others, others, view.weight()};
                transport.sky[j] = seen;
                transport.back[j] *= rows[j].scale;
                cast[begin] += count + through.cast();
            } else {
                for (const Index bin : bins) {
                    if (bin >= first_sky) {
                        parts[bin] += each;
                    }
                }
            }
            skylight.row(j).column.reserve(parts.size());
            skylight.row(j).value.reserve(parts.size());
            for (const auto& [bin, weight] : parts) {
                skylight.row(j).column.push_back(bin);
                skylight.row(j).value.push_back(weight);
            }
        }
    });
    std::size_t segments = openings->rays();
    for (const std::size_t each : cast) {
        segments += each;
    }
    execution.count("segments", segments);
    transport.segments += segments;
    transport.openings = std::move(openings);
    auto W = std::make_shared<const SkylightTransport>(std::move(lists), transport.surfels, std::move(rows),
                                                       std::move(skylight), segments);
    transport.bytes += W->bytes();
    transport.W = std::move(W);
    return transport;
}

LightTransport by_rays_alone(LightTransport transport) {
    const auto W = std::dynamic_pointer_cast<const SkylightTransport>(transport.W);
    if (!W) {
        return transport;
    }
    std::vector<Index> bins;
    for (std::size_t j = 0; j < transport.points(); ++j) {
        count_shares(W->by_rays(), j, static_cast<Index>(transport.surfels), bins, transport.sky[j], transport.back[j]);
    }
    transport.segments -= W->segments();
    transport.bytes -= W->bytes();
    transport.openings = nullptr;
    transport.W = W->lists();
    return transport;
}

} // namespace difusa
