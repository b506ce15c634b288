#include "slam/back_end/keyframe_refinement.hpp"

namespace marco::slam {
namespace {

OrientedScan only_oriented(const OrientedPoints& points) {
  OrientedScan scan{Points2(2, points.points.cols()), Points2(2, points.points.cols())};
  Eigen::Index used = 0;
  for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
    if (!points.has_normal(i)) continue;
    scan.points_in_robot.col(used) = points.points.col(i);
    scan.normals_in_robot.col(used++) = points.normals.col(i);
  }
  scan.points_in_robot.conservativeResize(2, used);
  scan.normals_in_robot.conservativeResize(2, used);
  return scan;
}

}  // namespace

JointRefinementResult refine_keyframes(const std::vector<Keyframe>& keys,
                                       const std::vector<PoseGraphEdge>& edges,
                                       const JointRefinementOptions& options,
                                       std::vector<Pose2>& poses) {
  std::vector<OrientedScan> scans;
  scans.reserve(keys.size());
  for (const Keyframe& key : keys) scans.push_back(only_oriented(key.points_in_robot));
  return refine_jointly(scans, edges, adapted(options, keys.back().points_in_robot.range_sigma_m),
                        poses);
}

}  // namespace marco::slam
