#include <difusa/radiosity/daylight.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/radiosity/response.h>
#include <difusa/rays/sky_openings.h>
#include <difusa/transport/gathered.h>
#include <difusa/transport/skylight.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

namespace difusa {

namespace {

/// The rays of one point into the cells of the sky. Their weights are parts of the irradiance at a radiance of 1.
class CellRays final : public Sight {
  public:
    CellRays(const Tracer& tracer, const SkyDivision& sky, const std::vector<SkyCell>& cells)
        : Sight(tracer), sky_(sky), cells_(cells) {
        for (const SkyCell& cell : cells) {
            moment_.push_back(sky.moment(cell));
        }
        place_.resize(cells.size());
    }

    void look(const SurfacePoint& x, RandomStream stream) {
        const SurfacePoint from = inset(tracer_.mesh(), x);
        sort_cells(x.normal);
        rays_.clear();
        weight_.clear();
        cut_.clear();
        double parted = 0.0;
        for (std::size_t k = 0; k < cells_.size(); ++k) {
            const double u = stream.uniform(), v = stream.uniform();
            if (place_[k] == Place::below) {
                continue;
            }
            const Vec3 towards = sky_.direction(cells_[k], u, v);
            const bool is_whole = place_[k] == Place::above;
            const double weight = is_whole ? moment_[k].dot(x.normal) : cells_[k].solid_angle() * x.normal.dot(towards);
            if (!(weight > 0.0)) {
                continue;
            }
            if (!is_whole) {
                parted += weight;
                cut_.push_back(rays_.size());
            }
            rays_.push_back({from.position, towards, from.face});
            weight_.push_back(weight);
        }
        const double factor = parted > 0.0 ? std::max(0.0, (std::numbers::pi - whole_) / parted) : 0.0;
        for (const std::size_t k : cut_) {
            weight_[k] *= factor;
        }
        weights_ = weight_;
        lift(x);
        cast();
    }

    /// Where the rays of the last point start.
    const Vec3& origin() const { return rays_.front().origin; }

  private:
    enum class Place : char { below, cut, above };

    /// Where the cells are from a plane; most often it is parallel to the latest.
    void sort_cells(const Vec3& normal) {
        if (normal == normal_) {
            return;
        }
        normal_ = normal;
        whole_ = 0.0;
        for (std::size_t k = 0; k < cells_.size(); ++k) {
            const double share = moment_[k].dot(normal);
            place_[k] = share > 0.0 && sky_.is_above(cells_[k], normal)    ? Place::above
                        : share < 0.0 && sky_.is_above(cells_[k], -normal) ? Place::below
                                                                           : Place::cut;
            whole_ += place_[k] == Place::above ? share : 0.0;
        }
    }

    const SkyDivision& sky_;
    const std::vector<SkyCell>& cells_;
    std::vector<Vec3> moment_;
    Vec3 normal_ = Vec3::Zero(); ///< that of place_
    std::vector<Place> place_;   ///< #cells
    double whole_ = 0.0;         ///< sum of the weights of those above
    std::vector<double> weight_; ///< #rays
    std::vector<std::size_t> cut_;
};

class DaylightComputation {
  public:
    DaylightComputation(const RadiositySystem& system, const Values& reflectance, std::span<const SurfacePoint> x,
                        const SkyDivision& sky, const DaylightOptions& options, const Execution& execution)
        : system_(system), x_(x), sky_(sky), options_(options), execution_(execution),
          cells_(sky.cells(std::max<std::size_t>(1, options.rays / (sky.count() - 1)))) {
        if (system.tracer().mesh().glossy.any()) {
            throw UsageError("daylight coefficients are not computed over glossy materials: give these a diffuse "
                             "reflectance instead");
        }
        const bool grey = system.tracer().mesh().mirrors.is_grey() &&
                          (reflectance.cols() == 1 ||
                           (reflectance.col(0) == reflectance.col(1) && reflectance.col(0) == reflectance.col(2)));
        reflectance_ = grey ? Values(reflectance.col(0)) : reflectance;
        DIFUSA_REQUIRE(reflectance_.cols() == 1 || reflectance_.cols() == 3);
        channels_ = reflectance_.cols();
        result_.channels = static_cast<int>(channels_);
    }

