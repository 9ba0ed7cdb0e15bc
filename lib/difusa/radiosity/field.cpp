#include <difusa/radiosity/field.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/exact_correction.h>
#include <difusa/radiosity/gathering_noise.h>
#include <difusa/radiosity/system.h>
#include <difusa/rays/glance.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered_rows.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>

namespace difusa {

namespace {

constexpr std::size_t rays_out_of_reach = 256; ///< gathered at points that no element reaches
constexpr double doubt_of_substitutes = 0.5; ///< standard deviation of light that is substituted there, relative to it
constexpr double most_out_of_reach = 0.1; ///< of the surface: beyond, it lacks sites by intent, or the basis is narrow

/// Elements are not missing by intent, or for want of width.
bool are_elements_everywhere(const FieldParts& parts) {
    return parts.system->discretisation().uncovered <= most_out_of_reach * parts.scene->mesh.area;
}

/// Handles one point at a time with fresh rays; scratch of a thread.
class Gatherer {
  private:
    Eigen::RowVectorXd row_of(const Rgb& c) const { return c.head(parts_.channels).matrix().transpose(); }
    template <class Row> auto of_set(Row& row, Index set) const {
        return row.segment(static_cast<Eigen::Index>(set) * parts_.channels, parts_.channels);
    }

  public:
    /// `means`: over the surfels, for Field::gather_by_surfels; or null. One hit of `stride` corrects them.
    Gatherer(const FieldParts& parts, const Field::SurfelMeans* means, std::size_t stride, const DirectionPool& pool,
             std::uint64_t seed)
        : parts_(parts), means_(means), stride_(stride), scene_(*parts.scene),
          basis_(*parts.system->discretisation().basis), around_(parts.system->tracer(), pool),
          sets_(parts.direct->sets()), seed_(seed), sharp_(sets_.count()), emitted_(sets_.count()),
          samples_emission_(parts.bright && parts.bright->samples_emission()),
          substitutes_(means == nullptr && are_elements_everywhere(parts)) {
        if (means != nullptr) {
            shortcut_.emplace(BrightSurfels::Shortcut{means->first_bounce, means->even, stride_});
        }
    }

    const BrightSurfels::Worker& light() const { return light_; }

    /// The rays of the last point.
    const Hemisphere& around() const { return around_; }
    GatheredRows::Scratch& scratch() { return scratch_; }

    /// Adds what x receives directly from the sky and emitters to `direct`, and the rest to `indirect`. Returns
    /// Irradiance::variance.
    double add(const SurfacePoint& x, std::size_t number, Eigen::Ref<Eigen::RowVectorXd> direct,
               Eigen::Ref<Eigen::RowVectorXd> indirect) {
        sum_ = reflected_out_of_reach_ = Rgb::Zero();
        squares_ = 0.0;
        std::optional<RandomStream> gloss; // of rays that glossy surfaces reflect
        if (scene_.mesh.glossy.any()) {
            gloss.emplace(seed_, "gloss", number);
        }
        around_.look(x, number, gloss ? &*gloss : nullptr);
        met_.clear();
        weight_.clear();
        Rgb sky = Rgb::Zero();
        around_.for_each(
            [&](const Hit& hit, double weight) {
                met_.push_back(scene_.mesh.at(hit.face, hit.u, hit.v));
                weight_.push_back(weight);
            },
            [&](const Vec3& direction, double weight) {
                const Rgb H = weight * (scene_.dome ? std::numbers::pi * scene_.sky_radiance(direction) : scene_.sky);
                sky += H;
                count_ray(H);
            });
        of_set(direct, sets_.sky) += row_of(sky);
        if (parts_.bright) {
            RandomStream stream(seed_, "bounce", number);
            parts_.bright->gather_exactly(x, met_, weight_, around_.count(), stream, light_, sharp_, emitted_,
                                          shortcut_ ? &*shortcut_ : nullptr);
            for (Index set = 0; set < sharp_.size(); ++set) {
                of_set(indirect, set) += row_of(sharp_[set]);
                of_set(direct, set) += row_of(emitted_[set]);
            }
        }
        colour_.clear();
        first_corrected_ = means_ != nullptr ? RandomStream(seed_, "corrected", number).below(stride_) : 0;
        add_surface(direct, indirect);
        if (scene_.mesh.mirrors.any() || gloss) {
            add_mirrored(number, direct, indirect);
        }
        if (!around_.glossy_hits().empty() && parts_.direct->any()) {
            add_glossy(*gloss, indirect);
        }
        return expected_variance(squares_of(sum_), squares_, around_.count()) + add_out_of_reach(direct, indirect);
    }

