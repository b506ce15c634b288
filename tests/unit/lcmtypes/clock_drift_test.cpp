#include "recordings/clock_drift.hpp"

#include <gtest/gtest.h>

#include <random>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/recording.hpp"
#include "tests/support/recorded.hpp"

namespace marco {
namespace {

using ::marco::testing::read_all;
using ::marco::testing::TemporaryFolder;

constexpr int64_t kDriftStartUs = 1'700'000'000'000'000;

// What a process adds to a message's way: 2 ms and an exponential tail, at times half a second.
class Queue {
 public:
  int64_t delay_us() { return 2000 + static_cast<int64_t>(1e4 * tail_(random_)) + stall_us(); }

 private:
  int64_t stall_us() { return uniform_(random_) < 0.05 ? 500'000 : 0; }

  std::mt19937 random_{3};
  std::exponential_distribution<double> tail_{1.0};
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

ClockDrift drifting(double rate, int seconds) {
  ClockDrift drift;
  Queue queue;
  for (int64_t us = 0; us < seconds * 1'000'000LL; us += 200'000) {
    const auto stamp_us = static_cast<int64_t>((1.0 + rate) * static_cast<double>(us));
    drift.add(stamp_us, kDriftStartUs + us + queue.delay_us());
  }
  return drift;
}

TEST(ClockDrift, IsFoundBelowDelaysOfManyMilliseconds) {
  for (const double rate : {0.004, -0.002, 0.0}) {
    const auto line = drifting(rate, 60).line();
    ASSERT_TRUE(line);
    // The least of five delays a second still differ by milliseconds: 1e-4 of a minute.
    EXPECT_NEAR(line->seconds_per_s, -rate / (1.0 + rate), 1e-4);
    EXPECT_LT(line->doubt_s, 0.02);
  }
}

TEST(ClockDrift, OfAFewSecondsIsNotKnown) { EXPECT_FALSE(drifting(0.004, 8).line()); }

TEST(ClockDrift, AStampThatJumpsDoesNotBendTheLine) {
  ClockDrift drift = drifting(0.004, 60);
  drift.add(-5'000'000, kDriftStartUs);
  drift.add(30'000'000'000'000, kDriftStartUs);
  drift.add(61'000'000, kDriftStartUs + 3'600'000'000);
  EXPECT_NEAR(drift.line()->seconds_per_s, -0.004 / 1.004, 1e-4);
}

// At the end of a minute, of odometry that was measured with the last scan; the laser's clock is
// fast by `rate`.
double behind_laser_s(double rate) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "log";
  Queue queue;
  {
    files::EventLogWriter log(path.string());
    const auto add = [&](const Sample& sample, int64_t us) {
      const EncodedMessage message = encode_sample(sample);
      log.write(message.channel, message.bytes, Utime::from_us(us + queue.delay_us()));
    };
    for (int64_t us = 0; us < 60'000'000; us += 100'000) {
      OdometrySample odometry;
      odometry.utime = Utime::from_us(kDriftStartUs + us);
      add(odometry, kDriftStartUs + us);
      LaserScan scan;
      const double laser_us = (1.0 + rate) * static_cast<double>(us);
      scan.utime = Utime::from_us(kDriftStartUs + static_cast<int64_t>(laser_us));
      scan.ranges_m = {1.0F, 2.0F, 3.0F};
      add(scan, kDriftStartUs + us + 20'000);
    }
  }
  const auto recorded = read_all(*open_recording(path));
  return (recorded.scans.back().utime - recorded.odometry.back().utime).seconds();
}

TEST(ClockDrift, OdometryIsMovedToADriftingLasersClock) {
  EXPECT_NEAR(behind_laser_s(0.004), 0.0, 0.01);  // 0.24 s as stamped
  EXPECT_EQ(behind_laser_s(0.0), 0.0);
}

}  // namespace
}  // namespace marco
