#pragma once

#include <cstdint>
#include <optional>

#include "slam/back_end/back_end.hpp"
#include "slam/front_end/drift_filter.hpp"
#include "slam/front_end/match_gate.hpp"
#include "slam/front_end/motion_model.hpp"
#include "slam/front_end/pose_with_covariance.hpp"
#include "slam/front_end/range_noise.hpp"
#include "slam/front_end/unknown_scale.hpp"
#include "slam/front_end/zero_velocity_update.hpp"
#include "slam/map/keyframe.hpp"
#include "slam/map/keyframe_culling.hpp"
#include "slam/map/scan_path.hpp"

namespace marco::slam {

/// All that Slam knows, as the states of its parts: restored from it, Slam continues as if it had
/// never stopped.
struct SlamState {
  KeyframeSet keyframes;
  ScanPathState path;
  BackEndState back_end;
  CullingState culling;
  RangeNoise noise;
  MotionState motion;
  PoseWithCovariance estimate;
  std::optional<CarriedPose> drift;  ///< nothing: it begins at the estimate
  UnknownScale scale;
  std::optional<ZeroVelocityState> zero_velocity;  ///< while the robot stands
  MatchGateState gate;
  bool covered = false;  ///< the laser was, in the last scan with returns
  Eigen::Vector2d local_map_centre_m = Eigen::Vector2d::Zero();
  int64_t revision = 0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("keyframes", keyframes);
    v("path", path);
    v("back_end", back_end);
    v("culling", culling);
    v("noise", noise);
    v("motion", motion);
    v("estimate", estimate);
    v.template before<Eigen::Matrix3d>(kDriftLayout, "since_keyframe");
    v.since(kDriftLayout, "drift", drift);
    v.since(kDriftLayout, "scale", scale);
    v("zero_velocity", zero_velocity);
    v("gate", gate);
    v("covered", covered);
    v("local_map_centre_m", local_map_centre_m);
    v("revision", revision);
  }
};

/// @throws std::invalid_argument naming what contradicts itself, see check() of each part.
void check(const SlamState& state);

}  // namespace marco::slam
