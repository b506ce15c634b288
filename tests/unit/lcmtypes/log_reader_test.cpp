// Our own and other people's LCM logs.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/lidar_raw_t.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "recordings/recording.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/recorded.hpp"

namespace marco {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::marco::testing::TemporaryFolder;
using ::testing::Contains;
using ::testing::HasSubstr;

class LcmLog : public ::testing::Test {
 protected:
  LcmLog() : path_(folder_.path() / "log"), log_(path_.string()) {}

  void add(const Sample& sample, int64_t event_us) {
    const EncodedMessage message = encode_sample(sample);
    log_.write(message.channel, message.bytes, Utime::from_us(event_us));
  }
  template <class Message>
  void add_message(const std::string& channel, const Message& message, int64_t event_us) {
    log_.write(channel, encode_message(message), Utime::from_us(event_us));
  }
  static LaserScan scan(int64_t us) {
    LaserScan scan;
    scan.utime = Utime::from_us(us);
    scan.channel = "LIDAR";
    scan.ranges_m = {1.0F, 2.0F, 3.0F};
    scan.first_bearing_rad = -0.5;
    scan.bearing_step_rad = 0.5;
    return scan;
  }
  static SensorInfo info(int64_t us) {
    SensorInfo info;
    info.utime = Utime::from_us(us);
    info.channel = "LIDAR";
    info.range_max_m = 30.0;
    return info;
  }
  Recorded read() {
    log_.flush();
    return read_all(*open_recording(path_));
  }

  TemporaryFolder folder_;
  std::filesystem::path path_;
  files::EventLogWriter log_;
};

TEST_F(LcmLog, OurOwnChannelsComeBackAsTheyWere) {
  add(info(1000), 1000);
  add(scan(2000), 2100);
  add(TruePose{Utime::from_us(2000), {1.5, -2.5, 0.75}}, 2100);
  OdometrySample odometry;
  odometry.utime = Utime::from_us(2500);
  odometry.odom_from_robot = {4, 5, -1};
  add(odometry, 2600);
  const Recorded recorded = read();
  ASSERT_EQ(recorded.scans.size(), 1U);
  EXPECT_EQ(recorded.scans[0].ranges_m, scan(0).ranges_m);
  ASSERT_EQ(recorded.truth.size(), 1U);
  EXPECT_THAT(recorded.truth[0].world_from_robot, IsNear(Pose2{1.5, -2.5, 0.75}, 1e-12, 1e-12));
  ASSERT_EQ(recorded.odometry.size(), 1U);
  EXPECT_THAT(recorded.odometry[0].odom_from_robot, IsNear(Pose2{4, 5, -1}, 1e-12, 1e-12));
}

TEST_F(LcmLog, ALaserThatSaysNothingOfItsPlaceIsTakenToBeAtTheCentreAndThatIsTold) {
  add(scan(2000), 2000);
  const Recorded recorded = read();
  ASSERT_EQ(recorded.infos.size(), 1U);
  ASSERT_EQ(recorded.scans.size(), 1U);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("turning centre")));
}

TEST_F(LcmLog, ChannelsWhoseClocksDisagreeMeetByEventTime) {
  constexpr int64_t kYearUs = 31'536'000'000'000;
  for (int i = 0; i < 20; ++i) {
    add(scan(1'000'000 + 100'000 * i), kYearUs + 1'000'000 + 100'000 * i);
    mbot_pose2d_t pose{};
    pose.utime = kYearUs + 1'000'000 + 100'000 * i;
    pose.x = static_cast<float>(i);
    add_message("TRUE_POSE", pose, kYearUs + 1'000'000 + 100'000 * i);
  }
  const Recorded recorded = read();
  ASSERT_EQ(recorded.truth.size(), 20U);
  EXPECT_EQ(recorded.truth[7].utime, recorded.scans.at(7).utime);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("differ by")));
  EXPECT_TRUE(recorded.truth[7].is_by_arrival);
}

