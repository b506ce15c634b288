#include "lcm_tools/relay/relay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/tests/support/encoded.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::relay {
namespace {

using ::marco::testing::complaint;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

std::span<const uint8_t> as_bytes(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// What liblcm 1.3.1 itself sends for subscribe("A.*") and publish("HELLO", "world").
TEST(Tcpq, ReadsWhatLiblcmSends) {
  constexpr char kSent[] =
      "\x28\x76\x17\xfb\0\0\x01\0\0\0\0\x02\0\0\0\x03"
      "A.*\0\0\0\x01\0\0\0\x05HELLO\0\0\0\x05world";
  const std::string stream(kSent, sizeof kSent - 1);
  for (const std::size_t step : {1U, 7U, 64U}) {
    FrameReader reader(Role::client);
    std::vector<Frame> frames;
    for (std::size_t at = 0; at < stream.size(); at += step) {
      reader.add(as_bytes(stream).subspan(at, std::min(step, stream.size() - at)));
      while (auto frame = reader.next()) frames.push_back(std::move(*frame));
    }
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[0].kind, Frame::Kind::subscribe);
    EXPECT_EQ(frames[0].channel, "A.*");
    EXPECT_EQ(frames[1].channel, "HELLO");
    EXPECT_EQ(frames[1].data, bytes_of("world"));
  }
  std::string ours = greeting_of(Role::client);
  append_subscribe(ours, "A.*");
  append_publish(ours, "HELLO", bytes_of("world"));
  EXPECT_EQ(ours, stream);
}

TEST(Tcpq, RefusesOtherProtocolsAndLengthsThatLie) {
  const auto refused = [](const std::string& stream) {
    FrameReader reader(Role::client);
    reader.add(as_bytes(stream));
    return complaint([&] {
      while (reader.next()) {
      }
    });
  };
  EXPECT_THAT(refused("GET / HTTP/1.1\r\n"), HasSubstr("tcpq"));
  EXPECT_THAT(refused(greeting_of(Role::server)), HasSubstr("tcpq"));
  const std::string hello = greeting_of(Role::client);
  EXPECT_THAT(refused(hello + std::string("\0\0\0\x09\0\0\0\x01", 8)), HasSubstr("unknown type"));
  EXPECT_THAT(refused(hello + std::string("\0\0\0\x01\xff\0\0\0", 8)), HasSubstr("name"));
  EXPECT_THAT(refused(hello + std::string("\0\0\0\x01\0\0\0\x01X\xff\0\0\0", 13)),
              HasSubstr("64 MB"));
}

TEST(Outbox, DropsTheOldestOfTheChannelThatFillsIt) {
  Outbox outbox(1000);
  EXPECT_THAT(outbox.add("POSE", std::vector<uint8_t>(20)), IsEmpty());
  EXPECT_THAT(outbox.add("PICTURE", std::vector<uint8_t>(200, 1)), IsEmpty());
  EXPECT_THAT(outbox.add("PICTURE", std::vector<uint8_t>(200, 2)), IsEmpty());
  EXPECT_THAT(outbox.add("PICTURE", std::vector<uint8_t>(200, 3)), ElementsAre("PICTURE"));
  EXPECT_THAT(outbox.add("HUGE", std::vector<uint8_t>(5000)), ElementsAre("HUGE"));
  EXPECT_EQ(outbox.take()->channel, "POSE");
  EXPECT_EQ(outbox.take()->data.front(), 2);
  EXPECT_THAT(outbox.clear(), ElementsAre(std::pair("PICTURE", 1)));
  EXPECT_TRUE(outbox.empty());
  EXPECT_EQ(outbox.bytes(), 0U);
}

TEST(EchoFilter, KnowsForASecondWhatWentToASide) {
  EchoFilter echoes;
  const auto data = bytes_of("data");
  echoes.note_sent(1, "A", data, 1'000'000);
  EXPECT_TRUE(echoes.is_echo(1, "A", data, 1'900'000));
  EXPECT_FALSE(echoes.is_echo(2, "A", data, 1'900'000));
  EXPECT_FALSE(echoes.is_echo(1, "B", data, 1'900'000));
  EXPECT_FALSE(echoes.is_echo(1, "A", bytes_of("Data"), 1'900'000));
  EXPECT_FALSE(echoes.is_echo(1, "A", data, 2'100'000));
}

std::vector<uint8_t> stop(bool engaged) {
  emergency_stop_t message{};
  message.engaged = engaged ? 1 : 0;
  return testing::encoded(message);
}

TEST(ChannelRule, HoldsOrdersBackButNeverAStop) {
  const ChannelRule rule("", {"SLAM_CHANGE"}, ChannelRule::Orders::held_back);
  for (const char* channel : {"LIDAR", "PM_INFO", "MAP_REQUEST"}) {
    EXPECT_TRUE(rule.passes(channel, {})) << channel;
  }
  for (const char* channel : {"BASE_COMMAND", "PM_ORDERS", "PMD_ORDERS2", "PM_DISCOVER",
                              "MBOT_VEL_CMD", "/cmd_vel#geometry_msgs.Twist", "SLAM_CHANGE"}) {
    EXPECT_FALSE(rule.passes(channel, {})) << channel;
  }
  EXPECT_TRUE(rule.passes("EMERGENCY_STOP", stop(true)));
  EXPECT_FALSE(rule.passes("EMERGENCY_STOP", stop(false)));
  EXPECT_FALSE(rule.passes("EMERGENCY_STOP", bytes_of("nonsense")));

  const ChannelRule scans("LIDAR.*|BASE_COMMAND", {}, ChannelRule::Orders::passed_on);
  EXPECT_TRUE(scans.passes("LIDAR_RAW", {}));
  EXPECT_TRUE(scans.passes("BASE_COMMAND", {}));
  EXPECT_FALSE(scans.passes("CAMERA", {}));
  EXPECT_TRUE(scans.passes("EMERGENCY_STOP", stop(true)));
  EXPECT_THAT(complaint([] { ChannelRule("(", {}, ChannelRule::Orders::held_back); }),
              HasSubstr("regular expression"));
}

TEST(Endpoint, IsAPortOrAHostWithOne) {
  EXPECT_EQ(to_string(parse_endpoint("7700")), "127.0.0.1:7700");
  EXPECT_EQ(to_string(parse_endpoint("robot:7700")), "robot:7700");
  EXPECT_EQ(parse_endpoint("[::1]:7700").host, "::1");
  for (const char* wrong :
       {"", "robot", "robot:", "robot:0", "robot:77000", ":7700", "robot:77x"}) {
    EXPECT_THAT(complaint([wrong] { parse_endpoint(wrong); }), HasSubstr("HOST:PORT")) << wrong;
  }
}

// Two relays with a bus each, joined over this host's TCP.
class Relays : public ::testing::Test {
 protected:
  static RelayOptions server() {
    RelayOptions options;
    options.listen = Endpoint{"127.0.0.1", port()};
    return options;
  }
  static RelayOptions client() {
    RelayOptions options;
    options.connect = {Endpoint{"127.0.0.1", port()}};
    return options;
  }
  static std::string port() { return std::to_string(20000 + getpid() % 20000); }

