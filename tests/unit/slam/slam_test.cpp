#include "slam/slam.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <ctime>

#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

// Rooms around a block, 14 x 10 m: a robot that drives round it comes back to its start.
testing::FlatWorld ring() {
  testing::FlatWorld world;
  world.add_box(-7, -5, 7, 5);
  world.add_box(-4, -2, 4, 2);
  world.add_box(5.8, -0.5, 6.2, 0.1);
  world.add_box(-6.5, 3.0, -6.0, 3.6);
  world.add_box(-1.0, 4.2, -0.4, 4.6);
  world.add_box(1.0, -4.7, 2.1, -4.3);
  return world;
}

// Once round the ring and a bit more, steps of 0.1 m and 9 degrees.
std::vector<Pose2> drive_round(int sides) {
  std::vector<Pose2> path{{-5.5, -3.5, 0.0}};
  const double lengths_m[] = {11.0, 7.0, 11.0, 7.0};
  for (int side = 0; side < sides; ++side) {
    const auto steps = std::lround(lengths_m[side % 4] / 0.1);
    for (int i = 0; i < steps; ++i) path.push_back(path.back() * Pose2{0.1, 0, 0});
    for (int i = 0; i < 10; ++i) path.push_back(path.back() * Pose2{0, 0, deg_to_rad(9)});
  }
  return path;
}

class SlamOnRing : public ::testing::Test {
 protected:
  // Drives `path` with odometry that is 4 % long and turns 3 % too far.
  void drive(Slam& slam, const std::vector<Pose2>& path, bool with_odometry = true) {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    Pose2 odom;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (i > 0) {
        const Pose2 step = between(path[i - 1], path[i]);
        odom = odom * Pose2{1.04 * step.x_m, 1.04 * step.y_m, 1.03 * step.theta_rad + 0.0005};
      }
      SlamInput input;
      input.scan.utime = Utime::from_us(static_cast<int64_t>(i) * 200000);
      input.scan.hits_in_robot = world_.hits(path[i], 0.01, &random);
      for (auto hit : input.scan.hits_in_robot.colwise()) {
        if (noise_ > 0.0 && part(random) < noise_) hit *= (0.3 + 79.6 * part(random)) / hit.norm();
      }
      input.motion.utime = input.scan.utime;
      if (with_odometry) input.motion.odom_from_robot = odom;
      updates_.push_back(slam.process(input));
    }
  }
  double worst_error_m(const Trajectory& trajectory, const std::vector<Pose2>& path) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const Pose2 truth = between(path.front(), path[i]);
      worst = std::max(
          worst, (trajectory[i].world_from_robot.translation_m() - truth.translation_m()).norm());
    }
    return worst;
  }
  testing::FlatWorld world_ = ring();
  std::vector<SlamUpdate> updates_;
  double noise_ = 0.0;  ///< part of the beams that end anywhere up to 79.9 m
};

TEST_F(SlamOnRing, ClosesTheLoopAndEndsWithinCentimetres) {
  Slam slam;
  const std::vector<Pose2> path = drive_round(5);
  drive(slam, path);
  slam.finish();
  EXPECT_FALSE(slam.loops().empty());
  // Noise of 1 cm over hundreds of beams; the bound is the "path stays within 5 cm".
  EXPECT_LT(worst_error_m(slam.trajectory(), path), 0.05);
  EXPECT_EQ(slam.trajectory().size(), path.size());
  EXPECT_LT(slam.key_count(), path.size() / 2);
}

