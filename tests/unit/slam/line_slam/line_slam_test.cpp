#include "slam/line_slam.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/lines_drive.hpp"
#include "tests/support/lines_world.hpp"

namespace marco::slam {
namespace {

using testing::LinesDrive;
using testing::LinesLaser;
using testing::LinesWorld;

const std::vector<Eigen::Vector2d> kLoop = {{1.5, 1.5},  {4.5, 1.5},  {7.0, 2.0},
                                            {12.5, 1.5}, {12.5, 8.5}, {7.0, 8.0},
                                            {1.8, 8.5},  {1.8, 1.6},  {4.5, 1.4}};

TEST(LineSlam, FollowsALoopAndDrawsItsWalls) {
  const LinesWorld world = testing::make_loop_world();
  std::mt19937 random(11);
  const LinesDrive tour = testing::drive(kLoop, 0.1, 0.1, {}, random);
  LineSlam slam(LineSlamOptions{}, tour.world_from_robot[0]);
  Pose2 odometry = tour.world_from_robot[0];
  double error2 = 0.0, odometry_error2 = 0.0, nees = 0.0;
  int steps = 0, unclear = 0, joined = 0, removed = 0;
  for (std::size_t i = 0; i < tour.world_from_robot.size(); ++i) {
    const Pose2 motion = i == 0 ? Pose2{} : tour.odometry_steps[i - 1];
    odometry = odometry * motion;
    const auto taken = testing::take_scan(world, LinesLaser{}, tour.world_from_robot[i], random);
    const LineSlamUpdate update = slam.process(taken.scan, motion);
    const Pose2& truth = tour.world_from_robot[i];
    Eigen::Vector3d error = update.world_from_robot.vector() - truth.vector();
    error.z() = normalize_angle(error.z());
    error2 += error.head<2>().squaredNorm();
    nees += error.dot(update.covariance.llt().solve(error));
    odometry_error2 += (odometry.translation_m() - truth.translation_m()).squaredNorm();
    unclear += update.unclear;
    joined += update.joined;
    removed += update.removed;
    ++steps;
    if (i % 40 == 0 || i + 1 == tour.world_from_robot.size()) {
      std::printf(
          "%4zu walls %d obs %d matched %d unclear %d added %d joined %d  err %.4f %.4f %.5f sigma "
          "%.4f %.5f\n",
          i, update.walls, update.observed, update.matched, update.unclear, update.added,
          update.joined, error.x(), error.y(), error.z(), std::sqrt(update.covariance(0, 0)),
          std::sqrt(update.covariance(2, 2)));
    }
  }
  for (const Wall& wall : slam.plan()) {
    std::printf("wall %ld (%.2f %.2f)-(%.2f %.2f) p %.2f seen %ld sigma %.4f\n", wall.id,
                wall.start_m.x(), wall.start_m.y(), wall.end_m.x(), wall.end_m.y(), wall.existence,
                wall.times_seen, std::sqrt(wall.covariance(0, 0)));
  }
  std::printf("%d steps, rms %.4f m, odometry %.4f m, nees %.2f, unclear %d joined %d removed %d\n",
              steps, std::sqrt(error2 / steps), std::sqrt(odometry_error2 / steps), nees / steps,
              unclear, joined, removed);
  EXPECT_LT(error2, 0.01 * odometry_error2);
}

}  // namespace
}  // namespace marco::slam
