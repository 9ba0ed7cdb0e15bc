// A system whose surface has moved in part, from the system of the surface as it was.
#pragma once

#include <difusa/mesh/rigid_motion.h>
#include <difusa/radiosity/system.h>
#include <difusa/transport/recast.h>

#include <memory>
#include <span>

namespace difusa {

/// What a system of another surface needs of its own, and what the system it comes from does not tell.
struct FreshParts {
    std::shared_ptr<Visibility> engine; ///< not built yet
    std::shared_ptr<Basis> basis;       ///< of the kind and parameters of the system, not bound yet
    ProjectionChoice projection;        ///< that of the system
    bool neighbour_areas = false;       ///< likewise: the areas of sites do not follow from the basis
};

/// The system after the marked triangles (#T) have moved, with the sites that are on them. Basis, surfels and
/// projection are made anew; of the rays only those are cast again that what has moved may stop, or has stopped
/// (transport/recast.h): the new system is, to the bit, the one with the same sites and directions of which all rays
/// are cast. The system it comes from stays as it is. `rays`: those that were asked for at each point.
///
/// Throws UsageError if the transport is pairwise, for glossy materials, and what `moved_mesh` throws.
std::shared_ptr<const RadiositySystem> moved_system(const RadiositySystem& system, std::span<const char> marked,
                                                    const RigidMotion& motion, const FreshParts& fresh,
                                                    std::size_t rays, RecastCount& count, const Execution& execution);

} // namespace difusa
