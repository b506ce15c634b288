#pragma once

#include <embree3/rtcore.h>

namespace marco::sim {

/// One ray into one scene, by Embree 3.
inline void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
}

}  // namespace marco::sim
