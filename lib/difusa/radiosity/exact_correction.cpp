#include <difusa/radiosity/exact_correction.h>

#include <difusa/radiosity/system.h>
#include <difusa/scene/sky_parts.h>

namespace difusa {

ExactCorrection::ExactCorrection(const FieldParts& field, std::span<const SurfacePoint> x, std::size_t rays,
                                 const Execution& execution)
    : field_(field), factors_(field.scene->mesh, x, *field.system->discretisation().surfels, rays, execution) {
    if (field.scene->has_sky()) {
        const Eigen::Index channels = field.channels;
        const Values sky = sky_radiosity(*field.scene, field.channels);
        sky_ = Values::Zero(sky.rows(), field.sent->cols());
        sky_.middleCols(static_cast<Eigen::Index>(field.direct->sets().sky) * channels, channels) = sky;
    }
}

Irradiance ExactCorrection::of(LightTransport by_rays, const Execution& execution) const {
    const Values on_bins = by_rays.on_bins(*field_.sent, sky_, execution);
    Values of_rays, refined;
    by_rays.W->apply(on_bins, of_rays, execution);
    factors_.refine(std::move(by_rays), execution).W->apply(on_bins, refined, execution);
    refined -= of_rays;
    Irradiance result;
    result.direct = refined.leftCols(refined.cols() / 2);
    result.indirect = refined.rightCols(refined.cols() / 2);
    return result;
}

Values light_sent(const SurfelLight& light, const Values& means, bool sharp, bool uneven, int channels) {
    const Eigen::Index columns = means.cols();
    Values sent(means.rows(), 2 * columns);
    sent.leftCols(columns) =
        uneven || light.uneven_emission.rows() == 0 ? light.emission : Values(light.emission - light.uneven_emission);
    sent.rightCols(columns) = sharp ? Values(means + light.direct) : means;
    for (Eigen::Index c = 0; c < columns; ++c) {
        sent.col(columns + c).array() *= light.reflectance.col(c % channels).array();
    }
    return sent;
}

} // namespace difusa
