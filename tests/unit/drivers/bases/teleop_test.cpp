#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "teleop/operator.hpp"
#include "teleop/screen.hpp"

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

GamepadState held(double x, double y, Utime when) {
  GamepadState pad;
  pad.axes = {static_cast<float>(x), static_cast<float>(y)};
  pad.buttons = {false, false};
  pad.utime = when;
  return pad;
}

TEST(Operator, AGamepadDrivesUntilItsStickRestsOrItIsGone) {
  Operator hands({});
  hands.on_gamepad(held(0.0, -1.0, at(0.0)), at(0.0));
  EXPECT_DOUBLE_EQ(hands.step(at(0.0)).base.at(0).velocity_m_per_s, 0.25);
  hands.on_gamepad(held(0.0, -1.0, at(0.4)), at(0.4));
  EXPECT_EQ(hands.step(at(0.8)).base.at(0).kind, Kind::velocity);  // said again, still held
  hands.on_gamepad(held(0.05, 0.0, at(0.85)), at(0.85));
  EXPECT_EQ(hands.step(at(0.85)).base.at(0).kind, Kind::stop);
  hands.on_gamepad(held(0.5, 0.0, at(4.0)), at(4.0));
  hands.step(at(4.0));
  GamepadState gone = held(0.5, 0.0, at(4.1));
  gone.connected = false;
  hands.on_gamepad(gone, at(4.1));
  EXPECT_EQ(hands.step(at(4.1)).base.at(0).kind, Kind::stop);
  EXPECT_TRUE(hands.step(at(5.0)).base.empty());
}

TEST(Operator, AGamepadThatFallsSilentStops) {
  Operator hands({});
  GamepadState pad = held(0.0, -1.0, at(0.0));
  pad.axes.resize(4, 1.0F);  // the head's stick, too
  hands.on_pantilt({});
  hands.on_gamepad(pad, at(0.0));
  EXPECT_FALSE(hands.step(at(0.0)).pantilt.empty());
  EXPECT_EQ(hands.step(at(0.45)).base.at(0).kind, Kind::velocity);
  const auto orders = hands.step(at(0.55));
  ASSERT_EQ(orders.base.size(), 1U);
  EXPECT_EQ(orders.base[0].kind, Kind::stop);
  for (double t = 0.6; t < 5.0; t += 0.1) {
    const auto later = hands.step(at(t));
    EXPECT_TRUE(later.base.empty() && later.pantilt.empty()) << t;
  }
}

TEST(Operator, ARecordedGamepadDrivesNothing) {
  Operator hands({});
  hands.on_gamepad(held(0.0, -1.0, at(-3.0)), at(0.0));
  EXPECT_TRUE(hands.step(at(0.0)).base.empty());
  EXPECT_THAT(hands.gamepad_trouble(), HasSubstr("3.0 s old"));
  hands.on_gamepad(held(0.0, -1.0, at(2.0)), at(0.1));
  EXPECT_TRUE(hands.step(at(0.1)).base.empty());
  hands.on_gamepad(held(0.0, -1.0, at(0.2)), at(0.2));
  EXPECT_EQ(hands.step(at(0.2)).base.size(), 1U);
  EXPECT_EQ(hands.gamepad_trouble(), "");
  // A stick at rest does not end what a key drives.
  hands.on_key(Keyboard::kUp, at(0.9));
  hands.step(at(0.9));
  hands.on_gamepad(held(0.0, 0.0, at(0.95)), at(0.95));
  EXPECT_EQ(hands.step(at(1.05)).base.at(0).kind, Kind::velocity);
}

TEST(Operator, TheEmergencyStopIsRepeatedUntilSomebodyReleasesIt) {
  Operator hands({});
  hands.on_key('e', at(0.0));
  auto orders = hands.step(at(0.0));
  ASSERT_EQ(orders.emergency.size(), 3U);
  EXPECT_TRUE(orders.emergency[0].engaged);
  EXPECT_EQ(orders.emergency[0].sender, "marco drive");
  EXPECT_EQ(orders.base.at(0).kind, Kind::stop);
  // A driver that was started meanwhile must hear of it.
  int repeated = 0;
  for (double t = 0.02; t < 10.0; t += 0.02) {
    for (const auto& message : hands.step(at(t)).emergency) {
      ++repeated;
      EXPECT_EQ(message.utime_us, at(0.0).us);  // the same message
    }
  }
  EXPECT_GE(repeated, 15);
  EXPECT_LE(repeated, 25);
  hands.on_key(' ', at(10.1));
  hands.step(at(10.1));
  EXPECT_EQ(hands.step(at(11.2)).emergency.size(), 1U);  // a plain stop leaves it
  hands.on_key('c', at(11.3));
  orders = hands.step(at(11.3));
  ASSERT_EQ(orders.emergency.size(), 3U);
  EXPECT_FALSE(orders.emergency[0].engaged);
  for (double t = 11.32; t < 12.0; t += 0.02) hands.step(at(t));
  EXPECT_TRUE(hands.step(at(13.0)).emergency.empty());
  hands.on_key('e', at(14.0));
  hands.step(at(14.0));
  hands.on_emergency_stop({at(15.0).us, false, "sheriff", ""});
  EXPECT_TRUE(hands.step(at(16.0)).emergency.empty());
}

using process::EmergencyStopSender;

TEST(EmergencyStopSender, KeepsRepeatingWhenAnotherStopsTooUntilALaterRelease) {
  EmergencyStopSender stop("drive");
  EXPECT_FALSE(stop.due(0));
  stop.order(process::EmergencyStop::engage, "key", 100, 0);
  stop.hear({200, true, "marco stop", "a child"});
  const auto repeated = stop.due(60'000);
  ASSERT_TRUE(repeated);
  EXPECT_EQ(repeated->utime_us, 200);  // theirs is the latest: a release must be later than it
  stop.hear({150, false, "spy", ""});  // overtaken on its way
  EXPECT_TRUE(stop.is_engaged());
  EXPECT_TRUE(stop.due(2'000'000));
  stop.hear({300, false, "spy", ""});
  EXPECT_FALSE(stop.is_engaged());
  EXPECT_FALSE(stop.due(9'000'000));
}

TEST(EmergencyStopSender, DoesNotRepeatWhatOthersOrderAndIsLaterThanTheirStamps) {
  EmergencyStopSender stop("drive");
  stop.hear({INT64_MAX, true, "a broken clock", ""});
  EXPECT_FALSE(stop.due(9'000'000));
  const int64_t theirs_us = stop.latest().utime_us;
  EXPECT_GT(stop.order(process::EmergencyStop::release, "key", 100, 0).utime_us, theirs_us);
  stop.hear({INT64_MAX, true, "a broken clock", ""});  // not later than our release
  EXPECT_FALSE(stop.is_engaged());
  int sent = 1;
  for (int64_t now_us = 0; now_us < 20'000'000; now_us += 10'000) sent += stop.due(now_us) ? 1 : 0;
  EXPECT_EQ(sent, 10);  // a release is repeated for a moment only
}

TEST(Screen, SaysWhyNothingIsHeardInWholeWords) {
  RobotView view;
  view.notice = "waiting for the base: nothing on BASE_STATUS for 3 s.\n  On this bus: ODOMETRY.";
  const std::string screen = draw_screen(view, 30, 10);
  EXPECT_THAT(screen, HasSubstr("waiting for the base: nothing\non BASE_STATUS for 3 s.\nOn this "
                                "bus: ODOMETRY.\n"));
  EXPECT_EQ(std::count(screen.begin(), screen.end(), '\n'), 9);
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
