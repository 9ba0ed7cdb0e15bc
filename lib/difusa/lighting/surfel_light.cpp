#include <difusa/lighting/surfel_light.h>

#include <difusa/core/even_sequence.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

namespace difusa {

namespace {

constexpr std::size_t surfels_at_once = 256;
constexpr double uneven = 0.1;
constexpr std::size_t most_in_beams = 4096; ///< points of a surfel that is partly in a narrow beam

/// Handles one surfel at a time; scratch of a thread.
class Averages {
  public:
    Averages(const Scene& scene, const Surfels& surfels, const DirectLight& light, int channels)
        : scene_(scene), surfels_(surfels), light_(light), channels_(channels),
          samples_(SurfelSamples::of(light.rays_per_sample())), H_(light.sets().count()) {}

    std::size_t cast() const { return worker_.total_cast(); }

    void add(Index s, RandomStream stream, SurfelLight& result) {
        surfels_.pieces(s, pieces_);
        const bool even = average_materials(s, result);
        if (light_.any()) {
            result.even[s] = average_direct(s, stream, result) && even ? 1 : 0;
        }
    }

  private:
    auto columns(Values& values, Index s, Index set) const {
        return values.row(s).segment(static_cast<Eigen::Index>(set) * channels_, channels_);
    }

    void add_material(Index s, const SurfacePoint& x, double share, SurfelLight& result) const {
        const Index material = scene_.mesh.material[x.face];
        result.reflectance.row(s) += share * scene_.reflectance(x).head(channels_).matrix().transpose();
        const Eigen::RowVectorXd emitted = share * scene_.emission(x).head(channels_).matrix().transpose();
        result.all_emission.row(s) += emitted;
        if (light_.area_light_materials()[material] == 0) {
            columns(result.emission, s, light_.sets().material[material]) += emitted;
            if (result.uneven_emission.rows() > 0 && scene_.materials[material].emits_unevenly()) {
                columns(result.uneven_emission, s, light_.sets().material[material]) += emitted;
            }
        }
    }

    /// Returns whether they are constant.
    bool average_materials(Index s, SurfelLight& result) {
        const std::size_t samples = material_samples(scene_, pieces_);
        for_material_places(surfels_, pieces_, samples, points_,
                            [&](const SurfacePoint& x, double share) { add_material(s, x, share, result); });
        return samples == 0 && std::all_of(pieces_.begin(), pieces_.end(), [&](const Surfels::Piece& piece) {
                   return scene_.mesh.material[piece.triangle] == scene_.mesh.material[pieces_.front().triangle];
               });
    }

    /// Whether some points of the last surfel may see a light in a mirror: between samples that see none there may be.
    bool sees_images() const { return light_.images() != nullptr && worker_.images.near; }

    /// Of beams that may be between the points of the pilot, the part of the surfel that the narrowest covers.
    std::optional<double> narrow_beam() {
        if (!light_.narrow_beams().any()) {
            return std::nullopt;
        }
        corners_.clear();
        for (const Surfels::Piece& piece : pieces_) {
            for (std::size_t k = 0; k < piece.outline.count; ++k) {
                const Eigen::Vector2d& corner = piece.outline.corner[k];
                corners_.push_back(scene_.mesh.at(piece.triangle, corner[0], corner[1]).position);
            }
        }
        return light_.narrow_beams().narrowest(corners_);
    }

    /// So many points of the surfel that about SurfelSamples::edge of them are in a beam.
    std::size_t points_for_beam(double share) const {
        const auto edge = static_cast<double>(samples_.edge), most = static_cast<double>(most_in_beams);
        return static_cast<std::size_t>(edge / std::max(share, edge / most));
    }

    static double largest(const std::vector<double>& values) {
        return std::transform_reduce(
            values.begin(), values.end(), 0.0, [](double a, double b) { return std::max(a, b); },
            [](double value) { return std::abs(value); });
    }

    /// Whether values differ by little of what is the largest value of them and others.
    static bool are_even(const std::vector<double>& values, double largest) {
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        return *most - *least <= uneven * largest;
    }

    /// Sets `H_` to the sum of the light at `count` points; returns whether it is about the same at all of them. Where
    /// area lights are chosen roughly, their light is if all shadow rays, or none, get through.
    bool sample(std::size_t count, RandomStream& stream) {
        std::fill(H_.begin(), H_.end(), Rgb(Rgb::Zero()));
        const std::array<double, 2> shift{stream.uniform(), stream.uniform()};
        spread_points(surfels_, pieces_, count, shift, points_);
        at_points_.resize(count * H_.size());
        outside_at_points_.resize(count);
        const AreaLights::Worker& lamps = worker_.area_lights;
        const std::size_t cast_before = lamps.cast, blocked_before = lamps.blocked_samples;
        light_.sample(points_, stream, at_points_, worker_, outside_at_points_);
        outside_ = Rgb::Zero();
        all_.assign(count, 0.0);
        outside_all_.clear();
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t set = 0; set < H_.size(); ++set) {
                H_[set] += at_points_[i * H_.size() + set];
                all_[i] += at_points_[i * H_.size() + set].sum();
            }
            outside_ += outside_at_points_[i];
            outside_all_.push_back(outside_at_points_[i].sum());
        }
        const std::size_t blocked = lamps.blocked_samples - blocked_before;
        const bool alike =
            light_.chooses_roughly() && !sees_images() && (blocked == 0 || blocked == lamps.cast - cast_before);
        const double most = largest(all_);
        return are_even(all_, most) || (alike && are_even(outside_all_, most));
    }

