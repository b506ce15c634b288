#include "common/input/floor_line.hpp"

#include <gtest/gtest.h>

namespace marco {
namespace {

// The line lies 2 m from the laser under 40 deg: at 2 m / cos of the angle to it.
TEST(FloorLine, TakesReturnsOnTheLineAndBeyond) {
  LaserScan scan;
  scan.first_bearing_rad = deg_to_rad(40.0);
  scan.bearing_step_rad = deg_to_rad(60.0);
  scan.ranges_m = {1.9F, 3.9F, 9.0F, 9.0F, 9.0F, 3.9F};
  const FloorLine floor{"LIDAR", 40.0, 2.0};
  EXPECT_EQ(blank(scan, floor), 0U);
  EXPECT_EQ(scan.ranges_m, (std::vector<float>{1.9F, 3.9F, 9.0F, 9.0F, 9.0F, 3.9F}));
  scan.ranges_m = {2.1F, 4.1F, 9.0F, 9.0F, 9.0F, 4.1F};
  EXPECT_EQ(blank(scan, floor), 3U);
  EXPECT_EQ(scan.ranges_m, (std::vector<float>{0.0F, 0.0F, 9.0F, 9.0F, 9.0F, 0.0F}));
}

TEST(FloorLine, IsDescribed) {
  EXPECT_EQ(describe({"LIDAR", 0.0, 2.31}),
            "LIDAR is not level: its beams under 0 deg reach the floor or the ceiling at 2.31 m");
}

}  // namespace
}  // namespace marco
