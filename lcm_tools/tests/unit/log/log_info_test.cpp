#include "lcm_tools/log/log_info.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "lcm_tools/tests/unit/log/tiny_log.hpp"

namespace marco::logs {
namespace {

const ChannelInfo& channel(const LogInfo& info, const std::string& name) {
  for (const ChannelInfo& entry : info.channels) {
    if (entry.name == name) return entry;
  }
  throw std::runtime_error("no channel " + name);
}

std::string no_names(uint64_t /*fingerprint*/) { return ""; }

TEST(LogInfo, CountsRatesAndTypes) {
  const ScratchFolder folder;
  write_poses(folder / "log", 101);
  const LogInfo info = inspect_log(folder / "log", ignore_progress);
  EXPECT_EQ(info.events, 101);
  EXPECT_EQ((info.last - info.first).us, 10'000'000);
  const ChannelInfo& poses = channel(info, "TRUE_POSE");
  EXPECT_EQ(poses.events, 51);
  EXPECT_DOUBLE_EQ(poses.rate_hz, 5.0);
  EXPECT_EQ(poses.usual_interval.us, 200000);
  ASSERT_EQ(poses.types.size(), 1U);
  EXPECT_EQ(poses.types.begin()->first, static_cast<uint64_t>(robot::pose2_t::getHash()));
  EXPECT_TRUE(poses.silences.empty());
  EXPECT_EQ(info.damage.places, 0);
}

TEST(LogInfo, SaysWhereAChannelIsSilentAndWhenTimesStepBack) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    for (int i = 0; i < 100; ++i) {
      // 50 Hz with a hole of 2 s behind event 40; event 70 is 5 ms early.
      const int64_t us = kStartUs + 20000 * i + (i > 40 ? 2'000'000 : 0) - (i == 70 ? 25000 : 0);
      writer.write("IMU", pose_bytes(us, 0.0), Utime::from_us(us));
    }
  }
  const LogInfo info = inspect_log(folder / "log", ignore_progress);
  const ChannelInfo& imu = channel(info, "IMU");
  ASSERT_EQ(imu.silences.size(), 1U);
  EXPECT_EQ(imu.silences[0].from.us, kStartUs + 20000 * 40);
  EXPECT_EQ(imu.silences[0].length.us, 2'020'000);
  EXPECT_EQ(info.event_time_steps_back, 1);
  EXPECT_EQ(imu.utime_steps_back, 1);
}

TEST(LogInfo, ClocksThatDisagreeAndOneThatDrifts) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    for (int i = 0; i < 3000; ++i) {
      const int64_t us = kStartUs + 10000 * i;
      const Utime time = Utime::from_us(us);
      writer.write("GOOD", pose_bytes(us - 2000, 0.0), time);
      writer.write("YESTERDAY", pose_bytes(us - 86'400'000'000, 0.0), time);
      writer.write("SLOW", pose_bytes(us - us % kStartUs / 1000, 0.0), time);  // 1000 ppm
      writer.write("COUNTER", pose_bytes(i, 0.0), time);
      const std::string text = "lcm self test";
      if (i == 0)
        writer.write("LCM_SELF_TEST", {reinterpret_cast<const uint8_t*>(text.data()), 13}, time);
    }
  }
  const LogInfo info = inspect_log(folder / "log", ignore_progress);
  ASSERT_EQ(info.clock_groups.size(), 2U);
  EXPECT_THAT(info.clock_groups[0].channels, ::testing::UnorderedElementsAre("GOOD", "SLOW"));
  EXPECT_THAT(info.clock_groups[1].channels, ::testing::ElementsAre("YESTERDAY"));
  EXPECT_EQ(info.clock_groups[1].offset.us, 86'400'000'000);
  ASSERT_TRUE(channel(info, "SLOW").clock);
  EXPECT_TRUE(drifts(*channel(info, "SLOW").clock));
  // The median of a quarter's picks is off by at most one pick in 375: 0.3 %.
  EXPECT_NEAR(channel(info, "SLOW").clock->drift_us_per_s, 1000.0, 20.0);
  EXPECT_FALSE(drifts(*channel(info, "GOOD").clock));
  EXPECT_FALSE(channel(info, "COUNTER").clock);
  EXPECT_EQ(channel(info, "LCM_SELF_TEST").types.begin()->first, 0U);
}

TEST(LogInfo, TextAndJsonTellTheSame) {
  const ScratchFolder folder;
  write_poses(folder / "log", 20);
  std::string bytes = read_text(folder / "log");
  bytes.insert(0, "rubbish");
  write_text(folder / "log", bytes);
  const LogInfo info = inspect_log(folder / "log", ignore_progress);
  const std::string text = to_text(info, "log", no_names);
  EXPECT_NE(text.find("7 bytes belong to no whole event: 7 at byte 0"), std::string::npos) << text;
  EXPECT_NE(text.find("TRUE_POSE"), std::string::npos);
  const auto json = nlohmann::json::parse(to_json(info, "log", no_names));
  EXPECT_EQ(json.at("events"), 20);
  EXPECT_EQ(json.at("channels").size(), 2U);
  EXPECT_EQ(json.at("damage").at("stretches").at(0).at("bytes"), 7);
  EXPECT_EQ(json.at("clocks_disagree"), false);
}

TEST(LogInfo, AnyBytesAreInspectedWithoutACrash) {
  const ScratchFolder folder;
  write_poses(folder / "good", 40);
  const std::string good = read_text(folder / "good");
  std::mt19937 random(21);
  for (int round = 0; round < 100; ++round) {
    std::string bytes = good;
    for (int flips = 0; flips < 30; ++flips) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    write_text(folder / "bad", bytes);
    const LogInfo info = inspect_log(folder / "bad", ignore_progress);
    EXPECT_FALSE(to_text(info, "bad", no_names).empty());
    EXPECT_FALSE(to_json(info, "bad", no_names).empty());
  }
}

TEST(Decimated, KeepsAnEvenPick) {
  Decimated<int> picked;
  for (int i = 0; i < 100000; ++i) picked.add(i);
  const auto& values = picked.values();
  ASSERT_GT(values.size(), 500U);
  ASSERT_LE(values.size(), 1024U);
  const int step = values[1] - values[0];
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], static_cast<int>(i) * step);
  EXPECT_EQ(quantile(values, 0.5), values[values.size() / 2]);
}

}  // namespace
}  // namespace marco::logs