    DaylightCoefficients run() {
        const SystemParts& parts = system_.parts();
        execution_.phase("sky at the sites");
        openings_ = find_openings();
        const std::vector<SurfacePoint>& points = system_.discretisation().points;
        const SkyBins bins{sky_.count(), [this](const Vec3& towards) { return sky_.at(towards); }};
        const LightTransport sites =
            with_skylight(gathered(system_.tracer(), points, *system_.discretisation().surfels, bins, *parts.directions,
                                   options_.site_rays, parts.seed, execution_),
                          system_.tracer(), points, bins, openings_, *parts.directions, parts.seed, execution_);
        result_.site_rays = sites.rays;
        const auto count = static_cast<Eigen::Index>(sky_.count());
        result_.value.setZero(static_cast<Eigen::Index>(x_.size()), count * channels_);
        const auto bytes_of_part = static_cast<std::size_t>(channels_) * sizeof(double) *
                                   std::max<std::size_t>(1, system_.discretisation().surfels->size());
        const auto group = static_cast<Eigen::Index>(std::max<std::size_t>(1, options_.most_bytes / bytes_of_part));
        for (Eigen::Index first = 0; first < count; first += group) {
            const Eigen::Index end = std::min(count, first + group);
            const Values b = reflected(sites, first, end);
            gather(b, first, end);
        }
        return std::move(result_);
    }

  private:
    /// Those of the transport, which has none where no sky shone, or found again.
    std::shared_ptr<const SkyOpenings> find_openings() const {
        const Mesh& mesh = system_.tracer().mesh();
        if (system_.transport().openings || mesh.mirrors.any() || mesh.repetition.any()) {
            return system_.transport().openings;
        }
        const SystemParts& parts = system_.parts();
        return SkyOpenings::find(system_.tracer(), system_.discretisation().points, *parts.directions, parts.seed,
                                 execution_);
    }

    /// The radiosity of the surfels for a radiance of 1 in each of these parts.
    Values reflected(const LightTransport& sites, Eigen::Index first, Eigen::Index end) {
        execution_.phase("solve for the sky");
        const Discretisation& discretisation = system_.discretisation();
        const auto surfels = static_cast<Eigen::Index>(sites.surfels);
        const Eigen::Index columns = (end - first) * channels_;
        Values b(surfels, columns);
        const Eigen::Index block = std::max<Eigen::Index>(1, columns_at_once(sites) / channels_);
        for (Eigen::Index from = first; from < end; from += block) {
            const Eigen::Index to = std::min(end, from + block);
            Values sky = Values::Zero(static_cast<Eigen::Index>(sky_.count()), (to - from) * channels_);
            for (Eigen::Index part = from; part < to; ++part) {
                sky.row(part).segment((part - from) * channels_, channels_).setConstant(std::numbers::pi);
            }
            Values g, reflected;
            sites.gather(Values::Zero(surfels, sky.cols()), sky, g, Unreported(execution_));
            const Values h = solve_for(system_, reflectance_, g, options_.solve, Unreported(execution_));
            discretisation.averages->reflect(discretisation.evaluation->coefficients(h, Unreported(execution_)),
                                             reflectance_, sites.surfels, reflected, Unreported(execution_));
            b.middleCols((from - first) * channels_, reflected.cols()) = reflected;
            if (execution_.progress != nullptr) {
                execution_.progress->advance(static_cast<double>(to - first) / static_cast<double>(end - first));
            }
        }
        return b;
    }

    struct Worker {
        Worker(const Tracer& tracer, const SkyDivision& sky, const std::vector<SkyCell>& cells)
            : rays(tracer, sky, cells) {}

        CellRays rays;
        SkyOpenings::View view;
    };

    /// Rays aimed at openings in place of others that escape there, and the factor on the weights of what is left.
    struct Aimed {
        std::size_t rays = 0;
        double scale = 1.0;
    };

    /// At point i, to which the worker's other rays belong.
    Aimed aim(std::size_t i, Worker& worker) const {
        const std::size_t count = SkyOpenings::aimed(options_.rays);
        RandomStream stream(options_.seed, "daylight through openings", i);
        if (!openings_ || !worker.view.look(system_.tracer(), *openings_, x_[i], count, stream)) {
            return {};
        }
        double replaced = 0.0, seen = 0.0; // shares of the hemisphere
        worker.rays.for_each([](const Hit&, double) {},
                             [&](const Vec3& direction, double weight) {
                                 if (openings_->contain(worker.rays.origin(), direction)) {
                                     replaced += weight * std::numbers::inv_pi;
                                 }
                             });
        worker.view.for_each([&](const Vec3&, double weight) { seen += weight; });
        return {count, replaced < 1.0 ? std::max(0.0, 1.0 - seen) / (1.0 - replaced) : 0.0};
    }

