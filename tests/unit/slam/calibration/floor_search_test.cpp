#include "slam/calibration/floor_search.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

struct TiltedLaser {
  double floor_m = std::numeric_limits<double>::infinity();  // distance of the line
  double floor_deg = 0.0;                                    // its bearing, in the laser's frame
  double clipped_m = std::numeric_limits<double>::infinity();
  Pose2 robot_from_sensor = {};
  int half_view_deg = 120;
};

testing::FlatWorld hall() {
  testing::FlatWorld world;
  world.add_box(0.0, 0.0, 14.0, 9.0);
  world.add_chain({{5.0, 0.0}, {5.0, 3.5}});
  world.add_chain({{5.0, 5.5}, {5.0, 9.0}});
  world.add_box(9.0, 3.0, 10.0, 4.5);
  return world;
}

Keyframe seen_from(const testing::FlatWorld& world,
                   const Pose2& robot,
                   const TiltedLaser& laser,
                   std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, 0.01);
  const Pose2 sensor = robot * laser.robot_from_sensor;
  Keyframe key;
  key.world_from_robot = robot;
  key.sensor_in_robot = laser.robot_from_sensor.translation_m();
  key.sensor_heading_rad = laser.robot_from_sensor.theta_rad;
  Points2 points(2, 2 * laser.half_view_deg + 1);
  for (int beam = 0; beam < points.cols(); ++beam) {
    const double bearing_rad = deg_to_rad(beam - laser.half_view_deg);
    const double ahead = std::cos(bearing_rad - deg_to_rad(laser.floor_deg));
    const double wall_m = world.range_m(sensor.translation_m(), sensor.theta_rad + bearing_rad);
    const double floor_m = ahead > 0.0 ? laser.floor_m / ahead : laser.floor_m;
    const double range_m = std::min({wall_m, floor_m, laser.clipped_m}) + noise(random);
    points.col(beam) = range_m * Eigen::Vector2d(std::cos(bearing_rad), std::sin(bearing_rad));
  }
  key.points_in_robot.points = laser.robot_from_sensor * points;
  key.points_in_robot.normals = Points2::Zero(2, points.cols());
  return key;
}

std::vector<Keyframe> walk(const TiltedLaser& laser, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(0.6, 8.5), y(0.6, 8.4), turn(-0.5, 0.5);
  const testing::FlatWorld world = hall();
  std::vector<Keyframe> keys;
  Pose2 robot{2.0, 2.0, 0.0};
  while (keys.size() < 300) {
    robot = robot * Pose2{0.3, 0.0, turn(random)};
    if (robot.x_m < 0.6 || robot.x_m > 13.4 || robot.y_m < 0.6 || robot.y_m > 8.4) {
      robot = {x(random), y(random), robot.theta_rad + 2.0};
    }
    keys.push_back(seen_from(world, robot, laser, random));
  }
  return keys;
}

// Round by round, a wall always 0.7 m to the right.
std::vector<Keyframe> along_the_walls(const TiltedLaser& laser, const testing::FlatWorld& world) {
  std::mt19937 random(5);
  const std::vector<Pose2> corners{{0.7, 0.7, 0.0},
                                   {13.3, 0.7, std::numbers::pi / 2},
                                   {13.3, 8.3, std::numbers::pi},
                                   {0.7, 8.3, -std::numbers::pi / 2}};
  std::vector<Keyframe> keys;
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Pose2 &from = corners[i], &to = corners[(i + 1) % corners.size()];
      const double way_m = (to.translation_m() - from.translation_m()).norm();
      for (double done_m = 0.0; done_m < way_m; done_m += 0.3) {
        keys.push_back(seen_from(world, from * Pose2{done_m, 0.0, 0.0}, laser, random));
      }
      for (double turned = 0.25; turned < 1.5; turned += 0.25) {
        keys.push_back(seen_from(world, {to.x_m, to.y_m, from.theta_rad + turned}, laser, random));
      }
    }
  }
  return keys;
}