  private:
    /// Where no element reaches a hit, as in a pit, it receives what x does: H = A + q H, where A is what x receives
    /// without that, and the hits reflect the share q. Exact where all receive the same, and dark where nothing else
    /// arrives. Returns the variance: twice, for the mean of two gathers has the same doubt.
    double add_out_of_reach(const Eigen::Ref<Eigen::RowVectorXd>& direct, Eigen::Ref<Eigen::RowVectorXd> indirect) {
        if (!(reflected_out_of_reach_ > 0.0).any()) {
            return 0.0;
        }
        Eigen::RowVectorXd added(indirect.size());
        for (Eigen::Index column = 0; column < indirect.size(); ++column) {
            const double q = reflected_out_of_reach_[column % parts_.channels];
            added[column] = q < 1.0 ? q / (1.0 - q) * (direct[column] + indirect[column]) : 0.0;
        }
        indirect += added;
        const Values all = sum_of_parts(Values(added), parts_.channels);
        return 2.0 * doubt_of_substitutes * doubt_of_substitutes * all.squaredNorm();
    }

    /// Counts what one ray brings, times its weight, for the variance.
    void count_ray(const Rgb& H) {
        sum_ += H;
        squares_ += squares_of(H);
    }
    double squares_of(const Rgb& H) const {
        double sum = 0.0;
        for (int c = 0; c < parts_.channels; ++c) {
            sum += H[c] * H[c];
        }
        return sum;
    }

    /// What glossy surfaces reflect towards x of the light of sharp sources.
    void add_glossy(RandomStream& stream, Eigen::Ref<Eigen::RowVectorXd> indirect) {
        const std::span<const GlossyHit> hits = around_.glossy_hits();
        met_.clear();
        for (const GlossyHit& each : hits) {
            met_.push_back(scene_.mesh.at(each.hit.face, each.hit.u, each.hit.v));
        }
        parts_.direct->sample_directions(met_, stream, arrivals_, light_.light);
        for (const DirectLight::Arrival& arrival : arrivals_) {
            const GlossyHit& hit = hits[arrival.place];
            const SurfacePoint& y = met_[arrival.place];
            const GlossyLobe& lobe = scene_.mesh.glossy.lobe_of(scene_.mesh.glossy.kind(y.face));
            const double f = std::numbers::pi * lobe.value(y.normal, arrival.towards, -hit.direction.normalized());
            of_set(indirect, arrival.set) += row_of(hit.weight * f * hit.colour * arrival.H);
        }
    }