// A driver that forgets the stamp, and one that stamps in milliseconds.
class WrongStamps : public LcmLog, public ::testing::WithParamInterface<double> {};
INSTANTIATE_TEST_SUITE_P(StampsByEventTimes, WrongStamps, ::testing::Values(0.0, 1e-3, 1e3));

TEST_P(WrongStamps, GiveWayToTheEventsTimes) {
  for (int i = 0; i < 40; ++i) {
    const int64_t event_us = 1'000'000 + 100'000 * i;
    add(scan(static_cast<int64_t>(GetParam() * static_cast<double>(event_us))), event_us);
  }
  const Recorded recorded = read();
  ASSERT_EQ(recorded.scans.size(), 40U);
  EXPECT_EQ(recorded.scans[7].utime.us, 1'700'000);
  EXPECT_EQ(recorded.scans[39].utime.us, 4'900'000);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("not microseconds")));
}

// A replay at any speed that a logger has written down: its stamps are right.
TEST_F(LcmLog, EventTimesOfAFastReplayAreNotBelieved) {
  for (int i = 0; i < 400; ++i) add(scan(1'000'000 + 100'000 * i), 1'000'000 + 10'000 * i);
  const Recorded recorded = read();
  ASSERT_EQ(recorded.scans.size(), 400U);
  EXPECT_EQ(recorded.scans[399].utime.us, 40'900'000);
}

// What a reader brought into one clock is written without the clocks it came from.
TEST_F(LcmLog, TruthOfAnotherClockStaysThatWhenItIsWrittenAgain) {
  for (int i = 0; i < 20; ++i) {
    const int64_t us = 1'000'000 + 100'000 * i;
    add(scan(us), us);
    add(TruePose{Utime::from_us(us), {0.1 * i, 0.0, 0.0}, true}, us);
  }
  const Recorded recorded = read();
  ASSERT_EQ(recorded.truth.size(), 20U);
  EXPECT_TRUE(recorded.truth[7].is_by_arrival);
  EXPECT_EQ(recorded.truth[7].utime, recorded.scans.at(7).utime);
}

// MBot's scans are stamped at their first beam by one driver, at their end by the next. Both are
// sent when they are complete.
class ClocksOfMBot : public LcmLog {
 protected:
  static constexpr int64_t kTurnUs = 90'000;
  static constexpr int kBeams = 10;

  // @returns how far the truth of the scan's first beam is from that beam [us].
  double apart_us(int64_t stamp_after_us) {
    constexpr int64_t kYearUs = 31'536'000'000'000;
    for (int i = 0; i < 20; ++i) {
      const int64_t begin_us = 1'000'000 + 100'000 * i;
      lidar_raw_t message{};
      message.utime = begin_us + stamp_after_us;
      message.num_ranges = kBeams;
      for (int beam = 0; beam < kBeams; ++beam) {
        message.ranges.push_back(2.0F);
        message.thetas.push_back(static_cast<float>(2.0 * std::numbers::pi * beam / kBeams));
        message.times.push_back(begin_us + kTurnUs * beam / kBeams);
        message.intensities.push_back(0.0F);
      }
      mbot_pose2d_t pose{};
      pose.utime = kYearUs + begin_us;
      add_message("TRUE_POSE", pose, kYearUs + begin_us);
      add_message("LIDAR", message, kYearUs + begin_us + kTurnUs);
    }
    const Recorded recorded = read();
    if (recorded.truth.size() != 20U) return NAN;
    return static_cast<double>((recorded.truth[7].utime - recorded.scans.at(7).utime).us);
  }
};

TEST_F(ClocksOfMBot, MeetWhereAScanIsStampedAtItsFirstBeam) {
  EXPECT_NEAR(apart_us(0), 0.0, kTurnUs / kBeams);
}

TEST_F(ClocksOfMBot, MeetWhereAScanIsStampedAtItsEnd) {
  EXPECT_NEAR(apart_us(kTurnUs), 0.0, kTurnUs / kBeams);
}

// Of a log whose logger had no clock for a while, or none at all: channels of different rates,
// whose stamps agree. What their event times say is nonsense.
TEST_F(LcmLog, EventTimesThatSayNothingBendNothing) {
  constexpr int64_t kStartUs = 1'700'000'000'000'000;
  const auto stopped = [](int i, int64_t us) { return i < 300 ? int64_t{0} : us; };
  const auto stopped_late = [](int i, int64_t us) { return i < 100 ? us : kStartUs + 5'000'000; };
  const auto leaping = [](int i, int64_t) {
    return i % 2 == 0 ? std::numeric_limits<int64_t>::min() : std::numeric_limits<int64_t>::max();
  };
  for (const std::function<int64_t(int, int64_t)>& event_us :
       {std::function<int64_t(int, int64_t)>(stopped), {stopped_late}, {leaping}}) {
    const auto path = folder_.path() / "other";
    {
      files::EventLogWriter log(path.string());
      for (int i = 0; i < 400; ++i) {
        const int64_t us = kStartUs + 50'000 * i;
        OdometrySample odometry;
        odometry.utime = Utime::from_us(us);
        for (const Sample& sample : {Sample(odometry), Sample(scan(us))}) {
          if ((i < 100 || i % 4 != 0) && std::holds_alternative<LaserScan>(sample)) continue;
          const EncodedMessage message = encode_sample(sample);
          log.write(message.channel, message.bytes, Utime::from_us(event_us(i, us)));
        }
      }
      log.flush();
    }
    const Recorded recorded = read_all(*open_recording(path));
    ASSERT_EQ(recorded.odometry.size(), 400U);
    ASSERT_EQ(recorded.scans.size(), 75U);
    for (int i = 0; i < 400; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_EQ(recorded.odometry[at].utime.us, kStartUs + 50'000 * i);
      if (i < 100 || i % 4 != 0) continue;
      EXPECT_EQ(recorded.scans[at / 4 - 25].utime, recorded.odometry[at].utime);
    }
    EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("stand still or jump")));
  }
}

