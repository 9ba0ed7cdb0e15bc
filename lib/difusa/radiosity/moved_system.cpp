#include <difusa/radiosity/moved_system.h>

#include <difusa/rays/unfolded_visibility.h>
#include <difusa/transport/pairwise.h>

#include <utility>

namespace difusa {

std::shared_ptr<const RadiositySystem> moved_system(const RadiositySystem& system, std::span<const char> marked,
                                                    const RigidMotion& motion, const FreshParts& fresh,
                                                    std::size_t rays, RecastCount& count, const Execution& execution) {
    const SystemParts& old = system.parts();
    if (pairwise_parts(*old.transport.W).form_factors) {
        throw UsageError("pairwise transport connects all sites by form factors: after a motion, bake again");
    }
    if (system.tracer().mesh().glossy.any()) {
        throw UsageError("objects cannot be moved over glossy materials: make the system without them");
    }
    auto scene = std::make_shared<Scene>(*old.scene);
    scene->mesh = moved_mesh(old.scene->mesh, marked, motion);
    const Mesh& mesh = scene->mesh;
    const std::vector<char> none_moved(marked.size(), 0);
    const std::span<const char> moved = motion.is_identity() ? std::span<const char>(none_moved) : marked;

    auto sites = std::make_shared<SiteSet>(*old.discretisation.sites);
    sites->points = moved_points(sites->points, mesh, moved);
    Discretisation discretisation = discretise(mesh, sites, fresh.basis, fresh.projection, fresh.neighbour_areas,
                                               moved_points(old.discretisation.points, mesh, moved), execution);
    execution.phase("transport");
    const std::shared_ptr<Visibility> engine = built_over(mesh, fresh.engine);
    LightTransport transport =
        recast(old.transport, {system.tracer(), old.discretisation.points, *old.discretisation.surfels},
               {Tracer(mesh, *engine), discretisation.points, *discretisation.surfels}, moved, *old.directions, rays,
               old.seed, count, execution);
    return std::make_shared<RadiositySystem>(SystemParts{std::move(scene), engine, old.directions, old.solver,
                                                         std::move(discretisation), std::move(transport), old.seed});
}

} // namespace difusa
