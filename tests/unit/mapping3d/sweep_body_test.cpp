#include "mapping3d/sweep_body.hpp"

#include <gtest/gtest.h>

#include "mapping3d/mapper3d.hpp"
#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

const std::vector<Pose3> kStops = {make_pose3({-2.6, -0.8, 0.6}),
                                   make_pose3({-1.1, -0.7, 0.6}, 0.0, 0.0, 0.05),
                                   make_pose3({0.4, -0.9, 0.6}, 0.0, 0.0, -0.04)};

/// Puts a thing of the robot into rows, from one column to another, where nothing is nearer.
struct Thing {
  std::size_t first_column, last_column;
  float range_m;
  double hits = 1.0;  ///< part of the beams; the others see what is behind it

  void into(Scene& scene, std::mt19937& random) const {
    std::normal_distribution<float> noise(0.0F, 0.006F);
    std::uniform_real_distribution<double> dice;
    for (SceneRow& row : scene.rows) {
      for (std::size_t column = first_column; column <= last_column; ++column) {
        if (dice(random) < hits) row.ranges_m[column] = range_m + noise(random);
      }
    }
  }
};

// Beams of half a degree from -90 to 90 deg; the last ones lie along the axis of the tilt.
const Thing kFrame{356, 360, 1.45F};
const Thing kMast{260, 268, 0.8F};

std::vector<Scene> nodding(std::size_t stops, const std::vector<Thing>& things, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Scene> scenes;
  for (std::size_t i = 0; i < stops; ++i) {
    Scene scene = AnalyticRoom::sweep(kStops[i], 80, 0.005, random);
    scene.laser = "LIDAR";
    for (const Thing& thing : things) thing.into(scene, random);
    scenes.push_back(scene);
  }
  return scenes;
}

/// A laser that scans a vertical plane, panned by a degree a row.
Scene panned_vertical(const Pose3& world_from_pantilt, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, 0.005);
  Scene scene;
  scene.laser = "LIDAR";
  for (int pan_deg = -90; pan_deg < 90; ++pan_deg) {
    SceneRow row;
    row.first_bearing_rad = deg_to_rad(-90.0);
    row.bearing_step_rad = deg_to_rad(0.5);
    row.robot_from_sensor_first =
        world_from_pantilt *
        make_pose3(Eigen::Vector3d::Zero(), deg_to_rad(90.0), 0.0, deg_to_rad(pan_deg));
    row.robot_from_sensor_last = row.robot_from_sensor_first;
    for (int beam = 0; beam < 361; ++beam) {
      const double bearing = row.first_bearing_rad + beam * row.bearing_step_rad;
      const Eigen::Vector3d direction = row.robot_from_sensor_first.linear() *
                                        Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0);
      const double range_m =
          AnalyticRoom::range_m(row.robot_from_sensor_first.translation(), direction);
      row.ranges_m.push_back(static_cast<float>(range_m + noise(random)));
    }
    scene.rows.push_back(row);
  }
  return scene;
}

TEST(SweepBody, AFrameAtTheAxisOfTheTiltIsFoundFromThreeStops) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const std::vector<BodyPart> parts = find_own_body(nodding(3, {kFrame}, seed));
    ASSERT_EQ(parts.size(), 1U) << seed;
    EXPECT_EQ(parts[0].channel, "LIDAR");
    EXPECT_NEAR(parts[0].first_deg, 88.0, 1.0);
    EXPECT_NEAR(parts[0].last_deg, 91.0, 1.0);
    EXPECT_NEAR(parts[0].within_m, 1.52, 0.03);
  }
}

// They could be two walls.
TEST(SweepBody, TwoStopsAreTooFewThere) {
  EXPECT_TRUE(find_own_body(nodding(2, {kFrame}, 1)).empty());
}

TEST(SweepBody, BeamsThatGrazeItBelongToIt) {
  const Thing grazed{350, 355, 1.45F, 0.15};
  const std::vector<BodyPart> parts = find_own_body(nodding(3, {kFrame, grazed}, 4));
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].first_deg, 85.0, 1.0);
}

// It sweeps through the room by itself.
TEST(SweepBody, AMastAsideOfTheAxisIsFoundFromOneStop) {
  const std::vector<BodyPart> parts = find_own_body(nodding(1, {kMast}, 5));
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].first_deg, 40.0, 1.0);
  EXPECT_NEAR(parts[0].last_deg, 45.0, 1.0);
}

TEST(SweepBody, ARoomIsNone) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    EXPECT_TRUE(find_own_body(nodding(3, {}, seed)).empty()) << seed;
  }
}

// The same range under the same bearing wherever it stands: of the floor, and of a wall 0.9 m away.
TEST(SweepBody, TheFloorAndAWallThatIsFollowedAreNone) {
  std::mt19937 random(6);
  std::vector<Scene> panned, along_wall;
  for (const double x_m : {-2.6, -1.1, 0.4}) {
    panned.push_back(panned_vertical(make_pose3({x_m, -0.8, 0.6}), random));
    along_wall.push_back(AnalyticRoom::sweep(make_pose3({x_m, 2.1, 0.6}), 80, 0.005, random));
  }
  const std::vector<BodyPart> of_floor = find_own_body(panned);
  EXPECT_TRUE(of_floor.empty()) << describe(of_floor);
  const std::vector<BodyPart> of_wall = find_own_body(along_wall);
  EXPECT_TRUE(of_wall.empty()) << describe(of_wall);
}

TEST(SweepBody, AnotherLasersReturnsAreKept) {
  std::vector<Scene> scenes = nodding(1, {kFrame}, 7);
  const std::vector<float> before = scenes[0].rows[0].ranges_m;
  blank(scenes[0], {{"LIDAR_2", 80.0, 95.0, 2.0}});
  EXPECT_EQ(scenes[0].rows[0].ranges_m, before);
  blank(scenes[0], {{"LIDAR", 88.0, 91.0, 1.5}});
  EXPECT_EQ(scenes[0].rows[0].ranges_m[358], 0.0F);
  EXPECT_EQ(scenes[0].rows[0].ranges_m[340], before[340]);
}

TEST(SweepBody, TheModelIsMadeWithoutIt) {
  Mapper3d mapper;
  for (const Scene& scene : nodding(3, {kFrame}, 8)) {
    for (std::size_t i = 0; i < scene.rows.size(); ++i) {
      mapper.add(scene.rows[i], 0.0, deg_to_rad(static_cast<double>(i)), "LIDAR");
    }
    ASSERT_EQ(mapper.finish(), 1U);
  }
  mapper.refine();
  ASSERT_EQ(mapper.own_body().size(), 1U);
  for (const Scene& scene : mapper.scenes()) {
    for (const SceneRow& row : scene.rows) EXPECT_EQ(row.ranges_m[359], 0.0F);
  }
}

}  // namespace
}  // namespace marco::mapping3d