    /// What x sees in mirrors and glossy surfaces. Small bright places are not sampled through them: their light is
    /// that of the rays.
    void add_mirrored(std::size_t number, Eigen::Ref<Eigen::RowVectorXd> direct,
                      Eigen::Ref<Eigen::RowVectorXd> indirect) {
        met_.clear();
        weight_.clear();
        Rgb sky = Rgb::Zero();
        around_.for_each_in_mirrors(
            [&](const Hit& hit, double weight, const Rgb& colour) {
                met_.push_back(scene_.mesh.at(hit.face, hit.u, hit.v));
                weight_.push_back(weight);
                colour_.push_back(colour);
            },
            [&](const Vec3& direction, double weight, const Rgb& colour) {
                const Rgb H = weight * colour * (std::numbers::pi * scene_.sky_radiance(direction));
                sky += H;
                count_ray(H);
            },
            [](double, const Rgb&, bool) {});
        of_set(direct, sets_.sky) += row_of(sky);
        if (parts_.bright) {
            RandomStream stream(seed_, "bounce in mirrors", number);
            light_.H.resize(met_.size() * sets_.count());
            parts_.direct->sample(met_, stream, light_.H, light_.light);
            for (std::size_t p = 0; p < met_.size(); ++p) {
                const Rgb rho = weight_[p] * colour_[p] * scene_.reflectance(met_[p]);
                for (Index set = 0; set < sets_.count(); ++set) {
                    of_set(indirect, set) += row_of(rho * light_.H[p * sets_.count() + set]);
                }
            }
        }
        add_surface(direct, indirect);
    }

    void add_surface(Eigen::Ref<Eigen::RowVectorXd>& direct, Eigen::Ref<Eigen::RowVectorXd>& indirect) {
        evaluate_basis();
        H_.resize(indirect.size());
        for (std::size_t p = 0; p < met_.size(); ++p) {
            smooth_at(p);
            add_hit(p, direct, indirect);
        }
    }

    /// What hit p emits, and reflects of `H_`.
    void add_hit(std::size_t p, Eigen::Ref<Eigen::RowVectorXd>& direct, Eigen::Ref<Eigen::RowVectorXd>& indirect) {
        const Rgb colour = colour_.empty() ? Rgb(Rgb::Ones()) : colour_[p];
        const Rgb rho = colour * scene_.reflectance(met_[p]);
        if (substitutes_ && rows_[p].element.empty()) {
            reflected_out_of_reach_ += weight_[p] * rho;
        }
        Rgb brought = Rgb::Zero();
        for (Eigen::Index column = 0; column < H_.size(); column += parts_.channels) {
            for (Eigen::Index channel = 0; channel < parts_.channels; ++channel) {
                const double reflected = weight_[p] * (H_[column + channel] * rho[channel]);
                indirect[column + channel] += reflected;
                brought[channel] += reflected;
            }
        }
        const Index material = scene_.mesh.material[met_[p].face];
        const Material& emitter = scene_.materials[material];
        const bool sampled = samples_emission_ && colour_.empty() && emitter.emits_unevenly();
        if (parts_.direct->area_light_materials()[material] == 0 && !sampled && (emitter.emission != 0.0).any()) {
            const Rgb emitted = weight_[p] * (colour * scene_.emission(met_[p]));
            of_set(direct, sets_.material[material]) += row_of(emitted);
            brought += emitted;
        }
        count_ray(brought);
    }

    bool needs_basis(std::size_t p) const { return means_ == nullptr || p % stride_ == first_corrected_; }

    void evaluate_basis() {
        std::span<const SurfacePoint> where = met_;
        if (means_ != nullptr) {
            corrected_.clear();
            for (std::size_t p = first_corrected_; p < met_.size(); p += stride_) {
                corrected_.push_back(met_[p]);
            }
            where = corrected_;
        }
        rows_.resize(std::max(rows_.size(), where.size()));
        basis_.evaluate(where, std::span(rows_).first(where.size()));
    }

    /// Sets `H_` to sum_i c_i phi_i at hit p, or what stands for it.
    void smooth_at(std::size_t p) {
        H_.setZero();
        if (needs_basis(p)) {
            const BasisRow& row = rows_[means_ == nullptr ? p : p / stride_];
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                H_ += row.weight[k] * parts_.smooth.row(static_cast<Eigen::Index>(row.element[k]));
            }
        }
        if (means_ != nullptr) {
            const Index s = parts_.system->discretisation().surfels->at(met_[p].face, met_[p].u, met_[p].v);
            const auto mean = means_->smooth.row(static_cast<Eigen::Index>(s));
            if (needs_basis(p)) {
                H_ = mean + static_cast<double>(stride_) * (H_ - mean);
            } else {
                H_ = mean;
            }
        }
    }