// A nodding laser: tilted rows are predicted, the first level one is matched. Odometry errs by 4 %.
TEST_F(SlamOnRing, ScansOfAStopLieWhereItsLastMatchDoes) {
  Slam slam;
  std::vector<Pose2> path;
  std::mt19937 random(22);
  const auto scan = [&](const Pose2& at, double odometry_m, bool level) {
    SlamInput input;
    input.scan.utime = Utime::from_us(static_cast<int64_t>(path.size()) * 200000);
    input.scan.hits_in_robot = world_.hits(at, 0.01, &random);
    input.motion.utime = input.scan.utime;
    input.motion.odom_from_robot = Pose2{odometry_m, 0, 0};
    input.level = level;
    slam.process(input);
    path.push_back(at);
  };
  const Pose2 start{-5.5, -3.5, 0};
  for (int i = 0; i < 40; ++i) scan(start * Pose2{0.1 * i, 0, 0}, 0.104 * i, true);
  const Pose2 stop = start * Pose2{5.4, 0, 0};
  constexpr double kOdometryM = 1.04 * 5.4;
  const std::size_t first = path.size();
  for (int i = 0; i < 12; ++i) scan(stop, kOdometryM, i >= 5 && i < 9);
  const std::size_t pushed = path.size();
  // Wheels stand still while someone pushes the robot.
  for (int i = 0; i < 3; ++i) scan(stop * Pose2{0.08, 0, 0}, kOdometryM, true);
  const Trajectory scans = slam.trajectory();
  for (std::size_t i = first; i < pushed; ++i) {
    EXPECT_THAT(scans[i].world_from_robot, IsNear(scans[first].world_from_robot, 0.0, 0.0)) << i;
  }
  const Pose2 truth = between(path.front(), stop);
  EXPECT_THAT(scans[first].world_from_robot, IsNear(truth, 0.01, 0.003));
  EXPECT_NEAR(between(scans[pushed - 1].world_from_robot, scans[pushed].world_from_robot).x_m, 0.08,
              0.01);
}

TEST_F(SlamOnRing, LoopsThatSayWhatIsBelievedAnywayDoNotMoveThePathEachTime) {
  Slam slam;
  drive(slam, drive_round(14));
  // Each move is an optimization of the whole graph: one a loop made an hour in one building cost
  // as much as the hours before it together.
  EXPECT_GT(slam.loops().size(), 100U);
  EXPECT_LT(slam.revision(), static_cast<int64_t>(slam.loops().size()) / 2);
}

// Each scan that fits badly is looked for widely: in a table of what is near, made once a keyframe.
TEST_F(SlamOnRing, NoiseOfTheWholeRangeCostsNoTableOfTheWholeRange) {
  Slam slam;
  noise_ = 0.6;
  const std::vector<Pose2> whole = drive_round(1);
  const std::vector<Pose2> path(whole.begin(), whole.begin() + 100);
  const std::clock_t before = std::clock();
  drive(slam, path);
  const double ms = 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  std::printf("100 scans, 60 %% of their beams noise: %.0f ms of CPU\n", ms);
  EXPECT_LT(ms, 2500.0);
}

TEST_F(SlamOnRing, WorksWithoutOdometry) {
  Slam slam;
  const std::vector<Pose2> path = drive_round(2);
  drive(slam, path, false);
  EXPECT_LT(worst_error_m(slam.trajectory(), path), 0.15);
}

TEST_F(SlamOnRing, TwoRunsAreEqualToTheLastBit) {
  Slam first, second;
  const std::vector<Pose2> path = drive_round(5);
  drive(first, path);
  drive(second, path);
  first.finish();
  second.finish();
  const Trajectory a = first.trajectory(), b = second.trajectory();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].world_from_robot.x_m, b[i].world_from_robot.x_m);
    ASSERT_EQ(a[i].world_from_robot.theta_rad, b[i].world_from_robot.theta_rad);
  }
}

// A drive along the first side; after 30 whole scans each shows only `returns` points, four of them
// beside each other, in other directions each time.
SlamUpdate drive_with_few_returns(Slam& slam,
                                  const testing::FlatWorld& world,
                                  Eigen::Index returns,
                                  bool with_odometry) {
  std::mt19937 random(23);
  const std::vector<Pose2> path = drive_round(1);
  SlamUpdate last;
  Pose2 odom;
  for (int i = 0; i <= 100; ++i) {
    SlamInput input;
    input.scan.utime = Utime::from_us(i * 200000);
    const Eigen::Matrix2Xd hits = world.hits(path[static_cast<std::size_t>(i)], 0.01, &random);
    const Eigen::Index count = i < 30 ? hits.cols() : returns;
    input.scan.hits_in_robot.resize(2, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index group = k / 4 * 4;
      input.scan.hits_in_robot.col(k) =
          hits.col(i < 30 ? k : (group * hits.cols() / returns + k - group + 5 * i) % hits.cols());
    }
    input.motion.utime = input.scan.utime;
    if (with_odometry) input.motion.odom_from_robot = odom;
    odom = odom * Pose2{0.104, 0, 0.0005};
    last = slam.process(input);
  }
  return last;
}

