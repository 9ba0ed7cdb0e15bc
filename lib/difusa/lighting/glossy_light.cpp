#include <difusa/lighting/glossy_light.h>

#include <difusa/core/frame.h>
#include <difusa/core/parallel.h>
#include <difusa/lighting/surfel_light.h>

#include <array>
#include <map>
#include <vector>

namespace difusa {

namespace {

/// Handles the parts of one surfel at a time; scratch of a thread.
class LightOfParts {
  public:
    LightOfParts(const Scene& scene, const Surfels& surfels, const GlossySurfels& glossy,
                 const SphericalHarmonics& harmonics, const std::function<const LobeHarmonics&(Index)>& lobe,
                 const DirectLight& light, int channels)
        : scene_(scene), surfels_(surfels), glossy_(glossy), harmonics_(harmonics), lobe_(lobe), light_(light),
          channels_(channels) {}

    std::size_t cast() const { return worker_.total_cast(); }

    void add(Index s, RandomStream stream, GlossyLight& result) {
        surfels_.pieces(s, pieces_);
        const std::array<double, 2> shift{stream.uniform(), stream.uniform()};
        spread_points(surfels_, pieces_, glossy_light_samples, shift, points_);
        light_.sample_directions(points_, stream, arrivals_, worker_);
        for (const DirectLight::Arrival& arrival : arrivals_) {
            add(s, arrival, result);
        }
    }

  private:
    void add(Index s, const DirectLight::Arrival& arrival, GlossyLight& result) {
        const SurfacePoint& y = points_[arrival.place];
        const Index kind = scene_.mesh.glossy.kind(y.face);
        if (kind == none) {
            return;
        }
        const GlossySurfaces::Kind& gloss = scene_.mesh.glossy.kinds[kind];
        Index part = glossy_.of(s).begin;
        while (glossy_.parts()[part].lobe != gloss.lobe) {
            ++part;
        }
        const LobeHarmonics& lobe = lobe_(gloss.lobe);
        const auto width = static_cast<Eigen::Index>(harmonics_.count());
        scattered_.resize(lobe.numbers().size());
        lobe.at(frame_of(y.normal).transpose() * arrival.towards, scattered_);
        Values own = Values::Zero(width, 1);
        for (std::size_t k = 0; k < scattered_.size(); ++k) {
            own(static_cast<Eigen::Index>(lobe.numbers()[k]), 0) = scattered_[k];
        }
        Values turned(width, 1);
        SphericalHarmonics::rotate(rotation(y.normal), own, turned);
        const Eigen::RowVectorXd H = (gloss.reflectance * arrival.H / static_cast<double>(glossy_light_samples))
                                         .head(channels_)
                                         .matrix()
                                         .transpose();
        const Eigen::Index first = static_cast<Eigen::Index>(part) * width;
        result.all.block(first, static_cast<Eigen::Index>(arrival.set) * channels_, width, channels_).noalias() +=
            turned * H;
        if (arrival.from_outside) {
            result.from_outside.middleRows(first, width).noalias() += turned * H;
        }
    }

    const SphericalHarmonics::Rotation& rotation(const Vec3& n) {
        if (n != normal_ || rotation_.empty()) {
            normal_ = n;
            rotation_ = harmonics_.rotation(frame_of(n));
        }
        return rotation_;
    }

    const Scene& scene_;
    const Surfels& surfels_;
    const GlossySurfels& glossy_;
    const SphericalHarmonics& harmonics_;
    const std::function<const LobeHarmonics&(Index)>& lobe_;
    const DirectLight& light_;
    Eigen::Index channels_;
    DirectLight::Worker worker_;
    std::vector<Surfels::Piece> pieces_;
    std::vector<SurfacePoint> points_;
    std::vector<DirectLight::Arrival> arrivals_;
    std::vector<double> scattered_;
    Vec3 normal_ = Vec3::Zero();
    SphericalHarmonics::Rotation rotation_; ///< of `normal_`
};

} // namespace

GlossyLight glossy_light_on_surfels(const Scene& scene, const Surfels& surfels, const GlossySurfels& glossy,
                                    const SphericalHarmonics& harmonics,
                                    const std::function<const LobeHarmonics&(Index number)>& lobe,
                                    const DirectLight& light, int channels, std::uint64_t seed,
                                    const Execution& execution) {
    const std::vector<GlossySurfels::Part>& parts = glossy.parts();
    const auto rows = static_cast<Eigen::Index>(parts.size() * harmonics.count());
    GlossyLight result;
    result.all.setZero(rows, static_cast<Eigen::Index>(light.sets().count()) * channels);
    result.from_outside.setZero(rows, channels);
    constexpr std::size_t grain = 64;
    std::vector<std::size_t> cast((parts.size() + grain - 1) / grain, 0);
    parallel_for(parts.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        LightOfParts own(scene, surfels, glossy, harmonics, lobe, light, channels);
        for (std::size_t p = begin; p < end; ++p) {
            if (glossy.of(parts[p].surfel).begin == p) { // all parts of the surfel at once
                own.add(parts[p].surfel, RandomStream(seed, "glossy light on surfels", parts[p].surfel), result);
            }
        }
        cast[begin / grain] = own.cast();
    });
    for (const std::size_t each : cast) {
        result.segments += each;
    }
    return result;
}

} // namespace difusa