    const FieldParts& parts_;
    const Field::SurfelMeans* means_;
    std::size_t stride_;
    std::optional<BrightSurfels::Shortcut> shortcut_;
    const Scene& scene_;
    const Basis& basis_;
    Hemisphere around_;
    const LightSets& sets_;
    std::uint64_t seed_;
    BrightSurfels::Worker light_;
    std::vector<SurfacePoint> met_;
    std::vector<double> weight_;
    std::vector<Rgb> colour_; ///< of the mirrors on the way; empty: there are none
    std::vector<DirectLight::Arrival> arrivals_;
    std::vector<SurfacePoint> corrected_; ///< hits at which the basis corrects the means
    std::vector<BasisRow> rows_;          ///< there
    std::size_t first_corrected_ = 0;
    Eigen::RowVectorXd H_;
    std::vector<Rgb> sharp_, emitted_;
    bool samples_emission_;                    ///< of emitters with a texture or pattern, except in mirrors
    bool substitutes_;                         ///< light at hits that no element reaches
    Rgb reflected_out_of_reach_ = Rgb::Zero(); ///< the share that such hits reflect to the point
    Rgb sum_ = Rgb::Zero();                    ///< of what the rays bring
    double squares_ = 0.0;                     ///< of that of each
    GatheredRows::Scratch scratch_;
};

} // namespace

void raise_to_zero(Values& H, int channels) {
    const Values sum = sum_of_parts(H, channels);
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
        for (Eigen::Index c = 0; c < H.cols(); ++c) {
            H(i, c) = sum(i, c % channels) < 0.0 ? 0.0 : H(i, c);
        }
    }
}

Values Field::sharp(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                    const Execution& execution, DirectLight::Effort& effort) const {
    return parts_.direct->irradiance(x, channels(), parts_.shadow_rays_per_round, seed, purpose, execution, effort);
}

Irradiance Field::evaluate_smooth(std::span<const SurfacePoint> x, const Execution& execution, bool displayed,
                                  const RowVisitor& visit) const {
    Values both(parts_.smooth.rows(), 2 * parts_.smooth.cols());
    both << parts_.soft_direct, parts_.smooth;
    std::vector<SurfacePoint> inside;
    inside.reserve(x.size());
    for (const SurfacePoint& point : x) {
        inside.push_back(inset(parts_.scene->mesh, point));
    }
    const Basis& basis = *parts_.system->discretisation().basis;
    const Values h = displayed ? evaluate_display(basis, both, inside, execution, visit)
                               : difusa::evaluate(basis, both, inside, execution);
    Irradiance H;
    H.direct = h.leftCols(parts_.smooth.cols());
    H.indirect = h.rightCols(parts_.smooth.cols()) - H.direct;
    return H;
}

Irradiance Field::evaluate(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                           const Execution& execution, const RowVisitor& visit) const {
    Irradiance H = evaluate_smooth(x, execution, true, visit);
    if (!parts_.direct_in_basis) {
        DirectLight::Effort effort;
        H.direct += sharp(x, seed, purpose, execution, effort);
        H.segments = effort.segments;
        H.clear = effort.clear;
    }
    return H;
}

Irradiance Field::gather_smooth(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                                std::string_view purpose, const Execution& execution) const {
    return gather_smooth(x, nullptr, nullptr, rays, seed, purpose, execution);
}

Irradiance Field::gather_by_surfels(std::span<const SurfacePoint> x, const SurfelMeans& means,
                                    const ExactCorrection* correction, std::size_t rays, std::uint64_t seed,
                                    std::string_view purpose, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(means.smooth.rows()) == parts_.system->discretisation().surfels->size() &&
                   means.smooth.cols() == parts_.smooth.cols());
    return gather_smooth(x, &means, correction, rays, seed, purpose, execution);
}

