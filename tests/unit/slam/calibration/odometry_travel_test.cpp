#include "slam/calibration/odometry_travel.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

StampedPose2 at(double seconds, const Pose2& pose) { return {Utime::from_seconds(seconds), pose}; }

TEST(OdometryTravel, SumsWhatWasCounted) {
  // A quarter circle of 1 m in two steps of a second, then straight on.
  const double half = 0.25 * std::numbers::pi;
  const Pose2 middle{std::sin(half), 1.0 - std::cos(half), half}, corner{1.0, 1.0, 2.0 * half};
  const OdometryTravel travel(
      {at(10, {}), at(11, middle), at(12, corner), at(13, {1.0, 2.0, 2.0 * half})});
  const ArcMotion all = travel.between_moments(10, 13);
  EXPECT_NEAR(all.ahead_m, 2.0 * half + 1.0, 1e-9);
  EXPECT_NEAR(all.left_m, 0.0, 1e-9);
  EXPECT_NEAR(all.turn_rad, 2.0 * half, 1e-9);
  const ArcMotion part = travel.between_moments(10.5, 11.25);
  EXPECT_NEAR(part.ahead_m, 0.75 * half, 1e-9);
  EXPECT_NEAR(part.turn_rad, 0.75 * half, 1e-9);
  EXPECT_NEAR(travel.between_moments(5, 10).ahead_m, 0.0, 1e-12) << "before it began";
}

TEST(OdometryTravel, GoesRoundMoreThanOnce) {
  Trajectory turns;
  for (int i = 0; i <= 20; ++i) turns.push_back(at(i * 0.5, {0, 0, normalize_angle(i * 1.0)}));
  EXPECT_NEAR(OdometryTravel(turns).between_moments(0, 10).turn_rad, 20.0, 1e-9);
}

TEST(OdometryTravel, KnowsNothingAcrossGapsAndJumps) {
  const OdometryTravel travel({at(0, {}), at(1, {0.1, 0, 0}), at(5, {0.5, 0, 0}),
                               at(6, {0.6, 0, 0}), at(6.5, {50, 0, 0}), at(7, {50.1, 0, 0})});
  EXPECT_TRUE(travel.knows(0, 1));
  EXPECT_FALSE(travel.knows(0.5, 1.5));
  EXPECT_FALSE(travel.knows(2, 3)) << "inside the gap";
  EXPECT_TRUE(travel.knows(5, 6));
  EXPECT_FALSE(travel.knows(5.5, 6.2)) << "it starts anew";
  EXPECT_TRUE(travel.knows(6.5, 7));
  EXPECT_FALSE(travel.knows(6.5, 7.5));
  EXPECT_FALSE(travel.knows(-1, 0.5));
  EXPECT_NEAR(travel.between_moments(5, 7).ahead_m, 0.2, 1e-9) << "the jump is no way";
}

TEST(OdometryTravel, LaterStampsThatStepBackReplace) {
  const OdometryTravel travel(
      {at(0, {}), at(1.5, {9, 0, 0}), at(0.5, {0.1, 0, 0}), at(1, {0.2, 0, 0})});
  EXPECT_NEAR(travel.between_moments(0, 1).ahead_m, 0.2, 1e-9);
  EXPECT_FALSE(travel.knows(0, 1.2));
}

TEST(ArcMotion, IsItsOwnInverse) {
  for (const double turn : {-3.0, -0.5, 0.0, 1e-9, 1e-4, 2.0}) {
    const ArcMotion motion{0.7, -0.2, turn};
    const ArcMotion again = ArcMotion::of(motion.moved());
    EXPECT_NEAR(again.ahead_m, 0.7, 1e-9);
    EXPECT_NEAR(again.left_m, -0.2, 1e-9);
    EXPECT_NEAR(again.turn_rad, turn, 1e-12);
  }
}

// One motion the slow way: a thousand small straight steps.
TEST(ArcMotion, IsManySmallSteps) {
  const ArcMotion motion{0.7, -0.2, 1.3};
  Pose2 slow;
  for (int i = 0; i < 1000; ++i) slow = slow * Pose2{0.7e-3, -0.2e-3, 1.3e-3};
  EXPECT_THAT(motion.moved(), IsNear(slow, 1e-3, 1e-9));
}

}  // namespace
}  // namespace marco::slam
