#include "common/input/own_body.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco {
namespace {

using ::testing::HasSubstr;

/// What a robot's laser has to do with its body.
using OnBoard = std::function<void(LaserScan&, std::mt19937&)>;

void nothing(LaserScan&, std::mt19937&) {}

// A post 0.3 m away from bearing 30 to 36 deg, in half a degree's beams.
void post(LaserScan& scan, std::mt19937& random) {
  std::normal_distribution<float> noise(0.30F, 0.006F);
  for (std::size_t beam = 240; beam <= 252; ++beam) scan.ranges_m[beam] = noise(random);
}

// Round a ring of corridors, so far from the outer wall; turning by steps of 9 deg in corners.
OwnBody after_the_ring(const OnBoard& on_board, double from_wall_m) {
  testing::FlatWorld ring;
  ring.add_box(-7, -5, 7, 5);
  ring.add_box(-4, -2, 4, 2);
  ring.add_box(5.6, -0.5, 6.0, 0.1);
  std::mt19937 random(3);
  std::normal_distribution<double> wanders(0.0, 0.003);
  OwnBody body;
  Pose2 robot{-7.0 + from_wall_m, -5.0 + from_wall_m, 0.0};
  for (int side = 0; side < 8; ++side) {
    const double length_m = (side % 2 == 0 ? 14.0 : 10.0) - 2.0 * from_wall_m;
    for (double driven_m = 0.0; driven_m < length_m + 1.0; driven_m += 0.1) {
      const bool turns = driven_m >= length_m;
      robot = robot * (turns ? Pose2{0, 0, deg_to_rad(9)} : Pose2{0.1, wanders(random), 0});
      LaserScan scan = ring.scan(robot, 0.01, &random);
      on_board(scan, random);
      body.look(scan);
    }
  }
  return body;
}

TEST(OwnBody, APostOnTheRobotIsFound) {
  const OwnBody body = after_the_ring(post, 1.5);
  ASSERT_EQ(body.parts().size(), 1U);
  const BodyPart& part = body.parts().front();
  EXPECT_EQ(part.channel, "LIDAR");
  EXPECT_NEAR(part.first_deg, 30.0, 1.0);
  EXPECT_NEAR(part.last_deg, 36.0, 1.0);
  EXPECT_NEAR(part.within_m, 0.36, 0.02);
  EXPECT_THAT(describe(body.parts()), HasSubstr("the robot itself is in view of LIDAR: "));
}

TEST(OwnBody, WallsThatAreFollowedAreNoBody) {
  for (const double from_wall_m : {0.3, 0.5, 0.8}) {
    const OwnBody body = after_the_ring(nothing, from_wall_m);
    EXPECT_GT(body.samples(), 40) << from_wall_m;
    EXPECT_TRUE(body.parts().empty()) << from_wall_m << ": " << describe(body.parts());
  }
}

TEST(OwnBody, AStandingRobotShowsNothing) {
  const testing::FlatWorld room = testing::small_room();
  std::mt19937 random(5);
  OwnBody body;
  for (int i = 0; i < 300; ++i) {
    LaserScan scan = room.scan({1.2, -0.6, 0.3}, 0.01, &random);
    // Somebody walks by.
    for (std::size_t beam = 0; beam < 40; ++beam) {
      scan.ranges_m[(beam + 7 * static_cast<std::size_t>(i)) % scan.size()] = 0.9F;
    }
    body.look(scan);
  }
  EXPECT_TRUE(body.parts().empty()) << describe(body.parts());
}

TEST(OwnBody, PartsThatAreTakenOffAreForgotten) {
  OwnBody body = after_the_ring(post, 1.5);
  const testing::FlatWorld room = testing::small_room();
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) body.look(room.scan({0.0, 0.0, 0.3 * i}, 0.01, &random));
  EXPECT_TRUE(body.parts().empty()) << describe(body.parts());
}

TEST(OwnBody, MoreThanHalfOfTheViewIsNoBody) {
  const auto parts_of = [](std::size_t constant_beams) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> changing(1.5F, 9.0F);
    OwnBody body;
    for (int i = 0; i < 60; ++i) {
      LaserScan scan;
      scan.first_bearing_rad = deg_to_rad(0.5);
      scan.bearing_step_rad = deg_to_rad(1.0);
      for (std::size_t beam = 0; beam < 360; ++beam) {
        scan.ranges_m.push_back(beam >= 20 && beam < 20 + constant_beams ? 0.3F : changing(random));
      }
      body.look(scan);
    }
    return body.parts().size();
  };
  EXPECT_EQ(parts_of(170), 1U);
  EXPECT_EQ(parts_of(190), 0U);
}

TEST(OwnBody, BlankTakesNearReturnsOfItsSectorAlone) {
  LaserScan scan;
  scan.bearing_step_rad = deg_to_rad(1.0);
  scan.ranges_m.assign(360, 0.3F);
  scan.ranges_m[355] = 2.0F;
  blank(scan, {"LIDAR", 350.0, 365.0, 0.35});
  for (std::size_t beam = 0; beam < 360; ++beam) {
    const bool in_sector = beam >= 349 || beam <= 6;
    EXPECT_EQ(scan.ranges_m[beam], beam == 355 ? 2.0F : in_sector ? 0.0F : 0.3F) << beam;
  }
}

}  // namespace
}  // namespace marco
