#pragma once

#include <vector>

#include "slam/back_end/graph/joint_refinement.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// refine_jointly() over the keyframes' points that lie on something smooth, with its reach adapted
/// to the noise of their ranges. @pre there is a keyframe, and one pose for each.
JointRefinementResult refine_keyframes(const std::vector<Keyframe>& keys,
                                       const std::vector<PoseGraphEdge>& edges,
                                       const JointRefinementOptions& options,
                                       std::vector<Pose2>& poses);

}  // namespace marco::slam
