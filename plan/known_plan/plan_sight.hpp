#pragma once

#include <string>
#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/known_plan/known_plan.hpp"
#include "slam/localization/saved_map.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::plan {

/// A side of a drawn wall that can be seen from where there is room. Pieces that continue each
/// other are one.
struct DrawnFace {
  WallFace face;        ///< frame: the drawing's; its normal points to where there is room
  bool curved = false;  ///< a chord
  int shape = 0;        ///< chords of one side of one curve share it
};

/// What a laser would see of a plan.
struct PlanSight {
  /// The faces, 1.6 m at most each, as if seen from 0.3 m before them: only there a plan says that
  /// there is free space, as it knows no furniture.
  std::vector<slam::Keyframe> keyframes;
  std::vector<DrawnFace> faces;
};

/// Looks about in a plan from spots a metre or more apart: what is drawn inside walls (the line on
/// their axis, hatching) is seen from nowhere and belongs to no face.
/// @throws std::invalid_argument where there is no room to stand.
/// Cost: about a second for 1000 m2.
PlanSight look_about(const KnownPlan& plan);

/// A plan as a map to localize in: it is saved, loaded and searched as one that was driven.
slam::SavedMap map_of_plan(const PlanSight& sight);

}  // namespace marco::plan