    /// The columns of these parts at the points. The rays are the same for all groups of parts.
    void gather(const Values& b, Eigen::Index first, Eigen::Index end) {
        execution_.phase("sky at the points");
        const Surfels& surfels = *system_.discretisation().surfels;
        std::vector<std::size_t> cast(x_.size(), 0);
        std::vector<std::unique_ptr<Worker>> workers(execution_.threads);
        parallel_for(x_.size(), 4, execution_, [&](std::size_t begin, std::size_t last, unsigned worker) {
            if (!workers[worker]) {
                workers[worker] = std::make_unique<Worker>(system_.tracer(), sky_, cells_);
            }
            CellRays& rays = workers[worker]->rays;
            const SkyOpenings::View& view = workers[worker]->view;
            for (std::size_t i = begin; i < last; ++i) {
                rays.look(x_[i], RandomStream(options_.seed, "daylight", i));
                const Aimed aimed = aim(i, *workers[worker]);
                cast[i] = rays.count() + aimed.rays;
                auto row = result_.value.row(static_cast<Eigen::Index>(i))
                               .segment(first * channels_, (end - first) * channels_);
                const auto on_sky = [&](const Vec3& direction, double weight, const Rgb& colour) {
                    const auto p = static_cast<Eigen::Index>(sky_.at(direction));
                    if (p >= first && p < end) {
                        row.segment((p - first) * channels_, channels_) +=
                            weight * colour.head(channels_).matrix().transpose();
                    }
                };
                const auto on_front = [&](const Hit& hit, double weight, const Rgb& colour) {
                    add_surfel(row, b.row(static_cast<Eigen::Index>(surfels.at(hit.face, hit.u, hit.v))),
                               weight * std::numbers::inv_pi, colour);
                };
                rays.for_each([&](const Hit& hit, double weight) { on_front(hit, aimed.scale * weight, Rgb::Ones()); },
                              [&](const Vec3& direction, double weight) {
                                  if (aimed.rays == 0 || !openings_->contain(rays.origin(), direction)) {
                                      on_sky(direction, aimed.scale * weight, Rgb::Ones());
                                  }
                              });
                if (aimed.rays > 0) {
                    view.for_each([&](const Vec3& direction, double weight) {
                        on_sky(direction, std::numbers::pi * weight, Rgb::Ones());
                    });
                }
                rays.for_each_in_mirrors(on_front, on_sky, [](double, const Rgb&, bool) {});
            }
        });
        result_.rays = 0;
        for (const std::size_t each : cast) {
            result_.rays += each;
        }
    }

    template <class Row, class Radiosity>
    void add_surfel(Row& row, const Radiosity& b, double share, const Rgb& colour) const {
        if (channels_ == 1 || (colour == colour[0]).all()) {
            row += share * colour[0] * b;
            return;
        }
        for (Eigen::Index c = 0; c < b.size(); ++c) {
            row[c] += share * colour[c % channels_] * b[c];
        }
    }

    const RadiositySystem& system_;
    const std::span<const SurfacePoint> x_;
    const SkyDivision& sky_;
    const DaylightOptions& options_;
    const Execution& execution_;
    const std::vector<SkyCell> cells_;
    std::shared_ptr<const SkyOpenings> openings_; ///< or null
    Values reflectance_;
    Eigen::Index channels_ = 3;
    DaylightCoefficients result_;
};

} // namespace

Values DaylightCoefficients::irradiance(const Values& radiance) const {
    DIFUSA_REQUIRE(radiance.cols() == 3 && radiance.rows() * channels == value.cols());
    Values sum(value.rows(), 3);
    for (int c = 0; c < 3; ++c) {
        const Values own = value(Eigen::all, Eigen::seqN(channels == 1 ? 0 : c, radiance.rows(), channels));
        sum.col(c) = own * radiance.col(c);
    }
    return sum;
}

DaylightCoefficients daylight_coefficients(const RadiositySystem& system, const Values& reflectance,
                                           std::span<const SurfacePoint> x, const SkyDivision& sky,
                                           const DaylightOptions& options, const Execution& execution) {
    return DaylightComputation(system, reflectance, x, sky, options, execution).run();
}

} // namespace difusa
