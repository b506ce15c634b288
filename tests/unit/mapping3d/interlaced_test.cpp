#include "mapping3d/interlaced.hpp"

#include <gtest/gtest.h>

#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

const Pose3 kNodding = make_pose3({-1.0, 0.2, 0.8});

Pose3 tilted(double tilt_deg) {
  return kNodding * make_pose3(Eigen::Vector3d::Zero(), 0.0, -deg_to_rad(tilt_deg), 0.0);
}

/// A row of beams a degree apart, shifted by multiples of 0.25 deg, while the tilt moves by 0.1
/// deg.
SceneRow row(double tilt_deg, int quarters) {
  SceneRow row;
  row.first_bearing_rad = deg_to_rad(-90.0 + 0.25 * quarters);
  row.bearing_step_rad = deg_to_rad(1.0);
  row.robot_from_sensor_first = tilted(tilt_deg);
  row.robot_from_sensor_last = tilted(tilt_deg + 0.1);
  for (int beam = 0; beam < 180; ++beam) {
    const double bearing_rad = row.first_bearing_rad + beam * row.bearing_step_rad;
    const Pose3 at = tilted(tilt_deg + 0.1 * beam / 179.0);
    const Eigen::Vector3d direction =
        at.linear() * Eigen::Vector3d(std::cos(bearing_rad), std::sin(bearing_rad), 0.0);
    row.ranges_m.push_back(static_cast<float>(AnalyticRoom::range_m(at.translation(), direction)));
  }
  return row;
}

/// As an LMS in interlaced mode sends them: 2, 3, 0, 1 quarters; the tilt does not move evenly.
Scene interlaced(std::size_t rows) {
  Scene scene;
  double tilt_deg = -20.0;
  for (std::size_t i = 0; i < rows; ++i) {
    scene.rows.push_back(row(tilt_deg, static_cast<int>((i + 2) % 4)));
    scene.rows.back().utime = Utime::from_us(static_cast<int64_t>(i) * 26667);
    tilt_deg += i % 2 == 0 ? 0.12 : 0.28;
  }
  return scene;
}

// Nothing of a scan moves but its place in the grid.
TEST(JoinedRows, HoldThePointsOfTheScansThatTheyAreMadeOf) {
  const Scene scans = interlaced(120);
  const Scene joined = joined_rows(scans);
  ASSERT_EQ(joined.rows.size(), 31U);  // two scans before the first shift of none
  ASSERT_EQ(joined.columns(), 720U);
  const ScenePoints before = place(scans), after = place(joined);
  for (std::size_t i = 2; i < scans.rows.size(); ++i) {
    const std::size_t joined_row = 1 + (i - 2) / 4, quarter = (i - 2) % 4;
    for (std::size_t beam = 0; beam < 180; ++beam) {
      const std::size_t at = after.index(joined_row, 4 * beam + quarter);
      ASSERT_EQ(after.valid[at], 1);
      const float off_m = (after.points_m[at] - before.points_m[before.index(i, beam)]).norm();
      ASSERT_LT(off_m, 1e-4F) << i << " " << beam;
    }
  }
}

TEST(JoinedRows, AMissingScanLeavesItsColumnsWithoutReturn) {
  Scene scans = interlaced(120);
  scans.rows.erase(scans.rows.begin() + 51);  // of shift 1
  const Scene joined = joined_rows(scans);
  ASSERT_EQ(joined.rows.size(), 31U);
  const std::vector<float>& ranges_m = joined.rows[1 + (51 - 2) / 4].ranges_m;
  EXPECT_EQ(ranges_m[4 * 50 + 1], 0.0F);
  EXPECT_GT(ranges_m[4 * 50 + 2], 0.0F);
}

TEST(JoinedRows, OtherScenesStayAsTheyAre) {
  std::mt19937 random(1);
  const Scene regular = AnalyticRoom::sweep(kNodding, 60, 0.005, random);
  EXPECT_EQ(joined_rows(regular).rows.size(), 60U);
  Scene drives = interlaced(120);
  for (std::size_t i = 0; i < drives.rows.size(); ++i) {
    drives.rows[i].world_from_robot.x_m = 0.002 * static_cast<double>(i);
  }
  EXPECT_EQ(joined_rows(drives).rows.size(), 120U);
  Scene coarse;  // the rows are farther apart than the beams: there is nothing between them
  for (int i = 0; i < 60; ++i) coarse.rows.push_back(row(-20.0 + 1.2 * i, i % 4));
  EXPECT_EQ(joined_rows(coarse).rows.size(), 60U);
  Scene jitters = interlaced(120);  // the first beam anywhere
  std::uniform_real_distribution<double> anywhere_deg(0.0, 1.0);
  for (SceneRow& scan : jitters.rows) {
    scan.first_bearing_rad = deg_to_rad(-90.0 + anywhere_deg(random));
  }
  EXPECT_EQ(joined_rows(jitters).rows.size(), 120U);
}

// The tilt of such a sweep moves by less than min_step_deg between some scans.
TEST(SceneBuilder, ScansBetweenTheBeamsOfTheLastAreNoRepeats) {
  SceneBuilder builder;
  for (int i = 0; i < 80; ++i) {
    const double tilt_deg = -20.0 + 0.4 * (i / 4) + 0.01 * (i % 4);
    SceneRow scan = row(tilt_deg, i % 4);
    scan.utime = Utime::from_us(int64_t{26667} * i);
    EXPECT_FALSE(builder.add(scan, 0.0, deg_to_rad(tilt_deg)));
    EXPECT_FALSE(builder.add(scan, 0.0, deg_to_rad(tilt_deg)));  // and this one is
  }
  const std::optional<Scene> scene = builder.finish();
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->rows.size(), 80U);
}

}  // namespace
}  // namespace marco::mapping3d
