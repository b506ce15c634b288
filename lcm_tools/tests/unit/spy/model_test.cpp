#include "lcm_tools/spy/model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bot_core/planar_lidar_t.hpp"
#include "lcm_tools/spy/report.hpp"
#include "lcm_tools/tests/unit/spy/spy_fixture.hpp"
#include "robot/grid_map_t.hpp"
#include "robot/pose2_t.hpp"

namespace marco::spy {
namespace {

const Address kSlam{0x7F000001, 40000};
const Address kDriver{0x7F000001, 40001};

std::vector<uint8_t> pose(double x_m) {
  robot::pose2_t message = {};
  message.x_m = x_m;
  return encoded(message);
}

TEST(Model, KindsOfMessagesAreCountedApart) {
  Model model(test_decoder());
  auto damaged = pose(1);
  damaged.pop_back();
  model.add_message(1, "POSE", pose(1));
  model.add_message(2, "POSE", damaged);
  model.add_message(3, "POSE", std::vector<uint8_t>(20, 9));
  model.add_message(4, "LCM_SELF_TEST", {});
  const Channel& channel = model.channels()[static_cast<std::size_t>(model.find("POSE"))];
  EXPECT_EQ(channel.rate.count(), 3);
  EXPECT_EQ(channel.damaged, 1);
  EXPECT_EQ(channel.unknown, 1);
  EXPECT_EQ(channel.type_changes, 1);
  EXPECT_EQ(model.channels()[static_cast<std::size_t>(model.find("LCM_SELF_TEST"))].untyped, 1);
  EXPECT_EQ(model.messages(), 4);
}

TEST(Model, AGapOfASenderWithOneChannelIsThatChannelsExactly) {
  Model model(test_decoder());
  for (const uint32_t i : {0U, 1U, 5U})
    model.add_datagram(i, kSlam, short_datagram(i, "POSE", pose(0)));
  EXPECT_EQ(model.lost(), 3);
  EXPECT_EQ(model.loss(0).count, 3);
  EXPECT_FALSE(model.loss(0).estimated);
}

TEST(Model, LossesOfSeveralChannelsAreSharedOutAndAddUp) {
  Model model(test_decoder());
  uint32_t number = 0;
  for (int i = 0; i < 300; ++i) {
    const char* channel = i % 3 == 0 ? "A" : i % 3 == 1 ? "B" : "C";
    model.add_datagram(i, kSlam, short_datagram(number, channel, pose(0)));
    number += i == 150 ? 101 : 1;
  }
  int64_t sum = 0;
  for (int channel = 0; channel < 3; ++channel) {
    const Loss loss = model.loss(channel);
    EXPECT_TRUE(loss.estimated);
    EXPECT_NEAR(static_cast<double>(loss.count), 100.0 / 3, 1.0);  // rounding
    sum += loss.count;
  }
  EXPECT_EQ(sum, 100);
  EXPECT_EQ(model.lost(), 100);
}

TEST(Model, EachSenderHasItsOwnNumbers) {
  Model model(test_decoder());
  for (uint32_t i = 0; i < 10; ++i) {
    model.add_datagram(i, kSlam, short_datagram(i, "POSE", pose(0)));
    model.add_datagram(i, kDriver, short_datagram(1000 + 2 * i, "LIDAR", pose(0)));
  }
  EXPECT_EQ(model.senders()[0].lost(), 0);
  EXPECT_EQ(model.senders()[1].lost(), 9);
  EXPECT_EQ(model.loss(model.find("POSE")).count, 0);
  EXPECT_EQ(model.loss(model.find("LIDAR")).count, 9);
}

TEST(Model, AMessageThatLostFragmentsIsItsChannelsLoss) {
  Model model(test_decoder());
  bot_core::planar_lidar_t lidar = {};
  lidar.nranges = 1000;
  lidar.ranges.resize(1000, 1.0F);
  for (uint32_t i = 0; i < 3; ++i) {
    const auto fragments = fragment_datagrams(i, "LIDAR", encoded(lidar), 1000);
    for (std::size_t k = 0; k < fragments.size(); ++k) {
      if (i != 1 || k != 2) model.add_datagram(1000 * i, kDriver, fragments[k]);
    }
    model.add_datagram(1000 * i, kDriver, short_datagram(100 + i, "POSE", pose(0)));
    model.senders();
  }
  EXPECT_EQ(model.channels()[static_cast<std::size_t>(model.find("LIDAR"))].rate.count(), 2);
  model.settle(100000);
  EXPECT_EQ(model.senders()[0].incomplete, 0);  // its fragments may still come
  model.settle(1000000);
  EXPECT_EQ(model.senders()[0].incomplete, 1);
  EXPECT_EQ(model.senders()[0].uses[0].incomplete, 1);
}

TEST(Model, ADoubledFragmentedMessageCountsOnce) {
  Model model(test_decoder());
  const auto fragments = fragment_datagrams(4, "LIDAR", std::vector<uint8_t>(3000), 1000);
  for (int copy = 0; copy < 2; ++copy) {
    for (const auto& fragment : fragments) model.add_datagram(0, kDriver, fragment);
  }
  model.settle(10000000);
  EXPECT_EQ(model.messages(), 1);
  EXPECT_EQ(model.lost(), 0);
}

TEST(Model, HistoryIsSpacedAndBounded) {
  Model model(test_decoder());
  for (int i = 0; i < 100000; ++i) model.add_message(1000 * i, "POSE", pose(i));
  const Channel& channel = model.channels()[0];
  EXPECT_EQ(channel.history.size(), 1200U);
  EXPECT_EQ(channel.history[1].time_us - channel.history[0].time_us, 25000);
  EXPECT_EQ(channel.history.back().time_us / 25000, 99999000 / 25000);
  EXPECT_EQ(channel.history_bytes, 1200 * pose(0).size());
  for (int i = 0; i < 100; ++i)
    model.add_message(200000000 + 100000 * i, "BIG", std::vector<uint8_t>(1 << 17));
  EXPECT_LE(model.channels()[1].history_bytes, std::size_t{2} << 20U);
}

TEST(Model, KeepsNoHistoryWhenNobodyDrawsIt) {
  Model model(test_decoder(), Keep::newest);
  for (int i = 0; i < 4000; ++i) model.add_message(100000 * i, "POSE", pose(i));
  const Channel& channel = model.channels()[0];
  EXPECT_TRUE(channel.history.empty());
  EXPECT_EQ(channel.history_bytes, 0U);
  EXPECT_EQ(channel.last.bytes, pose(3999));
  EXPECT_EQ(model.messages(), 4000);
}

TEST(Model, ChannelsAndSendersAreBounded) {
  Model model(test_decoder());
  for (uint32_t i = 0; i < 4100; ++i) {
    model.add_datagram(i, {1, static_cast<uint16_t>(i)},
                       short_datagram(0, "CHANNEL_" + std::to_string(i), pose(0)));
  }
  EXPECT_EQ(model.channels().size(), 4000U);
  EXPECT_EQ(model.senders().size(), 4000U);
  EXPECT_EQ(model.ignored(), 100);
  // A sender that is known, and a channel that is not.
  model.add_datagram(5000, {1, 7}, short_datagram(1, "ONE_MORE", pose(0)));
  model.add_message(5000, "AND_ANOTHER", pose(0));
  EXPECT_EQ(model.channels().size(), 4000U);
  EXPECT_EQ(model.ignored(), 102);
  EXPECT_EQ(model.messages(), 4000);
}

TEST(Model, AllTilesOfAMapAreKept) {
  Model model(test_decoder());
  robot::grid_map_t tile = {};
  tile.size = 100000;
  tile.occupancy.resize(100000);
  for (int i = 0; i < 300; ++i) model.add_message(i, "GRID_MAP", encoded(tile));
  EXPECT_EQ(model.channels()[0].history.size(), (std::size_t{24} << 20U) / encoded(tile).size());
}

TEST(Model, ClearForgetsCountsButNotTheNumbers) {
  Model model(test_decoder());
  model.add_datagram(0, kSlam, short_datagram(0, "POSE", pose(0)));
  model.add_datagram(0, kSlam, short_datagram(5, "POSE", pose(0)));
  model.clear();
  EXPECT_EQ(model.lost(), 0);
  EXPECT_TRUE(model.channels().empty());
  model.add_datagram(0, kSlam, short_datagram(7, "POSE", pose(0)));
  EXPECT_EQ(model.lost(), 1);
}

TEST(Report, IsJsonWithTheNumbersOfTheModel) {
  Model model(test_decoder());
  model.add_datagram(1000000, kSlam, short_datagram(0, "POSE", pose(1.5)));
  model.add_datagram(2000000, kSlam, short_datagram(2, "POSE", pose(2.5)));
  model.add_datagram(2000000, kDriver, short_datagram(0, "ODD\"\x01", {1}));
  model.add_datagram(2000000, kDriver, {});
  Surroundings around;
  around.source = "udpm://239.255.76.67:7667";
  around.now_us = 3000000;
  around.overall_rates = true;
  around.publishers[kSlam] = {4711, "marco-slam"};
  around.listeners.push_back({{1, "logger"}, 5, false});
  around.findings.push_back({"text", "command"});
  const auto json = nlohmann::json::parse(json_report(model, around));
  EXPECT_EQ(json["received"], 3);
  EXPECT_EQ(json["lost"], 1);
  EXPECT_EQ(json["foreign_datagrams"], 1);
  const auto& channel = json["channels"][1];
  EXPECT_EQ(channel["channel"], "POSE");
  EXPECT_EQ(channel["type"], "robot.pose2_t");
  EXPECT_EQ(channel["count"], 2);
  EXPECT_EQ(channel["hz"], 1);
  EXPECT_EQ(channel["lost"], 1);
  EXPECT_EQ(channel["last"]["x_m"], 2.5);
  EXPECT_EQ(json["channels"][0]["untyped"], 1);
  EXPECT_TRUE(json["channels"][0]["type"].is_null());
  EXPECT_EQ(json["senders"][0]["process"], "marco-slam");
  EXPECT_EQ(json["senders"][0]["channels"][0]["lost"], 1);
  EXPECT_EQ(json["listeners"][0]["drops"], 5);
  EXPECT_EQ(json["findings"][0]["command"], "command");
}

}  // namespace
}  // namespace marco::spy
