#include "slam/back_end/graph/joint_refinement.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

// What a robot at `world_from_robot` sees of a room 8 x 6 m around the origin: 360 beams, no noise.
OrientedScan look(const Pose2& world_from_robot) {
  OrientedScan scan;
  scan.points_in_robot.resize(2, 360);
  scan.normals_in_robot.resize(2, 360);
  const Pose2 robot_from_world = world_from_robot.inverse();
  for (int beam = 0; beam < 360; ++beam) {
    const double angle = world_from_robot.theta_rad + deg_to_rad(beam + 0.1);
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    const double to_x = ((ray.x() > 0 ? 4.0 : -4.0) - world_from_robot.x_m) / ray.x();
    const double to_y = ((ray.y() > 0 ? 3.0 : -3.0) - world_from_robot.y_m) / ray.y();
    const Eigen::Vector2d normal = to_x < to_y ? Eigen::Vector2d(ray.x() > 0 ? -1 : 1, 0)
                                               : Eigen::Vector2d(0, ray.y() > 0 ? -1 : 1);
    const Eigen::Vector2d hit = world_from_robot.translation_m() + std::min(to_x, to_y) * ray;
    scan.points_in_robot.col(beam) = robot_from_world * hit;
    scan.normals_in_robot.col(beam) = robot_from_world.rotation() * normal;
  }
  return scan;
}

TEST(JointRefinement, PutsDisturbedScansOfARoomBackOnEachOther) {
  std::mt19937 random(17);
  std::normal_distribution<double> noise(0.0, 0.03);
  std::vector<Pose2> truth, poses;
  std::vector<OrientedScan> scans;
  for (int i = 0; i < 12; ++i) {
    truth.push_back({-2.0 + 0.35 * i, -1.0 + 0.15 * i, 0.3 * i});
    scans.push_back(look(truth.back()));
    poses.push_back(truth.back());
    if (i > 0) {
      poses.back().x_m += noise(random);
      poses.back().y_m += noise(random);
      poses.back().theta_rad += 0.5 * noise(random);
    }
  }
  const JointRefinementResult result = refine_jointly(scans, {}, {}, poses);
  EXPECT_TRUE(result.converged);
  EXPECT_LT(result.rms_m, 1e-3);
  // Points on walls without noise: what is left is the stopping rule and the corners.
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_THAT(poses[i], IsNear(truth[i], 1e-3, 1e-3)) << i;
  }
}

// Of hundreds of points the nearest is the one whose noise agrees: scans tied to such stay where
// they are. Two rounds of 80 scans, the second 3 cm off, centimetre noise: the mean over the points
// of a scan is known to 1 mm; without sampling 15 mm are left.
TEST(JointRefinement, APlaceSeenVeryOftenDoesNotHoldItsScansWhereTheyAre) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise_m(0.0, 0.01);
  std::vector<Pose2> truth, poses;
  std::vector<OrientedScan> scans;
  for (int i = 0; i < 160; ++i) {
    truth.push_back({-2.0 + 0.05 * (i % 80), -1.0 + 0.02 * (i % 80), 0.05 * i});
    scans.push_back(look(truth.back()));
    for (double& coordinate : scans.back().points_in_robot.reshaped()) {
      coordinate += noise_m(random);
    }
    poses.push_back(truth.back());
    if (i >= 80) poses.back() = Pose2{0.03, -0.02, 0.0} * poses.back();
  }
  refine_jointly(scans, {}, {}, poses);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Pose2 off = between(between(poses[0], poses[i]), between(truth[0], truth[i]));
    EXPECT_LT(off.translation_m().norm(), 0.010) << i;
  }
}

TEST(JointRefinement, AScanThatSeesNothingStaysOnItsEdge) {
  std::vector<Pose2> poses{{0, 0, 0}, {1.2, 0.1, 0.0}};
  const std::vector<OrientedScan> scans{look(poses[0]), OrientedScan{}};
  const Pose2 measured{1.0, 0.0, 0.1};
  refine_jointly(scans, {{0, 1, measured}}, {}, poses);
  EXPECT_THAT(poses[1], IsNear(measured, 1e-4, 1e-4));
}

TEST(JointRefinement, RefusesCountsThatDifferAndPointsThatAreNotFinite) {
  std::vector<Pose2> poses(2);
  EXPECT_THROW(refine_jointly({OrientedScan{}}, {}, {}, poses), std::invalid_argument);
  std::vector<OrientedScan> scans{look(poses[0]), look(poses[0])};
  scans[1].points_in_robot(0, 0) = std::nan("");
  EXPECT_THROW(refine_jointly(scans, {}, {}, poses), std::invalid_argument);
}

TEST(JointRefinement, AFarOutlierDoesNotCostTheWorldInMemory) {
  std::vector<Pose2> poses{{0, 0, 0}, {0.01, 0, 0}};
  std::vector<OrientedScan> scans{look(poses[0]), look(poses[0])};
  scans[1].points_in_robot(0, 0) = 1e7;
  refine_jointly(scans, {}, {}, poses);
  EXPECT_LT(std::abs(poses[1].x_m), 1e-3);
}

// Two walls along x, with ranges and normals as noisy as a cheap laser's.
OrientedScan look_along_corridor(std::mt19937& random) {
  std::normal_distribution<double> range_m(0.0, 0.01), normal_rad(0.0, 0.06);
  std::uniform_real_distribution<double> along_m(-5.0, 5.0);
  OrientedScan scan;
  scan.points_in_robot.resize(2, 400);
  scan.normals_in_robot.resize(2, 400);
  for (int i = 0; i < 400; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0, turned_rad = normal_rad(random);
    scan.points_in_robot.col(i) << along_m(random), side + range_m(random);
    scan.normals_in_robot.col(i) << side * std::sin(turned_rad), -side * std::cos(turned_rad);
  }
  return scan;
}

// What seems to hold scans along a bare corridor is the noise of normals: the edges decide.
TEST(JointRefinement, AlongABareCorridorTheEdgesDecide) {
  std::mt19937 random(3);
  std::vector<OrientedScan> scans;
  std::vector<PoseGraphEdge> edges;
  std::vector<Pose2> poses;
  constexpr int kScans = 12;
  constexpr double kStepM = 0.4, kSlippedM = 0.1;
  for (int i = 0; i < kScans; ++i) {
    scans.push_back(look_along_corridor(random));
    poses.push_back({(kStepM - kSlippedM) * i, 0, 0});
    if (i == 0) continue;
    const Eigen::Vector3d sigma(0.02, 0.02, 0.01);
    edges.push_back({i - 1, i, Pose2{kStepM, 0, 0},
                     Eigen::Matrix3d(sigma.cwiseAbs2().cwiseInverse().asDiagonal()), false});
  }
  refine_jointly(scans, edges, {}, poses);
  EXPECT_NEAR(poses.back().x_m, kStepM * (kScans - 1), 0.05 * kSlippedM * (kScans - 1));
  EXPECT_NEAR(poses.back().y_m, 0.0, 0.01);
}

}  // namespace
}  // namespace marco::slam
