#include "slam/process/one_laser.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/pose2.hpp"

namespace marco::slam {
namespace {

constexpr int kBeams = 181;
constexpr Utime kStart = Utime::from_us(1'600'000'000'000'000);

/// A rectangular room, seen from a place of it over 180 deg.
LaserScan scan_at(double at_s, const Pose2& room_from_laser, double width_m, double height_m) {
  LaserScan scan;
  scan.utime = kStart + Duration::from_seconds(at_s);
  scan.first_bearing_rad = deg_to_rad(-90.0);
  scan.bearing_step_rad = deg_to_rad(1.0);
  for (std::size_t beam = 0; beam < kBeams; ++beam) {
    const double bearing = room_from_laser.theta_rad + scan.bearing_rad(beam);
    const double c = std::cos(bearing), s = std::sin(bearing);
    const double x_m = (c > 0.0 ? width_m - room_from_laser.x_m : -room_from_laser.x_m) / c;
    const double y_m = (s > 0.0 ? height_m - room_from_laser.y_m : -room_from_laser.y_m) / s;
    scan.ranges_m.push_back(static_cast<float>(std::min(x_m, y_m)));
  }
  return scan;
}

/// Ours drives and turns at 40 deg/s in a room of 6 m x 4 m.
LaserScan ours(double at_s) { return scan_at(at_s, {1.0 + 0.3 * at_s, 2.0, 0.7 * at_s}, 6.0, 4.0); }
LaserScan others(double at_s) { return scan_at(at_s, {9.0, 1.0, 2.0}, 20.0, 2.5); }

struct Count {
  int ours_refused = 0, others_taken = 0;
};

/// 37.5 scans a second of ours for 10 s; the other's `others_per_s` between 4 s and 8 s.
Count run(double jitter_s, double others_per_s) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter(-jitter_s, jitter_s);
  OneLaser guard;
  Count count;
  double next_other_s = 4.007;
  for (int i = 0; i < 375; ++i) {
    const double at_s = i / 37.5;
    while (others_per_s > 0.0 && next_other_s < std::min(at_s, 8.0)) {
      if (guard.is_ours(others(next_other_s))) ++count.others_taken;
      next_other_s += 1.0 / others_per_s;
    }
    LaserScan scan = ours(at_s);
    scan.utime = scan.utime + Duration::from_seconds(jitter(random));
    if (!guard.is_ours(scan)) ++count.ours_refused;
  }
  return count;
}

TEST(OneLaser, RefusesASecondOneOnItsChannelAndNothingOfItsOwn) {
  for (const double others_per_s : {5.0, 25.0, 37.5, 75.0}) {
    const Count count = run(0.002, others_per_s);
    EXPECT_EQ(count.ours_refused, 0) << others_per_s;
    // The first may come where one of ours could have come; two if that one came as late.
    EXPECT_LE(count.others_taken, 2) << others_per_s;
  }
}

TEST(OneLaser, AloneNothingIsRefusedHoweverItsStampsCome) {
  for (const double jitter_s : {0.0, 0.002, 0.01, 0.5}) {
    EXPECT_EQ(run(jitter_s, 0.0).ours_refused, 0) << jitter_s;
  }
}

// As from lasers that give as many beams as they happen to measure; one stamp stumbles.
TEST(OneLaser, ScansThatAreNotAlikeByThemselvesAreAllTaken) {
  OneLaser guard;
  for (int i = 0; i < 200; ++i) {
    LaserScan scan = ours(i / 37.5 - (i == 100 ? 0.02 : 0.0));
    scan.ranges_m.resize(scan.size() - static_cast<std::size_t>(i % 7));
    EXPECT_TRUE(guard.is_ours(scan)) << i;
  }
}

// Carried elsewhere at once, and its stamps stumble: it is lost for a moment, not for good.
TEST(OneLaser, WhatLastsIsBelieved) {
  OneLaser guard;
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    const double at_s = i / 37.5 + (i == 100 ? -0.02 : 0.0);
    if (!guard.is_ours(i < 100 ? ours(0.0 * at_s) : others(at_s))) ++refused;
  }
  EXPECT_LE(refused, 40);  // kMemory of 37.5 a second
}

}  // namespace
}  // namespace marco::slam
