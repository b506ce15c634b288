#include "mapping3d/straightening.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

constexpr double kSigmaM = 0.005;
constexpr std::size_t kRows = 60;

/// Three sweeps of a tilt that sticks and jumps: a sawtooth of `height_rad` about what it says,
/// elsewhere in each. Ranges say `short_m` too little.
std::vector<Scene> sweeps(double height_rad, double short_m) {
  constexpr std::size_t kTooth = 15;
  std::mt19937 random(5);
  std::vector<Scene> bent;
  std::size_t shift = 0;
  for (const Pose3& sensor : {make_pose3({-1.5, 0.2, 0.9}), make_pose3({0.1, -0.6, 0.8}),
                              make_pose3({-0.4, 1.1, 1.0}, 0.0, 0.0, -0.3)}) {
    Scene scene = AnalyticRoom::sweep(sensor, kRows, kSigmaM, random);
    for (std::size_t row = 0; row < kRows; ++row) {
      const double part = static_cast<double>((row + shift) % kTooth) / kTooth;
      SceneRow& line = scene.rows[row];
      // Looking up is a negative pitch: the row was higher by its error than it says.
      const Pose3 lower = make_pose3(Eigen::Vector3d::Zero(), 0.0, height_rad * (part - 0.5));
      line.robot_from_sensor_first = line.robot_from_sensor_first * lower;
      line.robot_from_sensor_last = line.robot_from_sensor_first;
      for (float& range_m : line.ranges_m) range_m -= static_cast<float>(short_m);
    }
    bent.push_back(std::move(scene));
    shift += 6;
  }
  return bent;
}

std::vector<Pose3> unmoved(const std::vector<Scene>& scenes) {
  return std::vector<Pose3>(scenes.size(), Pose3::Identity());
}

TEST(Straighten, FindsWhereRowsWereAndTheZeroOfTheRanges) {
  const std::vector<Scene> bent = sweeps(deg_to_rad(2.0), 0.03);
  StraighteningOptions options;
  options.iterations = 12;
  const Straightening found = straighten(bent, {}, unmoved(bent), {}, options);
  ASSERT_TRUE(found.bent);
  EXPECT_GT(found.explained, 0.5);
  for (std::size_t i = 0; i < bent.size(); ++i) {
    EXPECT_GT(AnalyticRoom::p90_off_m(place(bent[i])), 0.035) << i;
    ScenePoints mended = place(straightened(bent[i], found.turns_rad[i], found.range_m));
    move(mended, found.world_from_placed[i]);
    // 5 mm of noise alone are 8 mm; what remains is the corners of the teeth, rounded by what
    // neighbouring rows share.
    EXPECT_LT(AnalyticRoom::p90_off_m(mended), 0.015) << i;
  }
  EXPECT_NEAR(found.range_m, 0.03, 0.005);
}

TEST(Straighten, DropsWhatLeavesTheResidualsTooLarge) {
  const std::vector<Scene> bent = sweeps(deg_to_rad(2.0), 0.03);
  StraighteningOptions options;
  options.iterations = 4;
  options.max_left = 0.1;  // noise alone is more
  const Straightening found = straighten(bent, {}, unmoved(bent), {}, options);
  EXPECT_GT(found.explained, options.min_explained);
  EXPECT_FALSE(found.bent);
  EXPECT_EQ(found.turns_rad[0], RowTurns(kRows, 0.0));
  EXPECT_EQ(found.range_m, 0.0);
}

// One step of Gauss-Newton moves the rows of both scenes: half as far each as one alone would go.
TEST(Straighten, TheRowsOfBothScenesMoveInOneStep) {
  std::vector<Scene> two = sweeps(0.0, 0.0);
  two.resize(2);
  const double turn_rad = deg_to_rad(0.8);
  for (SceneRow& row : two[0].rows) {
    row.robot_from_sensor_first =
        row.robot_from_sensor_first * make_pose3(Eigen::Vector3d::Zero(), 0.0, turn_rad);
    row.robot_from_sensor_last = row.robot_from_sensor_first;
  }
  StraighteningOptions options;
  options.iterations = 1;
  options.min_explained = 0.0;
  options.max_left = 1.0;
  const Straightening found = straighten(two, {}, unmoved(two), {0, 0}, options);
  ASSERT_TRUE(found.bent);
  const auto mean_rad = [](const RowTurns& turns) {
    return std::accumulate(turns.begin(), turns.end(), 0.0) / static_cast<double>(turns.size());
  };
  EXPECT_NEAR(mean_rad(found.turns_rad[0]) - mean_rad(found.turns_rad[1]), turn_rad,
              0.25 * turn_rad);
}

