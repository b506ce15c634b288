#include "common/input/beam_times.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

namespace marco {
namespace {

using ::testing::HasSubstr;

constexpr double kPeriodS = 0.2;

// A turn of 208 beams; its times are those of a laser that turns five times a second, by a factor.
LaserScan turn(double factor) {
  LaserScan scan;
  scan.ranges_m.assign(208, 2.0F);
  scan.bearing_step_rad = -2.0 * std::numbers::pi / 208;
  for (int beam = 0; beam < 208; ++beam) {
    scan.time_offsets_s.push_back(static_cast<float>(factor * kPeriodS * beam / 208));
  }
  return scan;
}

double last_s(const LaserScan& scan) { return static_cast<double>(scan.time_offsets_s.back()); }

TEST(BeamTimes, ThatSpanATurnStay) {
  for (const double period_s : {kPeriodS, 0.18, 5.0 * kPeriodS, 0.0}) {
    LaserScan scan = turn(1.0);
    EXPECT_FALSE(repair_beam_times(scan, period_s)) << period_s;
    EXPECT_EQ(scan.time_offsets_s, turn(1.0).time_offsets_s);
  }
}

TEST(BeamTimes, InAWrongUnitAreRescaled) {
  for (const double factor : {1e-3, 1e-6, 1e3, 1e6}) {
    LaserScan scan = turn(factor);
    EXPECT_THAT(repair_beam_times(scan, kPeriodS).value_or(""), HasSubstr("rescaled"));
    EXPECT_NEAR(last_s(scan), kPeriodS * 207 / 208, 1e-4) << factor;
  }
}

TEST(BeamTimes, ThatSpanNoTurnInAnyUnitStay) {
  LaserScan missing = turn(1.0), alike = turn(0.0), silly = turn(20.0);
  missing.time_offsets_s.clear();
  for (LaserScan* scan : {&missing, &alike, &silly}) {
    const std::vector<float> before = scan->time_offsets_s;
    EXPECT_FALSE(repair_beam_times(*scan, kPeriodS));
    EXPECT_EQ(scan->time_offsets_s, before);
  }
}

TEST(BeamTimes, OfALaserThatSeesOneSideStay) {
  LaserScan scan = turn(1e-3);
  scan.bearing_step_rad *= 0.75;
  EXPECT_FALSE(repair_beam_times(scan, kPeriodS));
  scan.bearings_rad.resize(208);
  for (std::size_t beam = 0; beam < 208; ++beam) {
    scan.bearings_rad[beam] = static_cast<float>(3.0 - 0.03 * static_cast<double>(beam));
  }
  EXPECT_TRUE(repair_beam_times(scan, kPeriodS)) << "357 degrees by their bearings";
}

}  // namespace
}  // namespace marco
