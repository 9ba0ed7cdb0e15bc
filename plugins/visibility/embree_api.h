// Uniform names for Embree 3 and 4: Embree 4 calls the intersect context a ray query context, and takes it in a struct
// of arguments.
#pragma once

#if DIFUSA_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace difusa::embree {

#if DIFUSA_EMBREE_MAJOR >= 4

using Context = RTCRayQueryContext;

inline void initialise(Context& context) {
    rtcInitRayQueryContext(&context);
}

inline void first_hit(RTCScene scene, Context& context, RTCRayHit& ray) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    rtcIntersect1(scene, &ray, &arguments);
}

inline void any_hit(RTCScene scene, Context& context, RTCRay& ray) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    rtcOccluded1(scene, &ray, &arguments);
}

#else

using Context = RTCIntersectContext;

inline void initialise(Context& context) {
    rtcInitIntersectContext(&context);
}

inline void first_hit(RTCScene scene, Context& context, RTCRayHit& ray) {
    rtcIntersect1(scene, &context, &ray);
}

inline void any_hit(RTCScene scene, Context& context, RTCRay& ray) {
    rtcOccluded1(scene, &context, &ray);
}

#endif

} // namespace difusa::embree
