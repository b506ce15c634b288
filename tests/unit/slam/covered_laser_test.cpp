#include "slam/map/covered_laser.hpp"

#include <gtest/gtest.h>

#include <array>

#include "slam/slam.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

constexpr int kBeams = 181;

Eigen::Vector2d ray(int beam) {
  const double bearing_rad = deg_to_rad(beam - 90.0);
  return {std::cos(bearing_rad), std::sin(bearing_rad)};
}

// What a laser measures with something before every beam from `first` on, at this range.
Points2 covered(Points2 hits, int first, double range_m, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, 0.01);
  for (int beam = first; beam < kBeams; ++beam) {
    hits.col(beam) = (range_m + noise(random)) * ray(beam);
  }
  return hits;
}

class CoveredLaser : public ::testing::Test {
 protected:
  CoveredLaser() { room_.add_box(-4.0, -3.0, 8.0, 3.0); }

  Points2 seen_from(const Pose2& robot) {
    std::normal_distribution<double> noise(0.0, 0.01);
    Points2 hits(2, kBeams);
    for (int beam = 0; beam < kBeams; ++beam) {
      const double bearing_rad = robot.theta_rad + deg_to_rad(beam - 90.0);
      hits.col(beam) =
          (room_.range_m(robot.translation_m(), bearing_rad) + noise(random_)) * ray(beam);
    }
    return hits;
  }
  std::vector<Keyframe> map_from(const Pose2& robot) {
    Keyframe key;
    key.points_in_robot = orient(seen_from(robot), Eigen::Vector2d::Zero(), {});
    key.world_from_robot = robot;
    return {key};
  }
  bool is_covered_at(const Points2& hits,
                     const std::vector<Pose2>& places,
                     bool was_covered = false) {
    return laser_is_covered(hits, Eigen::Vector2d::Zero(), places, map_from({}), was_covered);
  }

  testing::FlatWorld room_;
  std::mt19937 random_{7};
};

TEST_F(CoveredLaser, AHandOrPeopleAllAroundCoverItAWallDoesNot) {
  const Points2 hits = seen_from({});
  EXPECT_FALSE(is_covered_at(hits, {{}}));
  EXPECT_TRUE(is_covered_at(covered(hits, 0, 0.2, random_), {{}}));
  EXPECT_TRUE(is_covered_at(covered(hits, 40, 0.8, random_), {{}}));
  // Half a view tells the place; somebody at 1.5 m is no cover.
  EXPECT_FALSE(is_covered_at(covered(hits, 90, 0.8, random_), {{}}));
  EXPECT_FALSE(is_covered_at(covered(hits, 0, 1.5, random_), {{}}));
}

TEST_F(CoveredLaser, InACorridorAPartOfWhatCoversItLiesWhereTheWallsAre) {
  room_ = {};
  room_.add_box(-4.0, -0.6, 8.0, 0.6);
  Points2 hits(2, kBeams);  // a box of 1 x 1 m over the robot
  for (int beam = 0; beam < kBeams; ++beam) {
    hits.col(beam) = 0.5 / ray(beam).cwiseAbs().maxCoeff() * ray(beam);
  }
  EXPECT_TRUE(is_covered_at(hits, {{}}));
  EXPECT_FALSE(is_covered_at(seen_from({}), {{}}));
}

// In a corner at 0.6 m, while odometry says that it stands in the middle of the room.
TEST_F(CoveredLaser, WallsWhereOdometryLiesAreNoCover) {
  room_ = {};
  room_.add_box(-0.4, -0.4, 0.6, 0.4);
  const Points2 hits = seen_from({});
  room_ = {};
  room_.add_box(-4.0, -3.0, 8.0, 3.0);
  room_.add_box(-0.4, -0.4, 0.6, 0.4);
  EXPECT_FALSE(laser_is_covered(hits, Eigen::Vector2d::Zero(),
                                std::array{Pose2{0, 2.0, 0}, Pose2{}}, map_from({}), false));
}

// Beyond the room nothing was seen as free, and a robot that drives on under a hand comes there.
TEST_F(CoveredLaser, TheCoverStaysWhereNothingWasSeenUntilMoreOrKnownWallsAreSeen) {
  const Points2 hits = seen_from({});
  const std::vector<Pose2> beyond{{12.0, 0.0, 0.0}}, here{{}};
  EXPECT_FALSE(is_covered_at(covered(hits, 0, 0.2, random_), beyond));
  EXPECT_TRUE(is_covered_at(covered(hits, 0, 0.2, random_), beyond, true));
  EXPECT_FALSE(is_covered_at(hits, beyond, true));
  room_ = {};
  room_.add_box(-0.4, -0.4, 0.6, 0.4);
  EXPECT_FALSE(is_covered_at(seen_from({}), here, true));
}

