#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/teleop/operator.hpp"
#include "drivers/teleop/screen.hpp"

namespace marco::teleop {
namespace {

using ::testing::HasSubstr;
using Kind = BaseCommand::Kind;

Utime at(double seconds) { return Utime::from_seconds(1000.0 + seconds); }

TEST(Operator, AHeldKeyDrivesAndALetGoOneStops) {
  Operator hands({});
  hands.on_key(Keyboard::kUp, at(0.0));
  auto orders = hands.step(at(0.0));
  ASSERT_EQ(orders.base.size(), 1U);
  EXPECT_EQ(orders.base[0].kind, Kind::velocity);
  EXPECT_DOUBLE_EQ(orders.base[0].velocity_m_per_s, 0.25);
  EXPECT_TRUE(hands.step(at(0.05)).base.empty());  // ten times a second
  EXPECT_EQ(hands.step(at(0.11)).base.size(), 1U);
  orders = hands.step(at(0.7));
  ASSERT_EQ(orders.base.size(), 1U);
  EXPECT_EQ(orders.base[0].kind, Kind::stop);
  EXPECT_TRUE(hands.step(at(0.9)).base.empty());
}

TEST(Operator, StepsSpeedAndStop) {
  Operator hands({});
  hands.on_key('k', at(0.0));
  hands.on_key('j', at(0.0));
  auto orders = hands.step(at(0.0));
  ASSERT_EQ(orders.base.size(), 2U);
  EXPECT_DOUBLE_EQ(orders.base[0].distance_m, -0.25);
  EXPECT_DOUBLE_EQ(orders.base[1].angle_rad, deg_to_rad(10.0));
  EXPECT_GT(orders.base[1].id, orders.base[0].id);
  hands.on_key('+', at(0.1));
  hands.on_key(Keyboard::kRight, at(0.1));
  orders = hands.step(at(0.1));
  EXPECT_DOUBLE_EQ(orders.base.at(0).yaw_rate_rad_per_s, -1.25 * deg_to_rad(25.0));
  hands.on_key(' ', at(0.2));
  orders = hands.step(at(0.2));
  EXPECT_EQ(orders.base.at(0).kind, Kind::stop);
  EXPECT_EQ(orders.pantilt.at(0).kind, PanTiltCommand::Kind::stop);
  EXPECT_TRUE(hands.step(at(0.4)).base.empty());
  hands.on_key('q', at(0.5));
  EXPECT_TRUE(hands.wants_to_quit());
}

TEST(Operator, TurnsTheHeadFromWhereItIs) {
  Operator hands({});
  hands.on_key('t', at(0.0));
  EXPECT_TRUE(hands.step(at(0.0)).pantilt.empty());  // not known where it is
  PanTiltState head;
  head.tilt_rad = deg_to_rad(-10.0);
  hands.on_pantilt(head);
  hands.on_key('t', at(0.0));
  EXPECT_NEAR(rad_to_deg(hands.step(at(0.0)).pantilt.at(0).tilt_rad), -5.0, 1e-9);
}

TEST(Operator, LooksAheadOnceWhenItFirstHearsOfTheHead) {
  Operator hands({});
  EXPECT_TRUE(hands.step(at(0.0)).pantilt.empty());
  PanTiltState head;
  head.tilt_rad = deg_to_rad(-20.0);  // thesis B's home
  hands.on_pantilt(head);
  const auto orders = hands.step(at(0.1));
  ASSERT_EQ(orders.pantilt.size(), 1U);
  EXPECT_EQ(orders.pantilt[0].tilt_rad, 0.0);
  EXPECT_TRUE(hands.step(at(0.2)).pantilt.empty());
  OperatorOptions leave;
  leave.look_ahead_at_start = false;
  Operator idle(leave);
  idle.on_pantilt(head);
  EXPECT_TRUE(idle.step(at(0.1)).pantilt.empty());
}

TEST(Operator, AGamepadDrivesUntilItsStickRestsOrItIsGone) {
  Operator hands({});
  GamepadState pad;
  pad.axes = {0.0F, -1.0F};
  pad.buttons = {false, false};
  hands.on_gamepad(pad, at(0.0));
  EXPECT_DOUBLE_EQ(hands.step(at(0.0)).base.at(0).velocity_m_per_s, 0.25);
  EXPECT_EQ(hands.step(at(3.0)).base.at(0).kind, Kind::velocity);  // no new record, still held
  pad.axes = {0.05F, 0.0F};
  hands.on_gamepad(pad, at(3.1));
  EXPECT_EQ(hands.step(at(3.1)).base.at(0).kind, Kind::stop);
  pad.axes = {0.5F, 0.0F};
  hands.on_gamepad(pad, at(4.0));
  hands.step(at(4.0));
  pad.connected = false;
  hands.on_gamepad(pad, at(4.1));
  EXPECT_EQ(hands.step(at(4.1)).base.at(0).kind, Kind::stop);
  EXPECT_TRUE(hands.step(at(5.0)).base.empty());
}

TEST(Screen, ShowsRobotMapBatteryAndBumpers) {
  RobotView view;
  view.world_from_robot = Pose2{1.0, 2.0, deg_to_rad(90.0)};
  view.odometry = OdometrySample{};
  view.odometry->velocity_m_per_s = 0.25;
  view.base = BaseStatus{};
  view.base->base = "p2os";
  view.base->link = BaseStatus::Link::up;
  view.base->battery_v = {12.6};
  view.base->bumpers = {false, true};
  GridMap tile;
  tile.origin_m = {-2.0, -1.0};
  tile.resolution_m = 0.1;
  tile.width_cells = tile.height_cells = 60;
  tile.occupancy.assign(3600, 0);
  for (std::size_t i = 0; i < 60; ++i) tile.occupancy[i] = 100;  // a wall along y = -1
  view.add_tile(tile, 1);
  const std::string screen = draw_screen(view, 80, 24);
  EXPECT_EQ(std::count(screen.begin(), screen.end(), '\n'), 23);
  EXPECT_THAT(screen, HasSubstr("pose    1.00    2.00 m   90.0 deg"));
  EXPECT_THAT(screen, HasSubstr("battery 12.6 V"));
  EXPECT_THAT(screen, HasSubstr("bumpers -X"));
  EXPECT_THAT(screen, HasSubstr("^"));
  const std::string last = screen.substr(screen.rfind('\n') + 1);
  EXPECT_GT(std::count(last.begin(), last.end(), '#'), 20) << screen;
}

TEST(Screen, AMapThatMovedItsRasterStartsAnew) {
  RobotView view;
  GridMap tile;
  tile.width_cells = tile.height_cells = 1;
  tile.occupancy = {100};
  view.add_tile(tile, 1);
  tile.origin_m = {256 * 0.05, 0.0};
  view.add_tile(tile, 2);
  EXPECT_EQ(view.map_tiles.size(), 2U);
  tile.origin_m = {0.33, 0.0};
  view.add_tile(tile, 2);  // grown, and no old pose changed: the same revision
  EXPECT_EQ(view.map_tiles.size(), 1U);
  EXPECT_FALSE(draw_screen(RobotView{}, 10, 3).empty());
}

}  // namespace
}  // namespace marco::teleop