TEST(FloorSearch, TheFloorIsFoundWhereverTheLaserLooksDown) {
  for (const double floor_m : {1.2, 2.3, 3.5}) {
    for (const double floor_deg : {0.0, 55.0, -100.0}) {
      for (const Pose2& place : {Pose2{}, Pose2{0.2, -0.1, 2.4}}) {
        TiltedLaser laser;
        laser.floor_m = floor_m;
        laser.floor_deg = floor_deg;
        laser.robot_from_sensor = place;
        const auto found = find_floor(walk(laser, 7));
        ASSERT_TRUE(found) << floor_m << " " << floor_deg;
        EXPECT_NEAR(found->bearing_deg, floor_deg, 4.0);
        // What is left in front of the line is a wall's.
        EXPECT_LT(found->from_m, floor_m - 0.015) << floor_deg;
        EXPECT_GT(found->from_m, 0.9 * floor_m) << floor_deg;
      }
    }
  }
}

TEST(FloorSearch, ALevelLaserSeesNone) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) EXPECT_FALSE(find_floor(walk({}, seed))) << seed;
}

TEST(FloorSearch, AWallThatIsFollowedIsNone) {
  EXPECT_FALSE(find_floor(along_the_walls({}, hall())));
  testing::FlatWorld empty;
  empty.add_box(0.0, 0.0, 14.0, 9.0);
  EXPECT_FALSE(find_floor(along_the_walls({}, empty)));
  TiltedLaser floor;
  floor.floor_m = 2.3;
  const auto found = find_floor(along_the_walls(floor, hall()));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->bearing_deg, 0.0, 4.0);
}

// Four headings, and a wall always 1.2 m to the right: it was taken for the floor.
TEST(FloorSearch, TheOuterWallOfARingOfCorridorsIsNone) {
  testing::FlatWorld ring;
  ring.add_box(0.0, 0.0, 30.0, 20.0);
  ring.add_box(2.4, 2.4, 27.6, 17.6);
  const std::vector<Pose2> corners{{1.2, 1.2, 0.0},
                                   {28.8, 1.2, std::numbers::pi / 2},
                                   {28.8, 18.8, std::numbers::pi},
                                   {1.2, 18.8, -std::numbers::pi / 2}};
  TiltedLaser laser;
  laser.half_view_deg = 90;
  std::mt19937 random(6);
  std::vector<Keyframe> keys;
  for (int leg = 0; leg < 8; ++leg) {
    const Pose2 &from = corners[leg % 4], &to = corners[(leg + 1) % 4];
    const double way_m = (to.translation_m() - from.translation_m()).norm();
    for (double done_m = 0.0; done_m < way_m; done_m += 0.5) {
      keys.push_back(seen_from(ring, from * Pose2{done_m, 0.0, 0.0}, laser, random));
    }
    keys.push_back(seen_from(ring, {to.x_m, to.y_m, from.theta_rad + 0.8}, laser, random));
  }
  EXPECT_FALSE(find_floor(keys));
}

// Two headings across each other, and never a look aside.
TEST(FloorSearch, AWallOnOneSideOfTwoCorridorsCannotBeTold) {
  testing::FlatWorld corner;
  corner.add_chain({{0.0, 0.0}, {40.0, 0.0}, {40.0, 40.0}, {38.0, 40.0}, {38.0, 2.0}, {0.0, 2.0}});
  std::mt19937 random(4);
  std::vector<Keyframe> keys;
  for (double way_m = 1.0; way_m < 36.0; way_m += 0.3) {
    keys.push_back(seen_from(corner, {way_m, 0.7, 0.0}, {}, random));
    keys.push_back(seen_from(corner, {39.3, 2.0 + way_m, std::numbers::pi / 2}, {}, random));
  }
  EXPECT_FALSE(find_floor(keys));
}

TEST(FloorSearch, TheFarthestRangeIsNone) {
  TiltedLaser laser;
  laser.clipped_m = 3.0;
  EXPECT_FALSE(find_floor(walk(laser, 9)));
}

TEST(FloorSearch, AlongOneCorridorAWallCannotBeTold) {
  testing::FlatWorld corridor;
  corridor.add_box(0.0, 0.0, 60.0, 2.0);
  std::mt19937 random(3);
  std::vector<Keyframe> keys;
  for (const double heading : {0.0, std::numbers::pi}) {
    for (double x = 5.0; x < 55.0; x += 0.3) {
      keys.push_back(seen_from(corridor, {x, 1.0, heading}, {}, random));
    }
  }
  EXPECT_FALSE(find_floor(keys));
}

}  // namespace
}  // namespace marco::slam