Irradiance Field::gather_smooth(std::span<const SurfacePoint> x, const SurfelMeans* means,
                                const ExactCorrection* correction, std::size_t rays, std::uint64_t seed,
                                std::string_view purpose, const Execution& execution) const {
    // A different seed: the directions must not be those of the sites.
    const std::uint64_t own_seed = RandomStream(seed, purpose).bits();
    const DirectionPool pool(parts_.system->fresh_directions(), rays, own_seed);
    Irradiance result;
    result.direct.setZero(static_cast<Eigen::Index>(x.size()), parts_.smooth.cols());
    result.indirect.setZero(static_cast<Eigen::Index>(x.size()), parts_.smooth.cols());
    result.variance.setZero(static_cast<Eigen::Index>(x.size()), 1);
    result.rays = x.size() * pool.count();
    std::vector<std::unique_ptr<Gatherer>> workers(execution.threads);
    const std::size_t grain = std::clamp<std::size_t>(4096 / pool.count(), 1, 16);
    const SkyBins sky{SkyParts::count, SkyParts::at};
    std::optional<GatheredRows> rows; // of the same rays
    if (correction != nullptr) {
        const RadiositySystem& system = *parts_.system;
        rows.emplace(system.tracer(), x, *system.discretisation().surfels, sky, pool, grain);
    }
    parallel_for(x.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        if (!workers[number]) {
            workers[number] = std::make_unique<Gatherer>(parts_, means, correction != nullptr ? 8 : 16, pool, own_seed);
        }
        for (std::size_t i = begin; i < end; ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            result.variance(row, 0) = workers[number]->add(x[i], i, result.direct.row(row), result.indirect.row(row));
            if (rows) {
                rows->set(i, workers[number]->around(), workers[number]->scratch());
            }
        }
        if (rows) {
            rows->close_block(begin);
        }
    });
    DirectLight::Effort effort;
    for (const auto& worker : workers) {
        if (worker) {
            effort.add(worker->light().light);
        }
    }
    result.segments = effort.segments;
    result.clear = effort.clear;
    if (correction != nullptr) {
        const Irradiance change = correction->of(rows->finish(), execution);
        result.direct += change.direct;
        result.indirect += change.indirect;
        result.variance.setZero(); // what is left is little, and unknown
    }
    return result;
}

Irradiance Field::gather(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                         std::string_view purpose, const Execution& execution,
                         const ExactCorrection* correction) const {
    DirectLight::Effort effort;
    const Values light = sharp(x, seed, purpose, execution, effort);
    Irradiance result = gather_smooth(x, nullptr, correction, rays, seed, purpose, execution);
    result.direct += light;
    result.segments += effort.segments;
    result.clear += effort.clear;
    return result;
}

Values Field::radiosity(std::span<const SurfacePoint> x, const Values& H) const {
    Values B = sum_of_parts(H, channels());
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
        const SurfacePoint& point = x[static_cast<std::size_t>(i)];
        const Eigen::ArrayXd E = parts_.scene->emission(point).head(channels());
        const Eigen::ArrayXd rho = parts_.scene->reflectance(point).head(channels());
        B.row(i) = (E + rho * B.row(i).transpose().array()).matrix().transpose();
    }
    return B;
}

