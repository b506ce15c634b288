// What a sheriff hears and says beside procman's own messages, over a bus inside the process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/procman/process/deputy_watch.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/emergency_stop.hpp"
#include "lcm_tools/tests/unit/procman/sheriff_world.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::procman {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Order = EmergencyStop::Order;

class SheriffBusTest : public testing::Test {
 protected:
  void deliver() {
    while (bus_.handle_once(0)) {
    }
  }

  process::LcmBus bus_{"memq://"};
  process::DropCounter drops_;
};

class EmergencyStopTest : public SheriffBusTest {
 protected:
  EmergencyStopTest() {
    bus_.subscribe<emergency_stop_t>(
        marco::channels::kEmergencyStop, drops_,
        [this](const emergency_stop_t& message, const auto&) { sent_.push_back(message); });
  }
  /// Somebody else's.
  void hear(int64_t utime_us, bool engaged) {
    emergency_stop_t message;
    message.utime = utime_us;
    message.engaged = engaged ? 1 : 0;
    message.sender = "teleop";
    message.reason = "key";
    bus_.publish(marco::channels::kEmergencyStop, message);
    deliver();
  }

  EmergencyStop stop_{bus_, drops_, "sheriff"};
  std::vector<emergency_stop_t> sent_;
};

TEST_F(EmergencyStopTest, IsSentAtOnceAgainAndAgainAndReleased) {
  stop_.order(Order::engage, 0);
  deliver();
  ASSERT_THAT(sent_, SizeIs(1));
  EXPECT_EQ(sent_[0].engaged, 1);
  EXPECT_EQ(sent_[0].sender, "sheriff");
  EXPECT_THAT(stop_.engaged(), HasSubstr("by sheriff"));
  for (int64_t now_us = 0; now_us < 10 * kSecondUs; now_us += 10'000) stop_.step_to(now_us);
  deliver();
  EXPECT_GE(sent_.size(), 15U) << "a base that is started later hears it too";
  EXPECT_LE(sent_.size(), 25U);
  EXPECT_EQ(sent_.back().utime, sent_.front().utime) << "a later release by another counts";
  stop_.order(Order::release, 10 * kSecondUs);
  deliver();
  EXPECT_EQ(sent_.back().engaged, 0);
  EXPECT_GT(sent_.back().utime, sent_.front().utime);
  EXPECT_EQ(stop_.engaged(), "");
  sent_.clear();
  for (int64_t now_us = 10 * kSecondUs; now_us < 30 * kSecondUs; now_us += 10'000) {
    stop_.step_to(now_us);
  }
  deliver();
  EXPECT_THAT(sent_, SizeIs(9)) << "a release is repeated for a moment only";
}

TEST_F(EmergencyStopTest, OthersOrdersAreShownAndTheLatestCounts) {
  hear(100, true);
  EXPECT_EQ(stop_.engaged(), "by teleop: key");
  hear(90, false);
  EXPECT_EQ(stop_.engaged(), "by teleop: key");
  hear(110, false);
  EXPECT_EQ(stop_.engaged(), "");
  stop_.order(Order::engage, 0);
  hear(wall_clock_us() + 100 * kSecondUs, false);  // its clock is ahead
  EXPECT_EQ(stop_.engaged(), "");
  sent_.clear();
  stop_.step_to(kSecondUs);
  deliver();
  EXPECT_THAT(sent_, IsEmpty()) << "what another has released is not engaged again";
  stop_.order(Order::engage, kSecondUs);
  EXPECT_NE(stop_.engaged(), "") << "a new order counts in spite of clocks";
  bus_.publish_raw(marco::channels::kEmergencyStop, std::vector<uint8_t>(30, 0xff), {});
  deliver();
  EXPECT_NE(stop_.engaged(), "");
}

class DeputyWatchTest : public SheriffBusTest {
 protected:
  DeputyWatch watch_{bus_, 0};
};

TEST_F(DeputyWatchTest, SaysOnceWhichDeputyIsMissingAndWhatToDo) {
  SheriffWorld world(false);
  EXPECT_THAT(watch_.step_to(2'900'000, world.sheriff), IsEmpty());
  const auto events = watch_.step_to(3'000'000, world.sheriff);
  ASSERT_THAT(events, SizeIs(1));
  EXPECT_THAT(events[0], HasSubstr("deputy base was silent for 3 s (as was every other)"));
  EXPECT_THAT(events[0], HasSubstr("marco-procman-deputy -i base --script FILE"));
  EXPECT_THAT(watch_.step_to(9'000'000, world.sheriff), IsEmpty());
}

TEST_F(DeputyWatchTest, SaysWhoFellSilentAndCameBack) {
  SheriffWorld world;  // heard at 100 s
  EXPECT_THAT(watch_.step_to(world.now_us + 4 * kSecondUs, world.sheriff), IsEmpty());
  EXPECT_THAT(watch_.step_to(world.now_us + 6 * kSecondUs, world.sheriff),
              ElementsAre(HasSubstr("deputy base has been silent for 5 s")));
  EXPECT_THAT(watch_.step_to(world.now_us + 7 * kSecondUs, world.sheriff), IsEmpty());
  world.now_us += 7 * kSecondUs;
  world.info();
  EXPECT_THAT(watch_.step_to(world.now_us, world.sheriff), ElementsAre("deputy base is back"));
}

TEST_F(DeputyWatchTest, NoticesTheOlderProtocol) {
  const SheriffWorld world;
  const auto hear = [&](const std::vector<uint8_t>& bytes) {
    bus_.publish_raw("PMD_INFO2", bytes, {});
    deliver();
    return watch_.step_to(0, world.sheriff);
  };
  std::vector<uint8_t> info(19, 0);
  info.push_back(6);
  for (const char c : std::string("robot")) info.push_back(static_cast<uint8_t>(c));
  info.resize(60, 0);
  EXPECT_THAT(hear(info), ElementsAre(HasSubstr("deputy robot uses libbot2's protocol")));
  EXPECT_THAT(hear(info), IsEmpty());
  EXPECT_THAT(hear({1, 2, 3}), IsEmpty());
  info[17] = 0x7f;  // a length beyond the message
  EXPECT_THAT(hear(info), IsEmpty());
}

}  // namespace
}  // namespace marco::procman
