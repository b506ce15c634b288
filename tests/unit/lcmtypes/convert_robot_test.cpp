#include "lcmtypes/convert_robot.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace marco {
namespace {

template <class Value>
Value through_message(const Value& value) {
  auto message = to_message(value);
  std::vector<uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  decltype(message) back;
  EXPECT_EQ(back.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  return from_message(back);
}

TEST(ConvertRobot, ABaseCommandKeepsItsFields) {
  BaseCommand command;
  command.utime = Utime::from_us(7);
  command.id = 42;
  command.kind = BaseCommand::Kind::go_to;
  command.point_m = {1.5, -2.5};
  command.max_velocity_m_per_s = 0.25;
  const BaseCommand back = through_message(command);
  EXPECT_EQ(back.id, 42);
  EXPECT_EQ(back.kind, BaseCommand::Kind::go_to);
  EXPECT_EQ(back.point_m, command.point_m);
  EXPECT_EQ(back.max_velocity_m_per_s, 0.25);
}

TEST(ConvertRobot, ABaseStatusKeepsItsLists) {
  BaseStatus status;
  status.base = "p2os";
  status.link = BaseStatus::Link::up;
  status.command = BaseStatus::Command::shortened;
  status.battery_v = {12.5, 25.0};
  status.bumpers = {true, false, true};
  status.note = "wall";
  const BaseStatus back = through_message(status);
  EXPECT_EQ(back.link, BaseStatus::Link::up);
  EXPECT_EQ(back.command, BaseStatus::Command::shortened);
  EXPECT_EQ(back.battery_v, status.battery_v);
  EXPECT_EQ(back.bumpers, status.bumpers);
  EXPECT_EQ(back.note, "wall");
}

TEST(ConvertRobot, AnEmergencyStopKeepsItsFieldsWhateverItsStamp) {
  const EmergencyStop stop{Utime::from_us(INT64_MIN), true, "marco stop", "a child"};
  const EmergencyStop back = through_message(stop);
  EXPECT_TRUE(back.engaged);
  EXPECT_EQ(back.utime, stop.utime);
  EXPECT_EQ(back.sender, "marco stop");
  EXPECT_EQ(back.reason, "a child");
  EXPECT_THROW(from_message(to_message(EmergencyStop{Utime::from_us(INT64_MIN), false, "", ""})),
               std::invalid_argument);
}

TEST(ConvertRobot, RefusesWhatCannotBe) {
  base_command_t command = to_message(BaseCommand{});
  command.kind = 17;
  EXPECT_THROW(from_message(command), std::invalid_argument);
  command = to_message(BaseCommand{});
  command.velocity_m_per_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(command), std::invalid_argument);
  SonarRing ring;
  ring.readings.push_back({std::numeric_limits<double>::infinity(), {}});
  EXPECT_THROW(from_message(to_message(ring)), std::invalid_argument);
}

TEST(ConvertRobot, SonarPanTiltAndGamepadKeepTheirFields) {
  SonarRing ring;
  ring.readings = {{1.25, {0.1, 0.2, 0.3}}, {0.0, {-0.1, 0.0, 3.0}}};
  EXPECT_EQ(through_message(ring).readings[1].robot_from_sonar.theta_rad, 3.0);
  PanTiltCommand look;
  look.kind = PanTiltCommand::Kind::go_to;
  look.tilt_rad = -0.25;
  EXPECT_EQ(through_message(look).tilt_rad, -0.25);
  GamepadState pad;
  pad.axes = {0.5F, -1.0F};
  pad.buttons = {false, true};
  EXPECT_EQ(through_message(pad).axes, pad.axes);
  EXPECT_EQ(through_message(pad).buttons, pad.buttons);
}

}  // namespace
}  // namespace marco