TEST(Straighten, LeavesStraightSweepsAlone) {
  const std::vector<Scene> straight = sweeps(0.0, 0.0);
  const Straightening found = straighten(straight, {}, unmoved(straight), {});
  EXPECT_FALSE(found.bent);
  EXPECT_LT(found.explained, 0.3);
  EXPECT_EQ(found.turns_rad[0], RowTurns(kRows, 0.0));
  EXPECT_EQ(found.range_m, 0.0);
  EXPECT_TRUE(found.world_from_placed[1].isApprox(Pose3::Identity()));
}

// Of a long log only a part is looked at first.
TEST(Straighten, LooksAtAllOfALongLogOnlyWhereAPartIsBent) {
  for (const double height_deg : {0.0, 2.0}) {
    const std::vector<Scene> three = sweeps(deg_to_rad(height_deg), 0.0);
    std::vector<Scene> scenes;
    for (std::size_t i = 0; i < 9; ++i) scenes.push_back(three[i / 2 % 3]);
    StraighteningOptions options;
    options.iterations = 5;
    options.probed_scenes = 4;
    const Straightening found = straighten(scenes, {}, unmoved(scenes), {}, options);
    EXPECT_EQ(found.bent, height_deg > 0.0);
    ASSERT_EQ(found.turns_rad.size(), scenes.size());
    EXPECT_EQ(found.world_from_placed.size(), scenes.size());
    EXPECT_EQ(found.turns_rad[8] == RowTurns(kRows, 0.0), height_deg == 0.0);
  }
}

TEST(Straighten, TakesNothingAndWhatDoesNotOverlap) {
  EXPECT_FALSE(straighten({}, {}, {}, {}).bent);
  std::vector<Scene> apart(2, sweeps(0.0, 0.0)[0]);
  for (SceneRow& row : apart[1].rows) row.world_from_robot.x_m = 100.0;
  const std::vector<Pose3> poses(2, Pose3::Identity());
  EXPECT_FALSE(straighten(apart, {}, poses, {}).bent);
  EXPECT_FALSE(straighten({Scene{}, Scene{}}, {}, poses, {}).bent);
  EXPECT_THROW(straighten(apart, {}, {Pose3::Identity()}, {}), std::invalid_argument);
  EXPECT_THROW(straighten(apart, {}, poses, {0}), std::invalid_argument);
  EXPECT_THROW(straightened(apart[0], {0.0}, 0.0), std::invalid_argument);
}

TEST(SweepAxis, GoesThroughTheTiltAxisOfALeveredLaser) {
  Scene scene;
  const Eigen::Vector3d axis_m(0.3, 0.0, 0.7), lever_m(0.05, 0.0, 0.02);
  for (int i = 0; i < 20; ++i) {
    SceneRow row;
    row.robot_from_sensor_first =
        make_pose3(axis_m, 0.0, -deg_to_rad(-20.0 + i)) * make_pose3(lever_m);
    scene.rows.push_back(row);
  }
  for (const std::size_t row : {0U, 9U, 19U}) {
    const SweepAxis axis = sweep_axis(scene, row);
    EXPECT_TRUE(axis.direction.isApprox(-Eigen::Vector3d::UnitY(), 1e-6));
    const Eigen::Vector3d off = axis.point_m - axis_m;
    EXPECT_LT(std::hypot(off.x(), off.z()), 1e-6);
  }
  for (SceneRow& row : scene.rows) row.robot_from_sensor_first = Pose3::Identity();
  EXPECT_EQ(sweep_axis(scene, 9).direction, Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace marco::mapping3d
