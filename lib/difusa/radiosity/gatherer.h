// What points gather of the light of a field with fresh rays.
#pragma once

#include <difusa/core/colour.h>
#include <difusa/radiosity/field.h>
#include <difusa/radiosity/gathering_noise.h>
#include <difusa/radiosity/system.h>
#include <difusa/rays/sky_openings.h>
#include <difusa/transport/gathered_rows.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace difusa {

inline constexpr double doubt_of_substitutes =
    0.5; ///< standard deviation of light that is substituted there, relative to it
inline constexpr double most_uncovered =
    0.1; ///< of the surface: beyond, it lacks sites by intent, or the basis is narrow

/// Elements are not missing by intent, or for want of width.
inline bool are_elements_everywhere(const FieldParts& parts) {
    return parts.system->discretisation().uncovered <= most_uncovered * parts.scene->mesh.area;
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
        const Rgb sky = look_around(x, number);
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
        return expected_variance(squares_of(sum_), squares_, around_.count()) + variance_through_openings_ +
               add_out_of_reach(direct, indirect);
    }

  private:
    /// Lists what the rays meet, and returns what comes from the sky. Through openings that comes by rays aimed at
    /// them; the weights of what others meet are scaled, so that all add up to 1.
    Rgb look_around(const SurfacePoint& x, std::size_t number) {
        const SkyOpenings* const openings = parts_.system->transport().openings.get();
        const std::size_t aimed_rays = SkyOpenings::aimed(around_.count());
        variance_through_openings_ = 0.0;
        RandomStream stream(seed_, "openings", number);
        const bool aimed =
            openings != nullptr && opening_view_.look(parts_.system->tracer(), *openings, x, aimed_rays, stream);
        Rgb sky = Rgb::Zero();
        double replaced = 0.0, seen = 0.0; // shares of the sky through openings
        const auto from_sky = [&](const Vec3& direction, double weight) {
            return Rgb(weight * (scene_.dome ? std::numbers::pi * scene_.sky_radiance(direction) : scene_.sky));
        };
        const Vec3 origin = around_.rays().front().origin;
        around_.for_each(
            [&](const Hit& hit, double weight) {
                met_.push_back(scene_.mesh.at(hit.face, hit.u, hit.v));
                weight_.push_back(weight);
            },
            [&](const Vec3& direction, double weight) {
                if (aimed && openings->contain(origin, direction)) {
                    replaced += weight;
                    return;
                }
                const Rgb H = from_sky(direction, weight);
                sky += H;
                count_ray(H);
            });
        if (!aimed) {
            return sky;
        }
        Rgb through = Rgb::Zero();
        double squares = 0.0;
        opening_view_.for_each([&](const Vec3& direction, double weight) {
            const Rgb H = from_sky(direction, weight);
            through += H;
            squares += squares_of(H);
            seen += weight;
        });
        variance_through_openings_ = expected_variance(squares_of(through), squares, aimed_rays);
        const double scale = replaced < 1.0 ? std::max(0.0, 1.0 - seen) / (1.0 - replaced) : 0.0;
        for (double& weight : weight_) {
            weight *= scale;
        }
        return scale * sky + through;
    }

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
    SkyOpenings::View opening_view_;
    double variance_through_openings_ = 0.0; ///< of what it sees
};

} // namespace difusa
