#pragma once

#include <embree4/rtcore.h>

namespace marco::sim {

/// One ray into one scene, by Embree 4.
inline void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray); }

}  // namespace marco::sim
