#include "recordings/ros/bearing_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace marco::ros {
namespace {

// Of a laser of 181 beams a degree apart at 2 m, without those that `hides`.
template <class Hides>
CloudMessage cloud(const Hides& hides) {
  CloudMessage cloud;
  for (int beam = 0; beam <= 180; ++beam) {
    const float bearing_rad = static_cast<float>((beam - 90) * M_PI / 180.0);
    if (hides(beam)) continue;
    cloud.points.emplace_back(2.0F * std::cos(bearing_rad), 2.0F * std::sin(bearing_rad), 0.0F);
  }
  return cloud;
}

TEST(BearingGrid, BeamsThatACloudLeavesOutHaveNoReturn) {
  BearingGrid grid;
  grid.add(cloud([](int beam) { return beam < 40; }));
  grid.add(cloud([](int beam) { return beam > 100; }));
  const CloudMessage third = cloud([](int beam) { return beam % 3 == 0; });
  const std::vector<float> ranges_m = grid.ranges_m(third);
  ASSERT_EQ(ranges_m.size(), 181U);
  EXPECT_NEAR(grid.first_rad(), -M_PI / 2.0, 1e-6);
  EXPECT_NEAR(grid.step_rad(), M_PI / 180.0, 1e-6);
  EXPECT_EQ(ranges_m[60], 0.0F);
  EXPECT_NEAR(ranges_m[61], 2.0F, 1e-6);
}

TEST(BearingGrid, PointsBetweenTheBeamsAreOfNoGrid) {
  BearingGrid grid;
  CloudMessage odd = cloud([](int) { return false; });
  grid.add(odd);
  odd.points[50] = {2.0F * std::cos(0.008F), 2.0F * std::sin(0.008F), 0.0F};
  EXPECT_TRUE(grid.ranges_m(odd).empty());
  EXPECT_TRUE(BearingGrid().ranges_m(odd).empty());
}

}  // namespace
}  // namespace marco::ros
