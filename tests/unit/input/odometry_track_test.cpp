#include "common/input/odometry_track.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

OdometrySample sample_at(double seconds, const Pose2& pose) {
  OdometrySample sample;
  sample.utime = Utime::from_seconds(seconds);
  sample.odom_from_robot = pose;
  return sample;
}

TEST(StoodStill, IsLessThanWheelsCanTell) {
  const Pose2 before{1.0, 2.0, 0.7};
  EXPECT_TRUE(stood_still(before, before * Pose2{3e-4, -2e-4, deg_to_rad(-0.02)}));
  EXPECT_FALSE(stood_still(before, before * Pose2{7e-4, 0.0, 0.0}));
  EXPECT_FALSE(stood_still(before, before * Pose2{0.0, 0.0, deg_to_rad(0.05)}));
}

/// A base that was at `before` says `now` so much later.
bool restarts(const Pose2& before, const Pose2& now, double later_s) {
  OdometryTrack track;
  EXPECT_FALSE(track.restarts_at(sample_at(100.0, before)));
  track.add(sample_at(100.0, before));
  return track.restarts_at(sample_at(100.0 + later_s, now));
}

TEST(OdometryTrack, AWayThatNoRobotDrivesIsARestart) {
  const Pose2 before{5.0, 3.0, 0.5};
  EXPECT_TRUE(restarts(before, before * Pose2{1.5, 0.0, 0.0}, 0.0));
  EXPECT_FALSE(restarts(before, before * Pose2{3.0, 0.0, 0.0}, 0.5));
  EXPECT_TRUE(restarts(before, before * Pose2{6.0, 0.0, 0.0}, 0.5));
  EXPECT_FALSE(restarts(before, before * Pose2{0.0, 40.0, 0.0}, 10.0));
  EXPECT_TRUE(restarts(before, before * Pose2{0.0, 60.0, 0.0}, 100.0)) << "nobody waits so long";
}

TEST(OdometryTrack, ATurnThatNoRobotMakesIsARestart) {
  const Pose2 before{5.0, 3.0, 0.5};
  EXPECT_TRUE(restarts(before, before * Pose2{0.0, 0.0, 1.5}, 0.0));
  EXPECT_TRUE(restarts(before, before * Pose2{0.0, 0.0, -2.5}, 0.1));
  EXPECT_FALSE(restarts(before, before * Pose2{0.0, 0.0, 2.0}, 0.5));
}

TEST(OdometryTrack, StandingAtZeroAfterBeingElsewhereIsARestart) {
  EXPECT_TRUE(restarts({0.07, 0.0, 0.0}, {}, 0.1));
  EXPECT_FALSE(restarts({0.03, 0.0, 0.0}, {}, 0.1)) << "it stood near there";
  EXPECT_FALSE(restarts({0.07, 0.0, 0.0}, {0.005, 0.0, 0.0}, 0.1)) << "it passes by";
  EXPECT_FALSE(restarts({0.07, 0.0, 0.02}, {0.0, 0.0, 0.02}, 0.1)) << "it passes over";
}

TEST(OdometryTrack, APoseBelongsToTheScanWithItsStamp) {
  OdometryTrack track;
  EXPECT_FALSE(track.own_of(Utime::from_seconds(1.0)));
  track.add(sample_at(1.0, {2.0, 0.0, 0.0}));
  EXPECT_THAT(*track.own_of(Utime::from_seconds(1.0)), IsNear(Pose2{2.0, 0.0, 0.0}, 0.0, 0.0));
  EXPECT_FALSE(track.own_of(Utime::from_seconds(1.001)));
}

TEST(OdometryTrack, NothingIsKnownOfWhatWasBeforeARestart) {
  OdometryTrack track;
  track.add(sample_at(1.0, {2.0, 0.0, 0.0}));
  const OdometryTrack::AtScan scan{Utime::from_seconds(1.0), Utime::from_seconds(1.0), 0.2, {}};
  EXPECT_TRUE(track.at(scan, 0.5));
  track.clear();
  EXPECT_FALSE(track.own_of(Utime::from_seconds(1.0)));
  EXPECT_FALSE(track.at(scan, 0.5));
  EXPECT_FALSE(track.restarts_at(sample_at(1.1, {9.0, 0.0, 0.0})));
}