TEST_F(CoveredLaser, WithoutAMapNothingIsCovered) {
  const Points2 hits = covered(seen_from({}), 0, 0.2, random_);
  EXPECT_FALSE(laser_is_covered(hits, Eigen::Vector2d::Zero(), std::array{Pose2{}}, {}, false));
}

// A hand for 3 s each, while the robot drives: odometry is 3 % long.
TEST_F(CoveredLaser, TheMapIsThatOfTheOtherScans) {
  room_.add_box(2.0, -3.0, 2.5, -0.8);
  room_.add_box(5.0, 1.0, 5.6, 2.0);
  Slam slam{SlamOptions{}};
  Pose2 robot{-3.0, 0.3, 0.0}, odom;
  int keyframes = 0, matched = 0, covers = 0;
  double worst_m = 0.0;
  std::vector<Pose2> truths;
  for (int i = 0; i < 160; ++i) {
    const bool cover = i % 50 >= 30 && i % 50 < 45;
    SlamInput input;
    input.scan.utime = Utime::from_us(200'000 * static_cast<int64_t>(i));
    input.scan.hits_in_robot = seen_from(robot);
    if (cover) input.scan.hits_in_robot = covered(input.scan.hits_in_robot, 0, 0.2, random_);
    input.motion.utime = input.scan.utime;
    input.motion.odom_from_robot = odom;
    const SlamUpdate update = slam.process(input);
    const Pose2 truth = between(Pose2{-3.0, 0.3, 0.0}, robot);
    truths.push_back(truth);
    if (cover) {
      ++covers;
      keyframes += update.became_key ? 1 : 0;
      matched += update.status == SlamUpdate::Status::matched ? 1 : 0;
    } else {
      worst_m = std::max(worst_m,
                         (update.world_from_robot.translation_m() - truth.translation_m()).norm());
    }
    const Pose2 step{0.05, 0.0, 0.01 * std::sin(0.1 * i)};
    robot = robot * step;
    odom = odom * Pose2{1.03 * step.x_m, 0.0, step.theta_rad};
  }
  EXPECT_EQ(covers, 45);
  EXPECT_EQ(keyframes, 0);
  EXPECT_EQ(matched, 0);
  EXPECT_LT(worst_m, 0.05);
  // What odometry was off in the end is taken from all of the 3 s.
  const Trajectory path = slam.trajectory();
  ASSERT_EQ(path.size(), truths.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_LT((path[i].world_from_robot.translation_m() - truths[i].translation_m()).norm(), 0.012)
        << i;
  }
}

// A wall that one of the last keyframes saw is one, whatever the others say.
TEST_F(CoveredLaser, WhatOneOfTheLastKeyframesSawAsAWallIsNoCover) {
  std::vector<Keyframe> keys = map_from({});
  room_ = {};
  room_.add_box(-0.4, -0.4, 0.6, 0.4);
  const Points2 hits = seen_from({});
  const auto is_covered = [&](const std::vector<Keyframe>& by) {
    return laser_is_covered(hits, Eigen::Vector2d::Zero(), std::array{Pose2{}}, by, false);
  };
  EXPECT_TRUE(is_covered(keys));
  keys.push_back(map_from({})[0]);
  EXPECT_FALSE(is_covered(keys));
  std::swap(keys[0], keys[1]);
  EXPECT_FALSE(is_covered(keys));
}

// Only where the robot has been of late: what was seen long ago may have changed.
TEST_F(CoveredLaser, WhatOldKeyframesSawAsFreeDoesNotCount) {
  std::vector<Keyframe> keys = map_from({});
  const Points2 hits = covered(seen_from({}), 0, 0.2, random_);
  const auto is_covered = [&] {
    return laser_is_covered(hits, Eigen::Vector2d::Zero(), std::array{Pose2{}}, keys, false);
  };
  Keyframe elsewhere = keys[0];
  elsewhere.world_from_robot = {50, 0, 0};
  keys.insert(keys.end(), 4, elsewhere);
  EXPECT_TRUE(is_covered());
  keys.push_back(elsewhere);
  EXPECT_FALSE(is_covered());
}

// On a mast 2 m ahead of the robot's middle, what is near is near to the laser.
TEST_F(CoveredLaser, NearIsMeantFromTheLaser) {
  const Eigen::Vector2d laser(2.0, 0.0);
  std::vector<Keyframe> keys = map_from({});
  Points2 hits = covered(seen_from({}), 0, 0.2, random_);
  hits.colwise() += laser;
  keys[0].sensor_in_robot = laser;
  keys[0].points_in_robot.points.colwise() += laser;
  EXPECT_TRUE(laser_is_covered(hits, laser, std::array{Pose2{}}, keys, false));
}

}  // namespace
}  // namespace marco::slam