  void spin(int rounds = 20) {
    for (int i = 0; i < rounds; ++i) {
      for (Relay* relay : {robot_.get(), laptop_.get()}) {
        if (relay != nullptr) relay->run_once(1);
      }
    }
  }

  process::DropCounter drops_;
  process::LcmBus robot_bus_{"memq://"}, laptop_bus_{"memq://"};
  std::unique_ptr<Relay> robot_ = std::make_unique<Relay>(robot_bus_, drops_, server());
  std::unique_ptr<Relay> laptop_ = std::make_unique<Relay>(laptop_bus_, drops_, client());
};

TEST_F(Relays, PassEachMessageOnce) {
  spin();
  std::vector<std::string> heard;
  laptop_bus_.subscribe_raw(".*", [&](const process::RawMessage& message) {
    heard.emplace_back(message.bytes.begin(), message.bytes.end());
  });
  for (const char* text : {"one", "two", "three"}) {
    robot_bus_.publish_raw("LIDAR", bytes_of(text), {});
    robot_bus_.publish_raw("BASE_COMMAND", bytes_of(text), {});
  }
  spin();
  EXPECT_THAT(heard, ElementsAre("one", "two", "three"));
  laptop_bus_.publish_raw("MAP_REQUEST", bytes_of("back"), {});
  spin();
  EXPECT_THAT(robot_->state(), HasSubstr("1 in, 3 out"));
  EXPECT_THAT(laptop_->state(), HasSubstr("3 in, 1 out"));
}

TEST_F(Relays, ConnectAgainWhenTheOtherSideIsBack) {
  spin();
  EXPECT_THAT(laptop_->state(), HasSubstr("1 connections"));
  robot_.reset();
  spin();
  EXPECT_THAT(laptop_->state(), HasSubstr("0 connections"));
  robot_ = std::make_unique<Relay>(robot_bus_, drops_, server());
  for (int i = 0; i < 300 && robot_->state().starts_with("0"); ++i) spin(2);
  spin();
  EXPECT_THAT(laptop_->state(), HasSubstr("1 connections"));
}

}  // namespace
}  // namespace marco::relay
