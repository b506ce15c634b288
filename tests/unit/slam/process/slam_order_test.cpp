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
  orders.take(save, "/maps", slow);
  EXPECT_EQ(reply_text(orders), "");
  for (int i = 0; i < 3; ++i) {
    orders.take(save, "/maps", slow);
    EXPECT_EQ(reply_text(orders), "refused: SAVE: the map before is still being written");
  }
  disk.set_value();
  orders.wait();
  EXPECT_EQ(reply_text(orders), "saved");
  orders.take(save, "/maps", [&](const SlamOrder&) {
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
  orders.take(save, "/maps", [&](const SlamOrder&) {
    return orders.write([&disk] {
      disk.get_future().wait();
      return "saved";
    });
  });
  orders.take(pause, "/maps", [](const SlamOrder&) { return "paused"; });
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
  orders.take(save, "/maps", [](const SlamOrder&) { return "saved"; });
  const auto refused = orders.take_reply();
  ASSERT_TRUE(refused);
  EXPECT_FALSE(refused->ok);
  EXPECT_EQ(refused->path, "");
  EXPECT_EQ(refused->command_utime, 17);
}

}  // namespace
}  // namespace marco::slam
