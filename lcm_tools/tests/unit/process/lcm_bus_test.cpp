#include "lcm_tools/process/lcm_bus.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "robot/pose2_t.hpp"

namespace marco::process {
namespace {

TEST(LcmBus, DeliversAndSurvivesAHandlerThatThrows) {
  LcmBus bus("memq://");
  DropCounter drops;
  int handled = 0;
  bus.subscribe<robot::pose2_t>("P", drops, [&](const robot::pose2_t& pose, const RawMessage&) {
    if (pose.x_m > 1.0) throw std::runtime_error("too far");
    ++handled;
  });
  robot::pose2_t pose{};
  for (const double x_m : {0.0, 2.0, 1.0}) {
    pose.x_m = x_m;
    bus.publish("P", pose);
  }
  EXPECT_TRUE(bus.handle_once(100));
  EXPECT_THROW(bus.handle_once(100), std::runtime_error);
  EXPECT_TRUE(bus.handle_once(100));
  EXPECT_EQ(handled, 2);
  EXPECT_FALSE(bus.handle_once(0));
}

// Who is told what: the number that each message begins with.
struct Told {
  explicit Told(LcmBus& told_by) : bus(told_by) {}

  void listen(const std::string& channel, char who) {
    bus.subscribe_raw(channel, [this, who](const RawMessage& raw) {
      int32_t number = 0;
      std::memcpy(&number, raw.bytes.data(), sizeof number);
      got.emplace_back(who, number);
    });
  }
  void publish(const std::string& channel, int32_t number, std::size_t size) {
    std::vector<uint8_t> bytes(size);
    std::memcpy(bytes.data(), &number, sizeof number);
    bus.publish_raw(channel, bytes, Utime{});
  }
  int handle_all() {
    int handled = 0;
    while (bus.handle_once(0)) ++handled;
    return handled;
  }
  std::vector<int> of(char who) const {
    std::vector<int> numbers;
    for (const auto& [one, number] : got) {
      if (one == who) numbers.push_back(number);
    }
    return numbers;
  }

  LcmBus& bus;
  std::vector<std::pair<char, int>> got;
};

constexpr std::size_t kScanBytes = 1500, kPoseBytes = 60;
constexpr int kCapacity = static_cast<int>(LcmBus::kQueueCapacity);

TEST(LcmBus, WhoIsTooSlowLosesTheOldestAndSaysHowMany) {
  LcmBus bus("memq://");
  Told told(bus);
  told.listen("FAST", 'f');
  told.listen("SLOW", 's');
  told.listen("SLOW", 't');
  told.publish("SLOW", 0, kScanBytes);
  constexpr int kSent = kCapacity + 7;
  for (int i = 0; i < kSent; ++i) told.publish("FAST", i, kScanBytes);
  told.publish("SLOW", 1000000, kScanBytes);

  EXPECT_EQ(told.handle_all(), kSent - 7 + 2);
  EXPECT_EQ(bus.lost(), (std::map<std::string, int64_t>{{"FAST", 7}}));
  // In the order of arrival; a message with two handlers is one.
  const auto& got = told.got;
  ASSERT_EQ(got.size(), static_cast<std::size_t>(kSent - 7 + 4));
  EXPECT_EQ(got[0], std::make_pair('s', 0));
  EXPECT_EQ(got[1], std::make_pair('t', 0));
  EXPECT_EQ(got[2], std::make_pair('f', 7));
  EXPECT_EQ(got[got.size() - 3], std::make_pair('f', kSent - 1));
  EXPECT_EQ(got.back(), std::make_pair('t', 1000000));
}

// Two lasers: what is left of both must be of the same time. All odometry stays, or the next scan
// would not know where the robot has gone since the last one that was used.
TEST(LcmBus, ScansThatCameBeforeTheOldestThatIsLeftGoAndOdometryStays) {
  LcmBus bus("memq://");
  Told told(bus);
  told.listen("SCAN", 's');
  told.listen("OTHER_SCAN", 'r');
  told.listen("ODOMETRY", 'o');
  told.listen("ORDER", 'c');
  constexpr int kLost = 100, kSent = kCapacity + kLost;
  for (int i = 0; i < kSent; ++i) {
    told.publish("SCAN", i, kScanBytes);
    if (i % 4 == 0) told.publish("ODOMETRY", i, kPoseBytes);
    if (i % 4 == 0) told.publish("OTHER_SCAN", i, kScanBytes);
    if (i % 100 == 1) told.publish("ORDER", i, kScanBytes);
  }
  told.handle_all();

  ASSERT_EQ(told.of('s').size(), LcmBus::kQueueCapacity);
  EXPECT_EQ(told.of('s').front(), kLost);
  ASSERT_EQ(told.of('r').size(), LcmBus::kQueueCapacity / 4);
  EXPECT_EQ(told.of('r').front(), kLost);
  EXPECT_EQ(told.of('o').size(), kSent / 4U);
  EXPECT_EQ(told.of('c').size(), kSent / 100U);  // few: none is lost
  EXPECT_EQ(bus.lost(),
            (std::map<std::string, int64_t>{{"SCAN", kLost}, {"OTHER_SCAN", kLost / 4}}));
}

TEST(LcmBus, WhereSmallOnesAreTooManyWhatCameBeforeThemGoes) {
  LcmBus bus("memq://");
  Told told(bus);
  told.listen("SCAN", 's');
  told.listen("POSE", 'p');
  constexpr int kSent = static_cast<int>(LcmBus::kSmallCapacity) + 2000;
  for (int i = 0; i < kSent; ++i) {
    if (i < 200) told.publish("SCAN", i, kScanBytes);
    told.publish("POSE", i, kPoseBytes);
    if (i % 500 == 499) bus.handle_once(0);  // LCM's own queues are emptied by that
  }
  told.handle_all();
  const int64_t lost = bus.lost().at("POSE");
  // Those of the capacity wait; a few were handled while they came.
  EXPECT_GT(lost, 1900);
  EXPECT_LE(lost, 2000);
  EXPECT_EQ(static_cast<int64_t>(told.of('p').size()) + lost, kSent);
  EXPECT_EQ(told.of('p').back(), kSent - 1);
  // All but the few that stay, and those that were handled before it came to this.
  EXPECT_GT(bus.lost().at("SCAN"), 100);
}

TEST(LcmBus, AnUrlNobodyKnowsIsRefusedWithAHint) {
  EXPECT_THROW(LcmBus("nonsense://"), std::runtime_error);
}

}  // namespace
}  // namespace marco::process
