#include "slam/process/slam_order.hpp"

#include <gmock/gmock.h>

#include <future>

namespace marco::slam {
namespace {

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
  EXPECT_EQ(orders.take_reply(), "");
  for (int i = 0; i < 3; ++i) {
    orders.take(save, "/maps", slow);
    EXPECT_EQ(orders.take_reply(), "refused: SAVE: the map before is still being written");
  }
  disk.set_value();
  orders.wait();
  EXPECT_EQ(orders.take_reply(), "saved");
  orders.take(save, "/maps", [&](const SlamOrder&) {
    return orders.write([]() -> std::string { throw std::runtime_error("disk full"); });
  });
  orders.wait();
  EXPECT_EQ(orders.take_reply(), "failed: disk full");
  EXPECT_EQ(orders.take_reply(), "");
}

}  // namespace
}  // namespace marco::slam