void Field::gather_twice(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                         const std::string& purpose, const Execution& execution, Irradiance& first,
                         Irradiance& second) const {
    const std::size_t half = (rays + 1) / 2;
    if (!parts_.sent) {
        first = gather(x, half, seed, purpose + ", first", execution);
        second = gather(x, half, seed, purpose + ", second", execution);
        return;
    }
    constexpr std::size_t most = 16384; // points with their rays and form factors in memory
    for (Irradiance* const both : {&first, &second}) {
        both->direct.resize(static_cast<Eigen::Index>(x.size()), parts_.smooth.cols());
        both->indirect = both->direct;
        both->variance.setZero(static_cast<Eigen::Index>(x.size()), 1);
    }
    for (std::size_t begin = 0; begin < x.size(); begin += most) {
        const std::span<const SurfacePoint> block = x.subspan(begin, std::min(most, x.size() - begin));
        const std::string name = begin == 0 ? purpose : purpose + ", from " + std::to_string(begin);
        const ExactCorrection correction(parts_, block, rays, execution);
        const auto put = [&](const Irradiance& part, Irradiance& all) {
            const auto row = static_cast<Eigen::Index>(begin);
            all.direct.middleRows(row, part.direct.rows()) = part.direct;
            all.indirect.middleRows(row, part.indirect.rows()) = part.indirect;
            all.rays += part.rays;
            all.segments += part.segments;
            all.clear += part.clear;
        };
        put(gather(block, half, seed, name + ", first", execution, &correction), first);
        put(gather(block, half, seed, name + ", second", execution, &correction), second);
    }
}

/// Gathers at x, and sets the noise in `values`.
Irradiance Field::gather_with_noise(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                                    const std::string& purpose, const Execution& execution, PointValues& values) const {
    const Scene& scene = *parts_.scene;
    Irradiance H, other;
    gather_twice(x, rays, seed, purpose, execution, H, other);
    const Values first = H.direct + H.indirect, second = other.direct + other.indirect;
    const Values difference = sum_of_parts(Values(first - second), channels());
    const Values squares = 0.25 * difference.rowwise().squaredNorm();
    const Values all = noise_of_gathers(squares, 1, 0.25 * (H.variance + other.variance));
    values.rays_of_each = rays;
    values.noise_of_irradiance = all / std::sqrt(channels());
    values.noise = values.noise_of_irradiance;
    for (Eigen::Index i = 0; i < all.rows() && !scene.thermal; ++i) {
        const Eigen::RowVectorXd rho =
            scene.reflectance(x[static_cast<std::size_t>(i)]).head(channels()).matrix().transpose();
        const double own = difference.row(i).norm();
        // In the channels as the difference, or as all light.
        const Eigen::RowVectorXd part = own > 0.0
                                            ? Eigen::RowVectorXd(difference.row(i) / own)
                                            : Eigen::RowVectorXd::Constant(channels(), std::sqrt(1.0 / channels()));
        values.noise(i, 0) *= part.cwiseProduct(rho).norm();
    }
    H.direct = 0.5 * (H.direct + other.direct);
    H.indirect = 0.5 * (H.indirect + other.indirect);
    H.rays += other.rays;
    H.segments += other.segments;
    H.clear += other.clear;
    return H;
}

/// The points that no element reaches, though light may, as far as a glance tells. `H`: of the basis.
std::vector<std::size_t> Field::out_of_reach(std::span<const SurfacePoint> x, const Irradiance& H, std::uint64_t seed,
                                             const std::string& purpose, const Execution& execution) const {
    const Discretisation& discretisation = parts_.system->discretisation();
    const Mesh& mesh = parts_.scene->mesh;
    const bool dark = (H.indirect.array() == 0.0).all() && (H.direct.array() == 0.0).all();
    if (dark || !are_elements_everywhere(parts_)) {
        return {};
    }
    std::vector<std::uint8_t> lacks(x.size(), 0);
    const Unreported unreported(execution);
    parallel_for(x.size(), 256, unreported, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t i = begin; i < end; ++i) {
            if (!(H.indirect.row(static_cast<Eigen::Index>(i)).array() == 0.0).all() ||
                discretisation.sites->is_dark(mesh.region[x[i].face])) {
                continue;
            }
            const SurfacePoint inside = inset(mesh, x[i]);
            discretisation.basis->evaluate(inside, row);
            if (row.element.empty()) {
                RandomStream stream(seed, purpose + ", glance", i);
                lacks[i] = Glance(parts_.system->tracer(), inside, stream).light_arrives() ? 1 : 0;
            }
        }
    });
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < lacks.size(); ++i) {
        if (lacks[i] != 0) {
            found.push_back(i);
        }
    }
    return found;
}

