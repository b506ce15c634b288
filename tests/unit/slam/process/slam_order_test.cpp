#include "slam/process/slam_order.hpp"

#include <gmock/gmock.h>

#include <future>

namespace marco::slam {
namespace {

std::string reply_text(SlamOrders& orders) {
  const auto reply = orders.take_reply();
  return reply ? reply->text : "";
}

TEST(SlamOrders, AMapIsWrittenBehindTheScansAndOneAtATime) {
  process::DropCounter drops;
  SlamOrders orders(drops);
  orders.write_in_background();
  slam_command_t save = {};
  save.command = slam_command_t::SAVE;
  save.folder = "hall";
  std::promise<void> disk;
  const auto slow = [&](const SlamOrder&) {
    return orders.write([&disk] {
      disk.get_future().wait();
      return "saved";
    });
  };
  orders.take(save, Utime::from_us(save.utime), "/maps", slow);
  EXPECT_EQ(reply_text(orders), "");
  for (int i = 0; i < 3; ++i) {
    orders.take(save, Utime::from_us(save.utime), "/maps", slow);
    EXPECT_EQ(reply_text(orders), "refused: SAVE: the previous map is still being written");
  }
  disk.set_value();
  orders.wait();
  EXPECT_EQ(reply_text(orders), "saved");
  orders.take(save, Utime::from_us(save.utime), "/maps", [&](const SlamOrder&) {
    return orders.write([]() -> std::string { throw std::runtime_error("disk full"); });
  });
  orders.wait();
  EXPECT_EQ(reply_text(orders), "failed: disk full");
  EXPECT_EQ(reply_text(orders), "");
}

TEST(SlamOrders, AReplyNamesItsOrderThoughOthersWereAnsweredMeanwhile) {
  process::DropCounter drops;
  SlamOrders orders(drops);
  orders.write_in_background();
  slam_command_t save = {}, pause = {};
  save.command = slam_command_t::SAVE;
  save.utime = 17;
  save.folder = "hall";
  pause.command = slam_command_t::PAUSE;
  pause.utime = 18;
  std::promise<void> disk;
  orders.take(save, Utime::from_us(save.utime), "/maps", [&](const SlamOrder&) {
    return orders.write([&disk] {
      disk.get_future().wait();
      return "saved";
    });
  });
  orders.take(pause, Utime::from_us(pause.utime), "/maps",
              [](const SlamOrder&) { return "paused"; });
  const auto paused = orders.take_reply();
  ASSERT_TRUE(paused);
  EXPECT_EQ(paused->command, int{slam_command_t::PAUSE});
  EXPECT_EQ(paused->command_utime, 18);
  EXPECT_TRUE(paused->ok);
  EXPECT_EQ(paused->path, "");
  EXPECT_FALSE(orders.take_reply());
  disk.set_value();
  orders.wait();
  const auto saved = orders.take_reply();
  ASSERT_TRUE(saved);
  EXPECT_EQ(saved->command, int{slam_command_t::SAVE});
  EXPECT_EQ(saved->command_utime, 17);
  EXPECT_TRUE(saved->ok);
  EXPECT_EQ(saved->path, "/maps/hall");
  save.folder = "../hall";
  orders.take(save, Utime::from_us(save.utime), "/maps", [](const SlamOrder&) { return "saved"; });
  const auto refused = orders.take_reply();
  ASSERT_TRUE(refused);
  EXPECT_FALSE(refused->ok);
  EXPECT_EQ(refused->path, "");
  EXPECT_EQ(refused->command_utime, 17);
}

TEST(SlamOrders, AnOrderOfAnotherTimeIsRefusedWithItsAge) {
  process::DropCounter drops;
  SlamOrders orders(drops);
  const Utime now = Utime::from_us(1'800'000'000'000'000);
  int obeyed = 0;
  const auto given = [&](int64_t utime, int8_t kind) {
    slam_command_t command = {};
    command.command = kind;
    command.utime = utime;
    command.folder = "hall";
    orders.take(command, now, "/maps", [&](const SlamOrder&) {
      ++obeyed;
      return "done";
    });
    return reply_text(orders);
  };
  constexpr int64_t kDayUs = 86'400'000'000;
  for (int8_t kind = slam_command_t::SAVE; kind <= slam_command_t::EXTEND; ++kind) {
    EXPECT_THAT(given(now.us - kDayUs, kind),
                ::testing::StartsWith("refused: order is 1 days old"));
    EXPECT_THAT(given(now.us - 600'000, kind), ::testing::HasSubstr("0.6 s old"));
    EXPECT_THAT(given(now.us + 600'000, kind), ::testing::HasSubstr("0.6 s ahead"));
    EXPECT_THAT(given(0, kind), ::testing::HasSubstr("days old"));
    EXPECT_THAT(given(INT64_MIN, kind), ::testing::StartsWith("refused: "));
    EXPECT_THAT(given(INT64_MAX, kind), ::testing::StartsWith("refused: "));
    EXPECT_EQ(given(now.us - 400'000, kind), "done");
    EXPECT_EQ(given(now.us + 400'000, kind), "done");
  }
  EXPECT_EQ(obeyed, 2 * (slam_command_t::EXTEND + 1));
  EXPECT_EQ(drops.by_cause().at("slam_command_t: refused"), 6 * (slam_command_t::EXTEND + 1));
}

}  // namespace
}  // namespace marco::slam