TEST_F(SlamOnRing, FewReturnsRefineWhereOdometrySaysTheRobotIs) {
  Slam slam;
  const SlamUpdate last = drive_with_few_returns(slam, world_, 12, true);
  EXPECT_THAT(last.world_from_robot, IsNear(Pose2{10, 0, 0}, 0.05, 0.01));
  Slam blind, by_odometry;
  const SlamUpdate seven = drive_with_few_returns(blind, world_, 7, true);
  const SlamUpdate none = drive_with_few_returns(by_odometry, world_, 0, true);
  EXPECT_THAT(seven.world_from_robot, IsNear(none.world_from_robot, 0.0, 0.0)) << "too few";
  // Its wheels are 4 % too large, as the first 3 m showed: 0.28 m on the 7 m without scans.
  EXPECT_NEAR(none.world_from_robot.x_m, 10.0, 0.15);
}

// A hall of columns, of which the laser sees a part of one at a time: it fits turned by any angle.
TEST(SlamInAHall, OneColumnProvesNothingAgainstOdometry) {
  Slam slam;
  std::mt19937 random(24);
  std::normal_distribution<double> noise(0.0, 0.02);
  SlamUpdate last;
  for (int i = 0; i < 300; ++i) {
    const Pose2 at{0.1 * i, 0, 0};
    SlamInput input;
    input.scan.utime = Utime::from_us(i * 200000);
    input.motion.utime = input.scan.utime;
    input.motion.odom_from_robot = at;
    const Eigen::Vector2d column_m(4.0 * std::floor(at.x_m / 4.0) + 2.0, 1.5);
    input.scan.hits_in_robot.resize(2, 12);
    for (int k = 0; k < 12; ++k) {
      const double angle_rad = std::atan2(-column_m.y(), at.x_m - column_m.x()) + 0.2 * (k - 5.5);
      const Eigen::Vector2d outward(std::cos(angle_rad), std::sin(angle_rad));
      input.scan.hits_in_robot.col(k) =
          column_m + (0.3 + noise(random)) * outward - at.translation_m();
    }
    last = slam.process(input);
  }
  EXPECT_THAT(last.world_from_robot, IsNear(Pose2{29.9, 0, 0}, 0.3, 0.1));
}

TEST_F(SlamOnRing, FewReturnsAloneAreNotMatched) {
  Slam slam;
  EXPECT_EQ(drive_with_few_returns(slam, world_, 12, false).status, SlamUpdate::Status::predicted);
}

TEST_F(SlamOnRing, ATiltedScanIsCarriedByOdometryAndDrawsNothing) {
  Slam slam;
  const std::vector<Pose2> path = drive_round(1);
  drive(slam, {path[0], path[1]});
  SlamInput tilted;
  tilted.scan.utime = Utime::from_us(400000);
  tilted.scan.hits_in_robot = world_.hits(path[50]);  // nonsense for its place
  tilted.motion = {tilted.scan.utime, Pose2{0.204, 0, 0.0005}, {}};
  tilted.level = false;
  const SlamUpdate update = slam.process(tilted);
  EXPECT_EQ(update.status, SlamUpdate::Status::predicted);
  EXPECT_THAT(update.world_from_robot, IsNear(Pose2{0.2, 0, 0}, 0.02, 0.01));
  EXPECT_GT(update.covariance(0, 0), updates_.back().covariance(0, 0));
  EXPECT_EQ(slam.key_count(), 1U);
}

TEST_F(SlamOnRing, OdometryThatJumps100MetresDoesNotMoveTheRobot) {
  Slam slam;
  const std::vector<Pose2> path = drive_round(1);
  drive(slam, {path.begin(), path.begin() + 20});
  SlamInput input;
  input.scan.utime = Utime::from_us(20 * 200000);
  input.scan.hits_in_robot = world_.hits(path[20]);
  input.motion = {input.scan.utime, Pose2{102.0, 0, 0}, {}};
  const SlamUpdate update = slam.process(input);
  EXPECT_THAT(update.world_from_robot, IsNear(between(path[0], path[20]), 0.03, 0.01));
}

TEST_F(SlamOnRing, NoScansAndEmptyScansAreNoTrouble) {
  Slam slam;
  slam.finish();
  EXPECT_TRUE(slam.trajectory().empty());
  EXPECT_EQ(slam.grid().to_map().width_cells, 0);
  SlamInput empty;
  slam.process(empty);
  slam.process(empty);
  slam.finish();
  EXPECT_EQ(slam.trajectory().size(), 2U);
}

}  // namespace
}  // namespace marco::slam
