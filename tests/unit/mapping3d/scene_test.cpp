#include "mapping3d/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace marco::mapping3d {
namespace {

SceneRow row_at(double seconds, std::vector<float> ranges_m = {1.0F, 2.0F}) {
  SceneRow row;
  row.utime = Utime::from_seconds(seconds);
  row.ranges_m = std::move(ranges_m);
  row.first_bearing_rad = 0.0;
  row.bearing_step_rad = deg_to_rad(90);
  return row;
}

SceneRow row_at(double seconds, double pan_deg, double tilt_deg) {
  SceneRow row = row_at(seconds);
  row.robot_from_sensor_first = row.robot_from_sensor_last =
      make_pose3({0, 0, 0.5}, 0, -deg_to_rad(tilt_deg), deg_to_rad(pan_deg));
  return row;
}

TEST(Place, ABeamLiesAlongItsBearingInTheSensorsPose) {
  Scene scene;
  scene.rows = {row_at(0, {2.0F, 0.0F})};
  scene.rows[0].robot_from_sensor_first = scene.rows[0].robot_from_sensor_last =
      make_pose3({0.1, 0, 0.5}, 0, deg_to_rad(-90));  // looks straight up
  scene.rows[0].world_from_robot = {1, 1, deg_to_rad(180)};
  const ScenePoints points = place(scene);
  ASSERT_EQ(points.valid[0], 1);
  EXPECT_NEAR((points.points_m[0] - Eigen::Vector3f(0.9F, 1, 2.5F)).norm(), 0.0, 1e-5);
  EXPECT_EQ(points.valid[1], 0);  // no return
}

TEST(Place, BeamsOfAMovingSweepArePlacedBetweenItsEnds) {
  Scene scene;
  scene.rows = {row_at(0, {1.0F, 1.0F, 1.0F})};
  scene.rows[0].bearing_step_rad = 0.0;
  scene.rows[0].robot_from_sensor_last = make_pose3({0, 0, 0}, 0, deg_to_rad(-10));
  const ScenePoints points = place(scene);
  for (int i = 0; i < 3; ++i) {
    const float up = std::atan2(points.points_m[static_cast<std::size_t>(i)].z(),
                                points.points_m[static_cast<std::size_t>(i)].x());
    EXPECT_NEAR(up, deg_to_rad(5.0 * i), 1e-6);
  }
}

TEST(Place, BeamsOfADrivingRobotArePlacedAlongItsWay) {
  Scene scene;
  scene.rows = {row_at(0, {1.0F, 1.0F, 1.0F})};
  scene.rows[0].bearing_step_rad = 0.0;
  scene.rows[0].world_from_robot = {5.0, 0.0, deg_to_rad(90)};
  scene.rows[0].first_robot_from_last_robot = {0.2, 0.0, 0.0};
  const ScenePoints points = place(scene);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3f expected(5.0F, 1.0F + 0.1F * static_cast<float>(i), 0.0F);
    EXPECT_NEAR((points.points_m[static_cast<std::size_t>(i)] - expected).norm(), 0.0F, 1e-5F);
  }
}

TEST(Place, WhatTheBeamsSeeOfTheRobotAndWhatIsNoNumberIsLeftOut) {
  Scene scene;
  scene.rows = {
      row_at(0, {0.3F, 0.3F, std::nanf(""), -1.0F, std::numeric_limits<float>::infinity()})};
  const RobotBox robot{0.35, 0.1, 0.2, 0.5};  // ends 0.35 m ahead and 0.2 m to the left
  const ScenePoints points = place(scene, robot);
  EXPECT_EQ(points.valid, (std::vector<uint8_t>{0, 1, 0, 0, 0}));
  EXPECT_EQ(place(scene).valid, (std::vector<uint8_t>{1, 1, 0, 0, 0}));
}

// Feeds tilts [deg] a tenth of a second apart; @returns the rows of each finished scene.
std::vector<std::size_t> rows_of_scenes(const std::vector<double>& tilts_deg) {
  SceneBuilder builder;
  std::vector<std::size_t> rows;
  double seconds = 0;
  for (const double tilt_deg : tilts_deg) {
    const SceneRow row = row_at(seconds += 0.1, 0.0, tilt_deg);
    if (const auto scene = builder.add(row, 0.0, deg_to_rad(tilt_deg))) {
      rows.push_back(scene->rows.size());
    }
  }
  if (const auto scene = builder.finish()) rows.push_back(scene->rows.size());
  return rows;
}

std::vector<double> ramp(double from, double to, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(from + (to - from) * i / (count - 1));
  return values;
}

TEST(SceneBuilder, UpAndDownAreTwoScenes) {
  std::vector<double> tilts = ramp(-20, 20, 41);
  const std::vector<double> down = ramp(19, -20, 40);
  tilts.insert(tilts.end(), down.begin(), down.end());
  EXPECT_EQ(rows_of_scenes(tilts), (std::vector<std::size_t>{41, 40}));
}

TEST(SceneBuilder, AStandingLaserMakesNoScene) {
  EXPECT_TRUE(rows_of_scenes(std::vector<double>(100, 0.0)).empty());
}

TEST(SceneBuilder, RepeatedRowsOfAStepwiseSweepCountOnce) {
  std::vector<double> tilts;
  for (const double tilt : ramp(-20, 20, 21)) tilts.insert(tilts.end(), 3, tilt);
  EXPECT_EQ(rows_of_scenes(tilts), (std::vector<std::size_t>{21}));
}

