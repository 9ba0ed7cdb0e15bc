#include <difusa/radiosity/exact_correction.h>

#include <difusa/radiosity/system.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered.h>

namespace difusa {

ExactCorrection::ExactCorrection(const FieldParts& field, std::span<const SurfacePoint> x, const Values& means,
                                 const SurfelLight& light, std::size_t rays, const Execution& execution)
    : field_(field), x_(x), b_(means.rows(), 2 * means.cols()),
      factors_(field.scene->mesh, x, *field.system->discretisation().surfels, rays, execution) {
    const Eigen::Index columns = means.cols(), channels = field.channels;
    b_.leftCols(columns) = light.emission;
    b_.rightCols(columns) = field.bright ? Values(means + light.direct) : means;
    for (Eigen::Index c = 0; c < columns; ++c) {
        b_.col(columns + c).array() *= light.reflectance.col(c % channels).array();
    }
    if (field.scene->has_sky()) {
        const Values sky = sky_radiosity(*field.scene, field.channels);
        sky_ = Values::Zero(sky.rows(), b_.cols());
        sky_.middleCols(static_cast<Eigen::Index>(field.direct->sets().sky) * channels, channels) = sky;
    }
}

bool ExactCorrection::is_for(const FieldParts& field) {
    return dynamic_cast<const AnalyticTransport*>(field.system->transport().W.get()) != nullptr;
}

Irradiance ExactCorrection::of(std::size_t rays, std::uint64_t seed, const Execution& execution) const {
    const RadiositySystem& system = *field_.system;
    LightTransport by_rays = gathered(system.tracer(), x_, *system.discretisation().surfels, system.fresh_directions(),
                                      rays, seed, execution);
    Irradiance result;
    result.rays = by_rays.rays;
    const Values on_bins = by_rays.on_bins(b_, sky_, execution);
    Values of_rays, refined;
    by_rays.W->apply(on_bins, of_rays, execution);
    factors_.refine(std::move(by_rays), execution).W->apply(on_bins, refined, execution);
    refined -= of_rays;
    result.direct = refined.leftCols(refined.cols() / 2);
    result.indirect = refined.rightCols(refined.cols() / 2);
    return result;
}

} // namespace difusa
