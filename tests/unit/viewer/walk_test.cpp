#include "viewer/walk.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco::viewer {
namespace {

using ::marco::testing::IsNear;

TEST(Walk, MovesByTheStepsOfTheRealRobot) {
  Walk walk({1.0, 2.0, deg_to_rad(90.0)});
  walk.apply({'a', 10});
  EXPECT_THAT(walk.world_from_robot(), IsNear(Pose2{1.0, 2.57, deg_to_rad(90.0)}, 1e-12, 1e-12));
  walk.apply({'i', 2});
  EXPECT_NEAR(walk.world_from_robot().theta_rad, deg_to_rad(94.7), 1e-12);
  walk.apply({'d', 2});
  walk.apply({'r', 10});
  EXPECT_THAT(walk.world_from_robot(), IsNear(Pose2{1.0, 2.0, deg_to_rad(90.0)}, 1e-12, 1e-12));
}

TEST(Walk, KeysMoveByOneUnit) {
  Walk walk({0.0, 0.0, 0.0});
  for (const char key : std::string("aaid")) EXPECT_TRUE(walk.press(key));
  EXPECT_THAT(walk.world_from_robot(), IsNear(Pose2{0.114, 0.0, 0.0}, 1e-12, 1e-12));
  EXPECT_TRUE(walk.press('e'));
  EXPECT_NEAR(rad_to_deg(walk.tilt_rad()), 3.4, 1e-9);
  for (int i = 0; i < 20; ++i) walk.press('E');
  EXPECT_NEAR(rad_to_deg(walk.tilt_rad()), -20.0, 1e-9);
  EXPECT_TRUE(walk.press('g'));
  EXPECT_NEAR(rad_to_deg(walk.pan_rad()), 21.8, 1e-9);
  EXPECT_TRUE(walk.press('G'));
  EXPECT_NEAR(walk.pan_rad(), 0.0, 1e-12);
  EXPECT_FALSE(walk.press('x'));
}

TEST(Walk, TiltAndPanGoToPositions) {
  Walk walk({0.0, 0.0, 0.0});
  walk.apply({'e', 10});
  EXPECT_NEAR(rad_to_deg(walk.tilt_rad()), 14.0, 1e-9);
  walk.apply({'e', 10});
  EXPECT_NEAR(rad_to_deg(walk.tilt_rad()), 14.0, 1e-9);  // a position, not a step
  walk.apply({'e', 1000});
  EXPECT_NEAR(rad_to_deg(walk.tilt_rad()), 45.0, 1e-9);
  walk.apply({'g', 4});
  EXPECT_NEAR(rad_to_deg(walk.pan_rad()), 87.2, 1e-9);
  const Camera camera = walk.camera();
  EXPECT_GT((camera.target_m - camera.eye_m).y(), 0.7);  // to the left
  EXPECT_GT((camera.target_m - camera.eye_m).z(), 0.7);  // and up
}

TEST(Walk, ReadsScriptsAndNamesWhatItDoesNotKnow) {
  const std::vector<WalkCommand> commands = parse_walk("a10 i5 # turn\ng2\n\n");
  ASSERT_EQ(commands.size(), 3U);
  EXPECT_EQ(commands[2].letter, 'g');
  EXPECT_EQ(commands[1].units, 5);
  for (const char* bad : {"x3", "a", "a-3", "a3.5", "a99999", "10a", "a1b"})
    EXPECT_THROW(parse_walk(bad), std::invalid_argument) << bad;
}

}  // namespace
}  // namespace marco::viewer
