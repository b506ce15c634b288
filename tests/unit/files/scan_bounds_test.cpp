#include "recordings/scan_bounds.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco {
namespace {

using ::marco::testing::complaint;
using ::testing::HasSubstr;

std::string refusal_of(std::size_t beams, double step_rad) {
  LaserScan scan;
  scan.ranges_m.assign(beams, 1.0F);
  scan.bearing_step_rad = step_rad;
  return complaint([&] { require_scan(scan); });
}

TEST(ScanBounds, TakeScansOfLasersAlone) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  EXPECT_EQ(refusal_of(360, kTurn / 360), "");
  EXPECT_EQ(refusal_of(360, -kTurn / 180), "");
  EXPECT_EQ(refusal_of(25'200, kTurn / 25'200), "");  // the densest that is sold
  EXPECT_THAT(refusal_of(1, 0.1), HasSubstr("fewer than 2 beams"));
  EXPECT_THAT(refusal_of(1'000'000, 1e-6), HasSubstr("more than 100000 beams"));
  EXPECT_THAT(refusal_of(360, 1e30), HasSubstr("go round three times"));
  EXPECT_THAT(refusal_of(360, -1.0), HasSubstr("go round three times"));
}

// As of clouds, whose points come in any order.
TEST(ScanBounds, TakeBearingsInAnyOrder) {
  LaserScan scan;
  scan.ranges_m.assign(400, 1.0F);
  for (int beam = 0; beam < 400; ++beam) {
    scan.bearings_rad.push_back(static_cast<float>(2.0 * beam - 400.0));
  }
  EXPECT_EQ(complaint([&] { require_scan(scan); }), "");
}

}  // namespace
}  // namespace marco
