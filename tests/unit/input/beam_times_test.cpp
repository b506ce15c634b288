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

// Stamped with another beam than the first.
TEST(BeamTimes, ThatSpanATurnFromAnotherMomentOnStay) {
  for (const float first_s : {-0.1F, 0.3F}) {
    LaserScan scan = turn(1.0);
    for (float& time_s : scan.time_offsets_s) time_s += first_s;
    const std::vector<float> before = scan.time_offsets_s;
    EXPECT_FALSE(repair_beam_times(scan, kPeriodS));
    EXPECT_EQ(scan.time_offsets_s, before);
    const auto span = span_of_turn(scan, kPeriodS);
    ASSERT_TRUE(span);
    EXPECT_EQ(span->first_s, first_s);
    EXPECT_EQ(span->last_s, before.back());
  }
}

TEST(BeamTimes, ThatSpanTwoPeriodsSpanNoTurn) {
  EXPECT_TRUE(span_of_turn(turn(1.0), kPeriodS));
  EXPECT_FALSE(span_of_turn(turn(1.0), 0.5 * kPeriodS));
  EXPECT_FALSE(span_of_turn(turn(3.0), 10.0 * kPeriodS)) << "0.6 s: none turns so slowly";
  EXPECT_FALSE(span_of_turn(turn(0.05), kPeriodS)) << "10 ms: none turns so fast";
}

TEST(BeamTimes, LasersTurnThreeToFiftyTimesASecond) {
  EXPECT_FALSE(is_turn_period(0.015));
  EXPECT_TRUE(is_turn_period(0.025));
  EXPECT_TRUE(is_turn_period(0.3));
  EXPECT_FALSE(is_turn_period(0.4));
}

}  // namespace
}  // namespace marco