/// A laser of 5 Hz on a robot that moves by `step` from scan to scan, and the odometry that a
/// logger writes with each scan.
class Logger {
 public:
  explicit Logger(const Pose2& step) : step_(step) {}

  /// Scans with a right stamp, `missing` of them lost before the last.
  void regular(int scans, int missing = 0) {
    for (int i = 0; i < scans; ++i) {
      const int steps = i + 1 == scans ? 1 + missing : 1;
      for (int k = 0; k < steps; ++k) pose_ = pose_ * step_;
      now_s_ += 0.2 * steps;
      note(now_s_, now_s_, pose_);
    }
  }
  /// A scan that is stamped a millisecond after the last one, with the odometry of that moment.
  void stalled_and_looked_up() { stalled(1.0 / 200.0); }
  /// The same with the odometry that came along with it: the robot moved on.
  void stalled_and_come_along() { stalled(1.0); }
  /// The same; the robot moved by a part of its steps before. A regular one follows.
  void stalled(double part) {
    note(now_s_ + 0.001, now_s_ + 0.2,
         pose_ * Pose2{part * step_.x_m, part * step_.y_m, part * step_.theta_rad});
    pose_ = pose_ * step_;
    now_s_ += 0.2;
    regular(2);
  }
  bool is_looked_up() const { return track_.is_looked_up(); }

 private:
  void note(double stamp_s, double repaired_s, const Pose2& own) {
    track_.note({Utime::from_seconds(stamp_s), Utime::from_seconds(repaired_s), 0.2, own});
  }

  Pose2 step_;
  OdometryTrack track_;
  Pose2 pose_;
  double now_s_ = 10.0;
};

TEST(OdometryTrack, ThreeStalledScansTellThatOdometryIsLookedUp) {
  for (const Pose2& step : {Pose2{0.1, 0.0, 0.0}, Pose2{0.03, 0.0, 0.0}, Pose2{0.05, 0.0, 0.3},
                            Pose2{0.0, 0.0, -0.2}}) {
    Logger logger(step);
    logger.regular(5);
    for (int i = 0; i < 3; ++i) {
      EXPECT_FALSE(logger.is_looked_up());
      logger.stalled_and_looked_up();
    }
    EXPECT_TRUE(logger.is_looked_up()) << step.x_m << " " << step.theta_rad;
  }
}

TEST(OdometryTrack, ASlowOrStandingRobotTellsNothing) {
  for (const Pose2& step : {Pose2{}, Pose2{0.01, 0.0, 0.0}, Pose2{0.0, 0.0, 0.03}}) {
    Logger logger(step);
    logger.regular(5);
    for (int i = 0; i < 20; ++i) logger.stalled_and_looked_up();
    EXPECT_FALSE(logger.is_looked_up()) << step.x_m << " " << step.theta_rad;
  }
}

// A tenth of the way is still explained by the stamp, with its errors; more is the robot's own.
TEST(OdometryTrack, ARobotThatBrakesTellsNothing) {
  for (const double part : {0.15, 0.3}) {
    Logger logger({0.1, 0.0, 0.0});
    logger.regular(5);
    for (int i = 0; i < 20; ++i) logger.stalled(part);
    EXPECT_FALSE(logger.is_looked_up()) << part;
  }
}

TEST(OdometryTrack, WhatCameAlongIsBelievedLongAndAgainAtOnce) {
  Logger logger({0.1, 0.0, 0.0});
  logger.regular(5);
  for (int i = 0; i < 30; ++i) logger.stalled_and_come_along();
  for (int i = 0; i < 11; ++i) logger.stalled_and_looked_up();
  EXPECT_FALSE(logger.is_looked_up());
  logger.stalled_and_looked_up();
  EXPECT_TRUE(logger.is_looked_up());
  logger.stalled_and_come_along();
  EXPECT_FALSE(logger.is_looked_up());
}

// The way over a lost scan is that of two periods.
TEST(OdometryTrack, ALostScanBeforeTheStallMakesNoDifference) {
  Logger logger({0.1, 0.0, 0.0});
  logger.regular(5);
  for (int i = 0; i < 3; ++i) logger.stalled_and_looked_up();
  ASSERT_TRUE(logger.is_looked_up());
  logger.regular(3, 1);
  logger.stalled_and_come_along();
  EXPECT_FALSE(logger.is_looked_up());
}

}  // namespace
}  // namespace marco
