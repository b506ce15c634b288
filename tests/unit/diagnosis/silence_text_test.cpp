#include "live/diagnosis/silence_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bot_core/planar_lidar_t.hpp"
#include "lcm_tools/tests/support/encoded.hpp"
#include "lcmtypes/channels.hpp"
#include "live/diagnosis/silence_watch.hpp"
#include "marco/lidar_raw_t.hpp"
#include "marco/odometry_t.hpp"
#include "marco/process_status_t.hpp"

namespace marco::diagnosis {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Kind = Lack::Kind;
using ::marco::testing::encoded;

template <class Message>
uint64_t fingerprint_of() {
  return static_cast<uint64_t>(Message::getHash());
}

Lack lack_of(Kind kind) {
  Lack lack;
  lack.kind = kind;
  lack.expected = expect_scans(channels::kLidarPattern, "LIDAR or LIDAR_RAW");
  lack.silent_s = 3.05;
  lack.hz = 10.0;
  lack.channel = "LIDAR";
  return lack;
}

BusSurvey bus_with(const std::string& channel, uint64_t fingerprint) {
  BusSurvey survey;
  survey.channels.push_back({channel, fingerprint, 20, 10.0, std::nullopt});
  return survey;
}

TEST(SilenceText, NothingAtAll) {
  const std::string text = silence_text({lack_of(Kind::never)}, {});
  EXPECT_THAT(text, HasSubstr("waiting for scans: nothing on LIDAR or LIDAR_RAW for 3 s."));
  EXPECT_THAT(text, HasSubstr("marco-rplidar"));
  EXPECT_THAT(text, Not(HasSubstr("On this bus")));
}

TEST(SilenceText, AnotherRobotsChannelIsNamedWithItsType) {
  const std::string text = silence_text({lack_of(Kind::never)},
                                        bus_with("RPLIDAR_LASER", fingerprint_of<lidar_raw_t>()));
  EXPECT_THAT(text, HasSubstr("On this bus: RPLIDAR_LASER 10 Hz (marco.lidar_raw_t)."));
  EXPECT_THAT(text, HasSubstr("RPLIDAR_LASER carries scans under another name: rename it to"));
}

TEST(SilenceText, AForeignTypeIsRecognised) {
  Lack lack = lack_of(Kind::never);
  lack.expected = expect(Awaited::odometry);
  const std::string text = silence_text({lack}, bus_with("MBOT_ODOMETRY", 0x1f317af1246276acULL));
  EXPECT_THAT(text, HasSubstr("MBOT_ODOMETRY carries odometry under another name"));
  EXPECT_THAT(text, HasSubstr("lcm-logger"));
  EXPECT_THAT(text, HasSubstr("no odometry: nothing on ODOMETRY"));
  EXPECT_THAT(text, HasSubstr("from scans alone"));
}

TEST(SilenceText, ANearNameOfAnotherTypeAndATypeNobodyKnows) {
  EXPECT_THAT(silence_text({lack_of(Kind::never)}, bus_with("Lidar", fingerprint_of<odometry_t>())),
              HasSubstr("Lidar has a similar name, but carries marco.odometry_t."));
  EXPECT_THAT(silence_text({lack_of(Kind::never)}, bus_with("CHATTER", 0x1234)),
              HasSubstr("CHATTER 10 Hz (fingerprint 0000000000001234)"));
}

TEST(SilenceText, TheEndOfALog) {
  Lack lack = lack_of(Kind::ended);
  lack.silent_s = 10.2;
  EXPECT_EQ(silence_text({lack}, {}),
            "no more messages on LIDAR (scans): the last came 10 s ago, 10 Hz before.");
}

TEST(SilenceText, TheWrongTypeOnTheRightChannel) {
  Lack lack = lack_of(Kind::wrong_type);
  lack.fingerprint = fingerprint_of<odometry_t>();
  EXPECT_THAT(silence_text({lack}, {}),
              HasSubstr("LIDAR carries marco.odometry_t, not bot_core.planar_lidar_t or"));
  lack.fingerprint = 0xabcdef;
  EXPECT_THAT(silence_text({lack}, {}), HasSubstr("fingerprint 0000000000abcdef"));
  lack.fingerprint = 0;
  EXPECT_THAT(silence_text({lack}, {}), HasSubstr("carries no LCM type"));
}

TEST(SilenceText, DroppedForOneCause) {
  Lack lack = lack_of(Kind::unused);
  lack.cause = "no SENSOR_INFO for LIDAR yet";
  EXPECT_THAT(silence_text({lack}, {}),
              HasSubstr("messages come on LIDAR (scans) at 10 Hz, but all are dropped: no "
                        "SENSOR_INFO for LIDAR yet. SENSOR_INFO gives the pose of the sensor"));
}

TEST(SilenceText, ClocksAndPoses) {
  Lack lack = lack_of(Kind::clock);
  lack.ahead_s = -7300.0;
  EXPECT_THAT(silence_text({lack}, {}),
              HasSubstr("messages on LIDAR (scans) are not used: their stamps are 2.03 h behind"));
  lack = lack_of(Kind::two_poses);
  lack.cause = "0: 0.1 and 0: 0.2";
  EXPECT_THAT(silence_text({lack}, {}),
              HasSubstr("SENSOR_INFO alternates between two poses of LIDAR"));
}

TEST(SilenceText, ADriversTroubleAndTheNetworks) {
  BusSurvey survey;
  survey.troubles["marco-sick"] = "no device: /dev/ttyUSB0: no such file";
  survey.network.push_back({"no route leads to 239.255.76.67", "sudo ip route add"});
  const std::string text = silence_text({lack_of(Kind::never)}, survey);
  EXPECT_THAT(text, HasSubstr("marco-sick: no device: /dev/ttyUSB0"));
  EXPECT_THAT(text, HasSubstr("no route leads to 239.255.76.67: sudo ip route add"));
}

TEST(SilenceText, OldStampsAreSaid) {
  BusSurvey survey = bus_with("POSE", 1);
  survey.channels[0].stamp_age_s = 3 * 86400.0;
  EXPECT_THAT(silence_text({lack_of(Kind::never)}, survey),
              HasSubstr("stamps on POSE are 3 days old"));
  survey.channels[0].stamp_age_s = -300.0;
  EXPECT_THAT(silence_text({lack_of(Kind::never)}, survey), HasSubstr("5 min in the future"));
}

TEST(SilenceText, ManyChannelsAreCut) {
  BusSurvey survey;
  for (int i = 0; i < 30; ++i) {
    survey.channels.push_back({"C" + std::to_string(i), 1, 1, 1.0, std::nullopt});
  }
  EXPECT_THAT(silence_text({lack_of(Kind::never)}, survey), HasSubstr(" and 24 more."));
}

TEST(Situation, ChangesWithWhatIsThereNotWithHowMuch) {
  const std::vector<Lack> lacks{lack_of(Kind::never)};
  BusSurvey survey = bus_with("POSE", 1);
  survey.network.push_back({"x's receive buffer overflowed: 12 datagrams lost", ""});
  const std::string before = situation(lacks, survey);
  survey.channels[0].hz = 11.0;
  survey.network[0].text = "x's receive buffer overflowed: 13 datagrams lost";
  EXPECT_EQ(situation(lacks, survey), before);
  survey.channels[0].name = "POSE2";
  EXPECT_NE(situation(lacks, survey), before);
}

TEST(ShortState, IsOneLineForEachKind) {
  EXPECT_EQ(short_state(lack_of(Kind::never)), "waiting for scans");
  EXPECT_EQ(short_state(lack_of(Kind::wrong_type)), "waiting for scans");
  EXPECT_EQ(short_state(lack_of(Kind::ended)), "no more messages on LIDAR");
  EXPECT_EQ(short_state(lack_of(Kind::two_poses)), "SENSOR_INFO has two poses of LIDAR");
  EXPECT_EQ(short_state(lack_of(Kind::clock)), "the stamps on LIDAR do not fit the scans'");
  EXPECT_THAT(short_state(lack_of(Kind::unused)), HasSubstr("all messages on LIDAR are dropped"));
}

// What liblcm puts on the wire for a small message.
std::vector<uint8_t> datagram(const std::string& channel, const std::vector<uint8_t>& data) {
  std::vector<uint8_t> bytes = {'L', 'C', '0', '2', 0, 0, 0, 1};
  bytes.insert(bytes.end(), channel.begin(), channel.end());
  bytes.push_back(0);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

TEST(SurveyCounter, CountsOthersChannelsTypesStampsAndTroubles) {
  SurveyCounter counter("marco-slam");
  bot_core::planar_lidar_t scan = {};
  scan.utime = 1'700'000'000'000'000;
  for (int i = 0; i < 20; ++i) {
    counter.add(scan.utime + 90'000'000, {1, 5000}, datagram("SCAN", encoded(scan)));
    counter.add(scan.utime, {1, 4000}, datagram("OURS", encoded(scan)));
  }
  counter.add(0, {1, 5000}, datagram("SHORT", {1, 2}));
  counter.add(0, {1, 5000}, std::vector<uint8_t>{1, 2, 3});
  process_status_t status = {};
  status.process = "marco-sick";
  status.state = "no device: gone";
  counter.add(0, {1, 5001}, datagram("PROCESS_STATUS", encoded(status)));
  status.process = "marco-slam";
  status.state = "no device of its own";
  counter.add(0, {1, 4000}, datagram("PROCESS_STATUS", encoded(status)));
  status.process = "marco-base";
  status.state = "ready";
  counter.add(0, {1, 5002}, datagram("PROCESS_STATUS", encoded(status)));
  const BusSurvey survey = counter.result(2.0);
  ASSERT_EQ(survey.channels.size(), 3U);
  EXPECT_EQ(survey.channels[1].name, "SCAN");
  EXPECT_EQ(type_name(survey.channels[1].fingerprint), "bot_core.planar_lidar_t");
  EXPECT_DOUBLE_EQ(survey.channels[1].hz, 10.0);
  EXPECT_DOUBLE_EQ(survey.channels[1].stamp_age_s.value(), 90.0);
  EXPECT_EQ(survey.channels[2].fingerprint, 0U);
  ASSERT_EQ(survey.troubles.size(), 1U);  // its own are none
  EXPECT_EQ(survey.troubles.at("marco-sick"), "no device: gone");
  status.process = "marco-sick";
  counter.add(0, {1, 5001}, datagram("PROCESS_STATUS", encoded(status)));
  EXPECT_TRUE(counter.result(2.0).troubles.empty());
}

}  // namespace
}  // namespace marco::diagnosis
