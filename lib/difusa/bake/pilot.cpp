#include <difusa/bake/pilot.h>

#include <difusa/radiosity/error_points.h>

#include <utility>

namespace difusa {

namespace {

constexpr double least_weight = 0.25; ///< of the mean weight

} // namespace

void bake_pilot(const BakeResult& result, BakeOptions options, const Registry& registry, const Choices& choices,
                const Placed& placed, const Tracer& tracer, const Execution& execution,
                const std::function<void(const BakeResult& pilot, const Execution& own)>& look) {
    SubordinateProgress unreported(execution.progress);
    Journal journal; // of what is noted in pilots nothing is reported
    const Execution own = execution.with(&unreported, &journal);
    BakeResult pilot = result;
    pilot.options = std::move(options);
    Choices rough = make_choices(registry, pilot.options);
    rough.engine = choices.engine;
    solve_placed(pilot, rough, placed, transport_by_rays(pilot, rough, tracer), own);
    look(pilot, own);
    if (execution.journal != nullptr) {
        execution.journal->append_counts(journal);
    }
}

Values judged_at_sites(const BakeResult& pilot, const Values& light) {
    const Discretisation& discretisation = pilot.system->discretisation();
    const SiteSet& sites = *discretisation.sites;
    const Values all = judged_weights(pilot.solution);
    Values weights(static_cast<Eigen::Index>(sites.size()), light.cols());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const SurfacePoint& x = sites.points[i];
        weights.row(static_cast<Eigen::Index>(i)) =
            all.row(static_cast<Eigen::Index>(discretisation.surfels->at(x.face, x.u, x.v)));
    }
    const double mean = weights.mean();
    return light.topRows(weights.rows())
        .cwiseProduct(mean > 0.0 ? Values(weights.cwiseMax(least_weight * mean))
                                 : Values(Values::Ones(weights.rows(), weights.cols())));
}

} // namespace difusa
