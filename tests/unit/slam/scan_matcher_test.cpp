#include "slam/front_end/scan_matcher.hpp"

#include <gtest/gtest.h>

#include "slam/front_end/zero_velocity_update.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;
using Source = MotionGuess::Source;

class ScanMatcherTest : public ::testing::Test {
 protected:
  ScanMatcherTest() {
    for (const Pose2& place : {Pose2{-1, -1, 0.3}, Pose2{-0.8, -1, 0.3}}) {
      Keyframe key;
      key.world_from_robot = place;
      key.points_in_robot = seen_from(place);
      keys_.keys.push_back(key);
      map_.extend(keys_);
    }
  }
  OrientedPoints seen_from(const Pose2& place) {
    return orient(world_.hits(place, 0.01, &random_), {0, 0}, {});
  }
  /// Of a robot at kTruth. @param off  by so much the prediction errs, which is sure to 1 cm
  ScanMatch match(const Pose2& off,
                  Source source,
                  ScanMatcher::Search search = ScanMatcher::Search::everywhere) {
    const PosePrior prior{kTruth * off, information_of(diagonal_covariance(0.01, deg_to_rad(0.5))),
                          match_gates::kPriorFreedom};
    return matcher_.match(seen_from(kTruth), prior, source, keys_, map_, search);
  }
  static constexpr Pose2 kTruth{-0.7, -0.9, 0.35};

  testing::FlatWorld world_ = testing::small_room();
  std::mt19937 random_{12};
  KeyframeSet keys_;
  LocalMap map_{{}, {}, {}};
  ScanMatcher matcher_{{}, {}, {}};
};

TEST_F(ScanMatcherTest, NearARightPredictionTheMatchIsSure) {
  for (const Source source : {Source::odometry, Source::velocity}) {
    const ScanMatch found = match({0.01, -0.01, 0.005}, source);
    EXPECT_TRUE(found.usable);
    EXPECT_GT(found.overlap, 0.8);
    EXPECT_THAT(found.world_from_robot, IsNear(kTruth, 0.01, deg_to_rad(0.3)));
  }
}

// Wheels slipped, or the robot was pushed.
TEST_F(ScanMatcherTest, OdometryIsOverruledHoweverSureItIs) {
  for (const Pose2& off : {Pose2{0.25, 0.1, 0}, Pose2{0, 0.2, deg_to_rad(12)}}) {
    const ScanMatch found = match(off, Source::odometry);
    EXPECT_TRUE(found.usable);
    EXPECT_GT(found.overlap, 0.8);
    EXPECT_THAT(found.world_from_robot, IsNear(kTruth, 0.02, deg_to_rad(0.5)));
  }
}

// A metre off, and turned by half a right angle.
TEST_F(ScanMatcherTest, WhatLiesFarFromThePredictionIsFoundOnlyWhereOdometryMayBeLeftAside) {
  const Pose2 off{0.9, 0.5, deg_to_rad(-40)};
  EXPECT_THAT(match(off, Source::velocity).world_from_robot, IsNear(kTruth, 0.02, deg_to_rad(0.5)));
  const ScanMatch kept = match(off, Source::velocity, ScanMatcher::Search::prior_window);
  EXPECT_FALSE(kept.usable && kept.overlap > 0.8);
}

TEST_F(ScanMatcherTest, WhereNothingFitsThePredictionIsAllThatIsKnown) {
  world_ = {};
  for (int i = 0; i < 12; ++i) world_.add_box(-5.0 + 0.8 * i, 9, -4.9 + 0.8 * i, 9.1 + 0.3 * i);
  const Pose2 off{0.1, 0, 0};
  const ScanMatch found = match(off, Source::odometry);
  EXPECT_FALSE(found.usable);
  EXPECT_THAT(found.world_from_robot, IsNear(kTruth * off, 1e-12, 1e-12));
  EXPECT_TRUE(found.information.isZero());
}

Eigen::Matrix3d sure_to(double sigma_m) {
  return diagonal_covariance(sigma_m, deg_to_rad(10.0 * sigma_m));
}

TEST(ZeroVelocity, ABadlyKnownPoseFollowsTheMatchesOfItsStopAndAWellKnownOneStays) {
  const Eigen::Vector3d off(0.004, -0.002, 0.001);
  for (const double sigma_m : {0.03, 0.0003}) {
    ZeroVelocityUpdate update(sure_to(sigma_m));
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
    for (int i = 0; i < 100; ++i) {
      const auto correction = update.update(off - moved, sure_to(0.005));
      ASSERT_TRUE(correction) << i;
      moved += correction->step;
    }
    if (sigma_m > 0.01) {
      EXPECT_LT((moved - off).head<2>().norm(), 0.001);
    } else {
      EXPECT_LT(moved.head<2>().norm(), 0.0005) << "all matches err alike: by the map's own error";
    }
  }
}

// More matches tell more, but not how the map itself errs there.
TEST(ZeroVelocity, ThePoseBecomesSurerUpToTheMapsOwnError) {
  ZeroVelocityUpdate update(sure_to(0.03));
  double before_m = 0.03;
  for (int i = 0; i < 200; ++i) {
    const auto correction = update.update(Eigen::Vector3d::Zero(), sure_to(0.005));
    ASSERT_TRUE(correction) << i;
    const double sigma_m = position_sigma_m(correction->covariance);
    EXPECT_LT(sigma_m, before_m + 1e-6);
    EXPECT_TRUE(is_semidefinite(correction->covariance));
    before_m = sigma_m;
  }
  EXPECT_GT(before_m, 0.001);
  EXPECT_LT(before_m, 0.005);
}

TEST(ZeroVelocity, AMatchFarOffEndsTheStop) {
  ZeroVelocityUpdate update(sure_to(0.005));
  EXPECT_TRUE(update.update({0.01, 0.0, 0.0}, sure_to(0.005)));
  EXPECT_FALSE(update.update({0.0, 0.06, 0.0}, sure_to(0.005)));
  EXPECT_FALSE(update.update({0.0, 0.0, deg_to_rad(3.0)}, sure_to(0.005)));
}

}  // namespace
}  // namespace marco::slam
