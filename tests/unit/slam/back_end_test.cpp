#include "slam/back_end/back_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

// Along a bare corridor the odometry in the graph's edges knows more than the walls: no refinement
// may move the keyframes by the noise of the walls' normals.
TEST(BackEnd, RefinementMovesNothingAlongABareCorridor) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-60, -1.2}, {80, -1.2}});
  corridor.add_chain({{-60, 1.2}, {80, 1.2}});
  std::mt19937 random(3);
  BackEnd back_end({{}, CorrelativeMatcher{}, SurfelMatcher{}}, {}, {});
  std::vector<Keyframe> keys;
  for (int i = 0; i < 20; ++i) {
    Keyframe key;
    key.world_from_robot = {1.0 * i, 0, 0};
    key.path_m = i;
    Points2 hits = corridor.hits(key.world_from_robot, 0.015, &random);
    // The laser sees 8 m.
    Eigen::Index count = 0;
    for (Eigen::Index k = 0; k < hits.cols(); ++k) {
      if (hits.col(k).norm() < 8.0) hits.col(count++) = hits.col(k);
    }
    hits.conservativeResize(2, count);
    key.points_in_robot = orient(hits, {0, 0}, {}, 0.015);
    keys.push_back(std::move(key));
    if (i == 0) continue;
    const Eigen::Matrix3d covariance = Eigen::Vector3d(4e-4, 1e-4, 3e-6).asDiagonal();
    back_end.add_edge({i - 1, i, {1, 0, 0}, information_of(covariance), false});
  }
  JointRefinementResult refined;
  const std::vector<Pose2> poses = back_end.finish(keys, refined);
  EXPECT_GT(refined.ties, 1000);
  double moved_m = 0.0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    moved_m = std::max(moved_m, std::abs(poses[i].x_m - keys[i].world_from_robot.x_m));
    EXPECT_NEAR(poses[i].y_m, 0.0, 0.05);
  }
  // A few millimetres for each keyframe on the way; centimetres with all of the normals' noise.
  EXPECT_LT(moved_m, 0.03);
}

}  // namespace
}  // namespace marco::slam