/// The irradiance at x; sets what `values` say of gathered points.
Irradiance Field::irradiance(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                             const std::string& purpose, const Execution& execution, const RowVisitor& visit,
                             PointValues& values) const {
    if (final_gather > 0) {
        values.gathered.resize(x.size());
        std::iota(values.gathered.begin(), values.gathered.end(), std::size_t{0});
        return gather_with_noise(x, final_gather, seed, purpose, execution, values);
    }
    Irradiance H = evaluate(x, seed, purpose, execution, visit);
    values.gathered = out_of_reach(x, H, seed, purpose, execution);
    if (values.gathered.empty()) {
        return H;
    }
    std::vector<SurfacePoint> points;
    for (const std::size_t i : values.gathered) {
        points.push_back(x[i]);
    }
    const Irradiance gathered =
        gather_with_noise(points, rays_out_of_reach, seed, purpose + ", out of reach", execution, values);
    for (std::size_t k = 0; k < points.size(); ++k) {
        const auto from = static_cast<Eigen::Index>(k), to = static_cast<Eigen::Index>(values.gathered[k]);
        H.direct.row(to) = gathered.direct.row(from);
        H.indirect.row(to) = gathered.indirect.row(from);
    }
    H.rays += gathered.rays;
    H.segments += gathered.segments;
    return H;
}

PointValues Field::at(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                      const std::string& purpose, const Execution& execution, const RowVisitor& visit) const {
    const Scene& scene = *parts_.scene;
    for (const SurfacePoint& point : x) {
        if (point.face >= scene.mesh.triangles.size()) {
            throw UsageError(
                "the light of a field is asked for at points that are on no face of its surface: in mid-air, "
                "read_sensors measures it");
        }
    }
    PointValues values;
    Irradiance H = irradiance(x, final_gather, seed, purpose, execution, visit, values);
    if (!scene.thermal) {
        raise_to_zero(H.direct, channels());
        raise_to_zero(H.indirect, channels());
    }
    values.rays = H.rays;
    values.segments = H.segments;
    values.clear = H.clear;
    const auto count = static_cast<Eigen::Index>(x.size());
    values.rho.resize(count, 3);
    values.E.resize(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const SurfacePoint& point = x[static_cast<std::size_t>(i)];
        values.rho.row(i) = scene.reflectance(point).matrix().transpose();
        values.E.row(i) = scene.emission(point).matrix().transpose();
    }
    values.H_direct = three_channels(sum_of_parts(H.direct, channels()));
    values.H_indirect = three_channels(sum_of_parts(H.indirect, channels()));
    values.H = values.H_direct + values.H_indirect;
    // Using E and rho at the exact point keeps their edges sharp whatever the basis.
    values.B = values.E + values.rho.cwiseProduct(values.H);
    if (sets().names.size() == 1 && sets().names.front().empty()) {
        return values;
    }
    for (Index set = 0; set < sets().count(); ++set) {
        const Eigen::Index first = static_cast<Eigen::Index>(set) * channels();
        GroupValues group{sets().names[set], {}, {}};
        group.H = three_channels(H.direct.middleCols(first, channels()) + H.indirect.middleCols(first, channels()));
        group.B = values.rho.cwiseProduct(group.H);
        for (Eigen::Index i = 0; i < count; ++i) {
            if (sets().material[scene.mesh.material[x[static_cast<std::size_t>(i)].face]] == set) {
                group.B.row(i) += values.E.row(i);
            }
        }
        values.groups.push_back(std::move(group));
    }
    return values;
}

} // namespace difusa
