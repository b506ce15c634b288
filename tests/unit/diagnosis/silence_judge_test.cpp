#include "live/diagnosis/silence_judge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lcm_tools/tests/support/encoded.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "live/diagnosis/silence_watch.hpp"
#include "marco/sensor_info_t.hpp"

namespace marco::diagnosis {
namespace {

using Kind = Lack::Kind;
using ::marco::testing::encoded;

// A program that waits for scans and odometry, and a bus that it hears.
class Silence : public ::testing::Test {
 protected:
  Silence()
      : judge_({expect_scans(channels::kLidarPattern, "LIDAR or LIDAR_RAW"),
                expect(Awaited::odometry)},
               &drops_) {
    judge_.advance(now_s_);
  }
  // Steps of 0.1 s; at each, a scan and odometry if they are to come.
  void run(double seconds) {
    for (long left = std::lround(seconds * 10.0); left > 0; --left) {
      now_s_ += 0.1;
      judge_.advance(now_s_);
      if (scans) hear("LIDAR", scan_at(now_s_), drop_scans);
      if (odometry) hear("ODOMETRY", odometry_at(now_s_ + odometry_ahead_s), "");
    }
  }
  void hear(const std::string& channel,
            const std::vector<uint8_t>& bytes,
            const std::string& drop_cause) {
    judge_.heard({channel, bytes, {}});
    drops_.count_received();
    if (!drop_cause.empty()) drops_.count(drop_cause);
  }
  static int64_t us(double seconds) { return 1'700'000'000'000'000 + std::llround(seconds * 1e6); }
  static std::vector<uint8_t> scan_at(double seconds) {
    bot_core::planar_lidar_t scan = {};
    scan.utime = us(seconds);
    return encoded(scan);
  }
  static std::vector<uint8_t> odometry_at(double seconds) {
    odometry_t message = {};
    message.utime = us(seconds);
    return encoded(message);
  }
  std::vector<Lack> lacks() const { return judge_.lacks(); }

  process::DropCounter drops_;
  SilenceJudge judge_;
  double now_s_ = 100.0;
  bool scans = false, odometry = false;
  std::string drop_scans;
  double odometry_ahead_s = 0.0;
};

TEST_F(Silence, IsNoneWhileAllComes) {
  scans = odometry = true;
  for (int i = 0; i < 40; ++i) {
    run(0.5);
    ASSERT_TRUE(lacks().empty()) << i;
  }
  EXPECT_THAT(judge_.what_comes(),
              ::testing::MatchesRegex("LIDAR 10[.0-9]* Hz, ODOMETRY 10[.0-9]* Hz"));
}

TEST_F(Silence, FromTheStartIsToldAfterThreeSeconds) {
  run(2.9);
  EXPECT_TRUE(lacks().empty());
  EXPECT_EQ(judge_.lacks(1.0).size(), 1U);
  run(0.2);
  ASSERT_EQ(lacks().size(), 1U);  // odometry is not missed before scans come
  EXPECT_EQ(lacks()[0].kind, Kind::never);
  EXPECT_EQ(lacks()[0].expected.what, "scans");
  scans = odometry = true;
  run(0.3);
  EXPECT_TRUE(lacks().empty());
}

TEST_F(Silence, AfterMessagesIsToldAfterTenSecondsWithTheirRate) {
  scans = odometry = true;
  run(5.0);
  scans = odometry = false;
  run(9.8);
  EXPECT_TRUE(lacks().empty());
  run(0.4);
  ASSERT_EQ(lacks().size(), 1U);
  EXPECT_EQ(lacks()[0].kind, Kind::ended);
  EXPECT_NEAR(lacks()[0].hz, 10.0, 0.3);
}

TEST_F(Silence, OfASlowChannelIsToldLater) {
  odometry = true;
  for (int i = 0; i < 4; ++i) {
    hear("LIDAR", scan_at(now_s_), "");
    run(4.0);
  }
  run(10.0);  // 14 s of silence, messages came each 4 s
  EXPECT_TRUE(lacks().empty());
  run(7.0);
  ASSERT_FALSE(lacks().empty());
  EXPECT_EQ(lacks()[0].kind, Kind::ended);
}

TEST_F(Silence, IsNotTheTimeInWhichTheProgramWasBusy) {
  scans = odometry = true;
  run(2.0);
  now_s_ += 60.0;  // one long step
  judge_.advance(now_s_);
  EXPECT_TRUE(lacks().empty());
}

TEST_F(Silence, OfOdometryAloneIsToldOnceScansHaveComeForLong) {
  scans = true;
  run(9.5);
  EXPECT_TRUE(lacks().empty());
  run(1.0);
  ASSERT_EQ(lacks().size(), 1U);
  EXPECT_EQ(lacks()[0].expected.what, "odometry");
}

TEST_F(Silence, AnotherTypeOnTheChannelIsNamed) {
  odometry = true;
  for (int i = 0; i < 40; ++i) {
    hear("LIDAR", odometry_at(now_s_), "undecodable");
    run(0.1);
  }
  ASSERT_EQ(lacks().size(), 1U);
  EXPECT_EQ(lacks()[0].kind, Kind::wrong_type);
  EXPECT_EQ(type_name(lacks()[0].fingerprint), "marco.odometry_t");
  EXPECT_NEAR(lacks()[0].hz, 10.0, 0.5);
}

TEST_F(Silence, MessagesThatAreAllDroppedAreTold) {
  scans = odometry = true;
  drop_scans = "no SENSOR_INFO for LIDAR yet";
  run(2.5);
  EXPECT_TRUE(lacks().empty());
  run(1.0);
  ASSERT_EQ(lacks().size(), 1U);
  EXPECT_EQ(lacks()[0].kind, Kind::unused);
  EXPECT_EQ(lacks()[0].cause, drop_scans);
  drop_scans = "";
  run(0.3);
  EXPECT_TRUE(lacks().empty());
  for (const char* wanted : {"paused", "tilted"}) {
    drop_scans = wanted;
    run(10.0);
    EXPECT_TRUE(lacks().empty());
  }
}

TEST_F(Silence, AScanThatIsDroppedWhenItsOdometryComesIsNotOdometrysFault) {
  for (int i = 0; i < 100; ++i) {
    hear("LIDAR", scan_at(now_s_), "");
    hear("ODOMETRY", odometry_at(now_s_), "undecodable");
    run(0.1);
    ASSERT_TRUE(lacks().empty());
  }
}

TEST_F(Silence, OneDroppedMessageInTwoIsNothing) {
  scans = odometry = true;
  for (int i = 0; i < 100; ++i) {
    drop_scans = i % 2 == 0 ? "undecodable" : "";
    run(0.1);
    ASSERT_TRUE(lacks().empty());
  }
}

TEST_F(Silence, StampsOfAnotherClockAreTold) {
  scans = odometry = true;
  odometry_ahead_s = -1.0;
  run(10.0);
  EXPECT_TRUE(lacks().empty());
  odometry_ahead_s = -40.0;
  run(2.5);
  EXPECT_TRUE(lacks().empty());
  run(1.0);
  ASSERT_EQ(lacks().size(), 1U);
  EXPECT_EQ(lacks()[0].kind, Kind::clock);
  EXPECT_NEAR(lacks()[0].ahead_s, -40.0, 0.2);
}

TEST_F(Silence, TwoPosesOfOneSensorInTurnAreToldOneChangeIsNot) {
  scans = odometry = true;
  sensor_info_t info = {};
  info.channel = "LIDAR";
  const auto hear_at = [&](double x_m) {
    info.parent_from_sensor_m[0] = x_m;
    hear("SENSOR_INFO", encoded(info), "");
    run(0.1);
  };
  for (const double x_m : {0.1, 0.1, 0.2, 0.2, 0.2}) hear_at(x_m);
  EXPECT_TRUE(lacks().empty());
  for (const double x_m : {0.1, 0.2, 0.1}) hear_at(x_m);
  ASSERT_EQ(lacks().size(), 1U);
  EXPECT_EQ(lacks()[0].kind, Kind::two_poses);
  EXPECT_EQ(lacks()[0].channel, "LIDAR");
}

TEST_F(Silence, ALaserOnThePanTiltIsSeenInItsSensorInfo) {
  SilenceJudge judge({expect(Awaited::laser_on_pantilt)}, nullptr);
  sensor_info_t info = {};
  info.channel = "LIDAR";
  for (int i = 0; i < 40; ++i) {
    judge.advance(0.1 * i);
    const auto bytes = encoded(info);
    judge.heard({"SENSOR_INFO", bytes, {}});
  }
  ASSERT_EQ(judge.lacks().size(), 1U);
  EXPECT_EQ(judge.lacks()[0].kind, Kind::never);
  info.mount = sensor_info_t::MOUNT_PANTILT;
  const auto bytes = encoded(info);
  judge.heard({"SENSOR_INFO", bytes, {}});
  EXPECT_TRUE(judge.lacks().empty());
}

}  // namespace
}  // namespace marco::diagnosis