    /// Returns whether single values of DirectLight::sample differ little from the mean, as far as is known.
    bool average_direct(Index s, RandomStream& stream, SurfelLight& result) {
        const std::size_t cast_before = cast();
        std::size_t count = samples_.pilot;
        bool even = sample(count, stream);
        const std::optional<double> beam = narrow_beam();
        const bool by_chance = sees_images() || light_.chooses_roughly() || beam;
        if (!even || cast() > cast_before || by_chance) {
            count = beam ? points_for_beam(*beam) : even ? samples_.even : samples_.edge;
            even = sample(count, stream) && even;
        }
        result.from_outside.row(s) = (outside_ / static_cast<double>(count)).head(channels_).matrix().transpose();
        for (std::size_t set = 0; set < H_.size(); ++set) {
            columns(result.direct, s, static_cast<Index>(set)) =
                (H_[set] / static_cast<double>(count)).head(channels_).matrix().transpose();
        }
        return even && !by_chance;
    }

    const Scene& scene_;
    const Surfels& surfels_;
    const DirectLight& light_;
    int channels_;
    SurfelSamples samples_;
    DirectLight::Worker worker_;
    std::vector<Surfels::Piece> pieces_;
    std::vector<SurfacePoint> points_;
    std::vector<Vec3> corners_;
    std::vector<Rgb> at_points_, outside_at_points_, H_;
    std::vector<double> all_, outside_all_; ///< sums of the channels at each point
    Rgb outside_ = Rgb::Zero();             ///< from suns and point lights
};

} // namespace

void spread_points(const Surfels& surfels, const std::vector<Surfels::Piece>& pieces, std::size_t count,
                   const std::array<double, 2>& shift, std::vector<SurfacePoint>& points) {
    points.clear();
    for (std::size_t i = 0; i < count; ++i) {
        const double along = (static_cast<double>(i) + shift[0]) / static_cast<double>(count);
        points.push_back(
            surfels.point_on(pieces, along, fraction(shift[1] + static_cast<double>(i) * even_steps<2>[0])));
    }
}

std::size_t material_samples(const Scene& scene, const std::vector<Surfels::Piece>& pieces) {
    constexpr double few = 16.0, most = 4096.0, for_each_pixel = 4.0;
    bool uneven = false;
    double pixels = 0.0;
    for (const Surfels::Piece& piece : pieces) {
        const Material& material = scene.materials[scene.mesh.material[piece.triangle]];
        const bool emits = (material.emission > 0.0).any();
        uneven =
            uneven || material.reflectance_texture || material.vertex_colours || (emits && material.emits_unevenly());
        if (emits && material.emission_texture && piece.area > 0.0) {
            pixels += piece.area / scene.mesh.areas[piece.triangle] * scene.pixels_of_emission(piece.triangle);
        }
    }
    return uneven ? static_cast<std::size_t>(std::clamp(for_each_pixel * pixels, few, most)) : 0;
}

SurfelSamples SurfelSamples::of(std::size_t rays) {
    constexpr std::size_t few_rays = 8, least_even = 4, least_edge = 16;
    SurfelSamples samples;
    if (rays > few_rays) {
        samples.even = std::max(least_even, samples.even * few_rays / rays);
        samples.edge = std::max(least_edge, samples.edge * few_rays / rays);
    }
    return samples;
}

Values SurfelLight::first_bounce() const {
    Values product = direct;
    for (Eigen::Index c = 0; c < product.cols(); ++c) {
        product.col(c) = product.col(c).cwiseProduct(reflectance.col(c % reflectance.cols()));
    }
    return product;
}

SurfelLight light_on_surfels(const Scene& scene, const Surfels& surfels, const DirectLight& light, int channels,
                             std::uint64_t seed, const Execution& execution) {
    const auto count = static_cast<Eigen::Index>(surfels.size());
    const auto columns = static_cast<Eigen::Index>(light.sets().count()) * channels;
    SurfelLight result;
    result.reflectance.setZero(count, channels);
    result.emission.setZero(count, columns);
    result.direct.setZero(count, columns);
    if (scene.has_uneven_emitters()) {
        result.uneven_emission.setZero(count, columns);
    }
    result.all_emission.setZero(count, channels);
    result.from_outside.setZero(count, channels);
    result.even.assign(surfels.size(), 0);
    std::vector<std::size_t> cast((surfels.size() + surfels_at_once - 1) / surfels_at_once, 0);
    parallel_for(surfels.size(), surfels_at_once, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        Averages averages(scene, surfels, light, channels);
        for (std::size_t s = begin; s < end; ++s) {
            if (s % 16 == 0) {
                execution.check();
            }
            averages.add(static_cast<Index>(s), RandomStream(seed, "light on surfels", s), result);
        }
        cast[begin / surfels_at_once] = averages.cast();
    });
    for (const std::size_t each : cast) {
        result.segments += each;
    }
    return result;
}

} // namespace difusa