TEST_F(LcmLog, AStampThatCannotBelongToItsEventIsDropped) {
  for (int i = 0; i < 9; ++i) add(scan(1'000'000 + 100'000 * i), 1'000'000 + 100'000 * i);
  add(scan(int64_t{1} << 61), 2'000'000);
  const Recorded recorded = read();
  EXPECT_EQ(recorded.scans.size(), 9U);
  EXPECT_EQ(recorded.report.dropped.at("stamp an hour or more from its event's time"), 1);
}

TEST_F(LcmLog, UntypedAndUndecodableEventsAreCountedAndPassedBy) {
  add(info(1000), 1000);
  add(scan(2000), 2000);
  log_.write("LCM_SELF_TEST", std::vector<uint8_t>{'l', 'c', 'm', ' ', 's'}, Utime::from_us(2500));
  EncodedMessage cut = encode_sample(scan(3000));
  cut.bytes.resize(cut.bytes.size() - 6);
  log_.write("LIDAR", cut.bytes, Utime::from_us(3000));
  const Recorded recorded = read();
  EXPECT_EQ(recorded.scans.size(), 1U);
  EXPECT_EQ(recorded.report.dropped.at("undecodable"), 1);
  EXPECT_THAT(recorded.report.notes, Contains(HasSubstr("LCM_SELF_TEST")));
}

TEST_F(LcmLog, ALogWithoutALaserIsRefusedWithItsChannelsAndTheRemedy) {
  log_.write("SOMETHING", std::vector<uint8_t>(20, 1), Utime::from_us(1));
  log_.flush();
  const std::string says = complaint([&] { open_recording(path_); });
  EXPECT_THAT(says, HasSubstr("SOMETHING"));
  EXPECT_THAT(says, HasSubstr("--foreign"));
}

TEST(ForeignTable, TheShippedFileSaysWhatIsCompiledIn) {
  const auto shipped = process::load_options<ForeignTable>("config/foreign.toml");
  EXPECT_EQ(process::print_options(shipped), process::print_options(ForeignTable{}));
}

}  // namespace
}  // namespace marco
