#include "drivers/laser/regular_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "drivers/laser/beam_order.hpp"
#include "drivers/transport/baud_search.hpp"

namespace marco::drivers {
namespace {

TEST(RegularScan, ARegularScanOnlyLosesItsTimes) {
  LaserScan scan;
  scan.utime = Utime::from_us(5);
  scan.channel = "LIDAR_REAR";
  scan.ranges_m = {1.0F, 2.0F, 3.0F};
  scan.first_bearing_rad = -1.0;
  scan.bearing_step_rad = 0.5;
  scan.time_offsets_s = {0.0F, 0.1F, 0.2F};
  const LaserScan regular = regular_scan(scan);
  EXPECT_EQ(regular.utime, scan.utime);
  EXPECT_EQ(regular.channel, "LIDAR_REAR");
  EXPECT_EQ(regular.ranges_m, scan.ranges_m);
  EXPECT_EQ(regular.first_bearing_rad, -1.0);
  EXPECT_EQ(regular.bearing_step_rad, 0.5);
  EXPECT_TRUE(regular.time_offsets_s.empty());
}

// A clockwise turn across the seam at 180 degrees, each bearing off by up to `jitter` steps. The
// range of each beam is its number.
LaserScan turn(int beams, double jitter) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-jitter, jitter);
  LaserScan scan;
  const double step_rad = -2.0 * std::numbers::pi / beams;
  for (int i = 0; i < beams; ++i) {
    const bool end = i == 0 || i == beams - 1;
    scan.bearings_rad.push_back(
        static_cast<float>(normalize_angle((i + (end ? 0.0 : off(random))) * step_rad)));
    scan.ranges_m.push_back(static_cast<float>(i + 1));
  }
  return scan;
}

TEST(RegularScan, IrregularBearingsGoToTheNearestPlace) {
  const LaserScan regular = regular_scan(turn(720, 0.4));
  ASSERT_EQ(regular.size(), 720U);
  EXPECT_NEAR(regular.bearing_step_rad, -2.0 * std::numbers::pi / 720, 1e-6);
  for (std::size_t i = 0; i < regular.size(); ++i) {
    EXPECT_EQ(regular.ranges_m[i], static_cast<float>(i + 1));  // none moved to another place
  }
}

TEST(RegularScan, APlaceWithoutABeamIsNoReturn) {
  const LaserScan scan = turn(720, 1.5);
  const LaserScan regular = regular_scan(scan);
  int empty = 0;
  for (std::size_t i = 0; i < regular.size(); ++i) {
    if (regular.ranges_m[i] == 0.0F) {
      ++empty;
      continue;
    }
    const auto beam = static_cast<std::size_t>(regular.ranges_m[i]) - 1;
    const double off_rad = normalize_angle(regular.bearing_rad(i) - scan.bearing_rad(beam));
    EXPECT_LE(std::abs(off_rad), 0.5 * std::abs(regular.bearing_step_rad) + 1e-6) << i;
  }
  EXPECT_GT(empty, 50);
  EXPECT_LT(empty, 400);
}

TEST(RegularScan, ScansWithoutAFanStayHarmless) {
  EXPECT_EQ(regular_scan({}).size(), 0U);
  LaserScan one;
  one.ranges_m = {2.0F};
  one.bearings_rad = {0.3F};
  EXPECT_EQ(regular_scan(one).ranges_m, one.ranges_m);
  EXPECT_NEAR(regular_scan(one).first_bearing_rad, 0.3, 1e-6);
  LaserScan still;  // a motor that does not turn
  still.ranges_m = {1.0F, 1.0F, 1.0F};
  still.bearings_rad = {0.5F, 0.5F, 0.5F};
  EXPECT_EQ(regular_scan(still).ranges_m, std::vector<float>(3, 0.0F));
}

// 180 deg by 0.5 deg: whole degrees in the first turn, half degrees in the second.
TEST(BeamOrder, HalfDegreesAreMeasuredATurnLater) {
  const double turn_s = 1.0 / 75.0;
  EXPECT_DOUBLE_EQ(beam_time_s(0, 0.5, 2, turn_s), 0.0);
  EXPECT_DOUBLE_EQ(beam_time_s(1, 0.5, 2, turn_s), turn_s * (1.0 + 0.5 / 360.0));
  EXPECT_DOUBLE_EQ(beam_time_s(2, 0.5, 2, turn_s), turn_s / 360.0);
  EXPECT_DOUBLE_EQ(beam_time_s(360, 0.5, 2, turn_s), turn_s / 2.0);
  EXPECT_DOUBLE_EQ(beam_time_s(90, -1.0, 1, turn_s), turn_s / 4.0);  // clockwise
}

TEST(BaudSearch, TriesTheWantedRateFirstAndAllInTurn) {
  BaudSearch search(38400, {9600, 38400, 19200});
  for (const int rate : {38400, 9600, 19200, 38400, 9600}) EXPECT_EQ(search.next(), rate);
  search.restart();
  EXPECT_EQ(search.next(), 38400);
  EXPECT_EQ(search.next(), 9600);
  EXPECT_TRUE(search.drop_current());
  for (const int rate : {38400, 19200, 38400}) EXPECT_EQ(search.next(), rate);
  EXPECT_TRUE(search.drop_current());
  EXPECT_FALSE(search.drop_current());
}

}  // namespace
}  // namespace marco::drivers