TEST(SceneBuilder, ARowOfAnotherWidthIsPassedOverAndMissingRowsLeaveAGap) {
  SceneBuilder builder;
  for (int i = 0; i < 30; ++i) {
    if (i == 12 || i == 13) continue;  // lost
    SceneRow row = row_at(0.1 * i, 0.0, i);
    row.ranges_m.resize(i == 20 ? 3 : 2);
    EXPECT_FALSE(builder.add(row, 0.0, deg_to_rad(i)));
  }
  const auto scene = builder.finish();
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->rows.size(), 27U);
  EXPECT_EQ(builder.rows_without_scene(), 1);
}

// The seam's row belongs to both turns.
TEST(SceneBuilder, ASpinnersSweepEndsWithEachTurn) {
  SceneBuilder builder;
  std::vector<std::size_t> rows;
  for (int i = 0; i <= 900; ++i) {
    const double pan_rad = normalize_angle(deg_to_rad(i));
    SceneRow row = row_at(0.1 * i);
    row.robot_from_sensor_first = make_pose3({0, 0, 0.5}, deg_to_rad(90), 0, pan_rad);  // upright
    if (const auto scene = builder.add(row, pan_rad, 0.0)) {
      rows.push_back(scene->rows.size());
    }
  }
  EXPECT_EQ(rows, (std::vector<std::size_t>{361, 361}));
  EXPECT_EQ(builder.finish()->rows.size(), 181U);
}

// All of its beams lie in one plane: no row has anything above or below it.
TEST(SceneBuilder, ALevelLaserThatPansSweepsNothing) {
  const auto rows_of = [](double tilt_deg) {
    SceneBuilder builder;
    std::vector<std::size_t> rows;
    for (int i = 0; i < 90; ++i) {
      const SceneRow row = row_at(0.03 * i, 2.0 * i, tilt_deg);
      if (const auto scene = builder.add(row, deg_to_rad(2.0 * i), deg_to_rad(tilt_deg))) {
        rows.push_back(scene->rows.size());
      }
    }
    if (const auto scene = builder.finish()) rows.push_back(scene->rows.size());
    return rows;
  };
  EXPECT_TRUE(rows_of(0.0).empty());
  EXPECT_EQ(rows_of(-40.0), (std::vector<std::size_t>{90}));
}

// A pan that a level laser made before the sweep is no part of it.
TEST(SceneBuilder, ASweepBeginsWhereItsScanPlaneTurns) {
  SceneBuilder builder;
  for (int i = 0; i < 30; ++i) {
    EXPECT_FALSE(builder.add(row_at(0.03 * i, 2.0 * i, 0.0), deg_to_rad(2.0 * i), 0.0));
  }
  for (int i = 1; i < 20; ++i) {
    EXPECT_FALSE(builder.add(row_at(0.9 + 0.03 * i, 58.0, i), deg_to_rad(58), deg_to_rad(i)));
  }
  EXPECT_EQ(builder.finish()->rows.size(), 20U);
}

// Looks up and to both sides: 2 cm a row ahead, a stand, and back.
TEST(SceneBuilder, ARobotSweepsASteepLaserByDriving) {
  const auto rows_of = [](double pitch_deg) {
    SceneBuilder builder;
    std::vector<std::size_t> rows;
    for (int i = 0; i < 72; ++i) {
      SceneRow row = row_at(0.1 * i);
      row.robot_from_sensor_first = make_pose3({0, 0, 0.6}, 0, deg_to_rad(pitch_deg));
      row.world_from_robot.x_m = 0.02 * (i < 30 ? i : i < 42 ? 30 : 72 - i);
      if (const auto scene = builder.add(row, 0.0, 0.0)) rows.push_back(scene->rows.size());
    }
    if (const auto scene = builder.finish()) rows.push_back(scene->rows.size());
    return rows;
  };
  EXPECT_EQ(rows_of(-90.0), (std::vector<std::size_t>{31, 29}));
  EXPECT_TRUE(rows_of(-10.0).empty()) << "it sees walls, and maps";
}

// Each row is less than a step from the last one, on a path without noise.
TEST(SceneBuilder, ARobotThatCreepsSweepsASteepLaserToo) {
  SceneBuilder builder;
  for (int i = 0; i < 200; ++i) {
    SceneRow row = row_at(0.03 * i);
    row.robot_from_sensor_first = row.robot_from_sensor_last =
        make_pose3({0, 0, 0.5}, 0, deg_to_rad(-90));
    row.world_from_robot = {0.008 * i, 0, 0};
    ASSERT_FALSE(builder.add(row, 0, 0));
  }
  const auto scene = builder.finish();
  ASSERT_TRUE(scene);
  EXPECT_NEAR(scene->rows.back().world_from_robot.x_m - scene->rows.front().world_from_robot.x_m,
              0.008 * 199, 0.02);
}

TEST(SceneBuilder, AJumpEndsTheSweepAndFewRowsAreNone) {
  std::vector<double> tilts = ramp(-20, 0, 21);
  const std::vector<double> few = ramp(30, 33, 4);
  tilts.insert(tilts.end(), few.begin(), few.end());
  EXPECT_EQ(rows_of_scenes(tilts), (std::vector<std::size_t>{21}));
}

}  // namespace
}  // namespace marco::mapping3d
