#include "lcmtypes/convert_robot.hpp"

#include <cmath>
#include <initializer_list>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/stamp.hpp"

namespace marco {
namespace {

// The messages' constants are the enums' values, in order.
static_assert(base_command_t::KIND_SET_SPEED == static_cast<int>(BaseCommand::Kind::set_speed));
static_assert(base_command_t::KIND_VELOCITY == static_cast<int>(BaseCommand::Kind::velocity));
static_assert(base_status_t::LINK_UP == static_cast<int>(BaseStatus::Link::up));
static_assert(base_status_t::COMMAND_ABORTED == static_cast<int>(BaseStatus::Command::aborted));
static_assert(base_status_t::COMMAND_DONE == static_cast<int>(BaseStatus::Command::done));
static_assert(pantilt_command_t::KIND_GO_TO == static_cast<int>(PanTiltCommand::Kind::go_to));

void require_finite(std::initializer_list<double> values, const char* what) {
  for (const double value : values) require(std::isfinite(value), what);
}

template <class Enum>
Enum checked(int8_t value, Enum last, const char* what) {
  require(value >= 0 && value <= static_cast<int>(last), what);
  return static_cast<Enum>(value);
}

}  // namespace

base_command_t to_message(const BaseCommand& command) {
  base_command_t message{};
  message.utime = command.utime.us;
  message.id = command.id;
  message.kind = static_cast<int8_t>(command.kind);
  message.distance_m = command.distance_m;
  message.angle_rad = command.angle_rad;
  message.velocity_m_per_s = command.velocity_m_per_s;
  message.yaw_rate_rad_per_s = command.yaw_rate_rad_per_s;
  message.x_m = command.point_m.x();
  message.y_m = command.point_m.y();
  message.max_velocity_m_per_s = command.max_velocity_m_per_s;
  message.max_yaw_rate_rad_per_s = command.max_yaw_rate_rad_per_s;
  message.acceleration_m_per_s2 = command.acceleration_m_per_s2;
  return message;
}

BaseCommand from_message(const base_command_t& message) {
  require_finite(
      {message.distance_m, message.angle_rad, message.velocity_m_per_s, message.yaw_rate_rad_per_s,
       message.x_m, message.y_m, message.max_velocity_m_per_s, message.max_yaw_rate_rad_per_s,
       message.acceleration_m_per_s2},
      "base_command_t: a number is not finite");
  require(message.max_velocity_m_per_s >= 0.0 && message.max_yaw_rate_rad_per_s >= 0.0 &&
              message.acceleration_m_per_s2 >= 0.0,
          "base_command_t: a limit is below 0");
  BaseCommand command;
  command.utime = stamp_of(message.utime);
  command.id = message.id;
  command.kind =
      checked(message.kind, BaseCommand::Kind::set_speed, "base_command_t: unknown kind");
  command.distance_m = message.distance_m;
  command.angle_rad = message.angle_rad;
  command.velocity_m_per_s = message.velocity_m_per_s;
  command.yaw_rate_rad_per_s = message.yaw_rate_rad_per_s;
  command.point_m = {message.x_m, message.y_m};
  command.max_velocity_m_per_s = message.max_velocity_m_per_s;
  command.max_yaw_rate_rad_per_s = message.max_yaw_rate_rad_per_s;
  command.acceleration_m_per_s2 = message.acceleration_m_per_s2;
  return command;
}

base_status_t to_message(const BaseStatus& status) {
  base_status_t message{};
  message.utime = status.utime.us;
  message.base = status.base;
  message.link = static_cast<int8_t>(status.link);
  message.command_id = status.command_id;
  message.command = static_cast<int8_t>(status.command);
  message.motors_on = status.motors_on ? 1 : 0;
  message.battery_v = status.battery_v;
  message.num_batteries = static_cast<int32_t>(status.battery_v.size());
  for (const bool pressed : status.bumpers) message.bumpers.push_back(pressed ? 1 : 0);
  message.num_bumpers = static_cast<int32_t>(status.bumpers.size());
  message.note = status.note;
  return message;
}

BaseStatus from_message(const base_status_t& message) {
  BaseStatus status;
  status.utime = stamp_of(message.utime);
  status.base = message.base;
  status.link = checked(message.link, BaseStatus::Link::up, "base_status_t: unknown link");
  status.command_id = message.command_id;
  status.command =
      checked(message.command, BaseStatus::Command::aborted, "base_status_t: unknown command");
  status.motors_on = message.motors_on != 0;
  status.battery_v = message.battery_v;
  for (const int8_t pressed : message.bumpers) status.bumpers.push_back(pressed != 0);
  status.note = message.note;
  return status;
}

emergency_stop_t to_message(const EmergencyStop& stop) {
  emergency_stop_t message{};
  message.utime = stop.utime.us;
  message.engaged = stop.engaged ? 1 : 0;
  message.sender = stop.sender;
  message.reason = stop.reason;
  return message;
}

EmergencyStop from_message(const emergency_stop_t& message) {
  // A stop is a stop, whatever its stamp; only a release is weighed by it.
  const Utime stamp =
      message.engaged != 0 ? Utime::from_us(message.utime) : stamp_of(message.utime);
  return {stamp, message.engaged != 0, message.sender, message.reason};
}

sonar_t to_message(const SonarRing& ring) {
  sonar_t message{};
  message.utime = ring.utime.us;
  message.num_sonars = static_cast<int32_t>(ring.readings.size());
  for (const SonarReading& reading : ring.readings) {
    message.ranges_m.push_back(reading.range_m);
    message.x_m.push_back(reading.robot_from_sonar.x_m);
    message.y_m.push_back(reading.robot_from_sonar.y_m);
    message.theta_rad.push_back(reading.robot_from_sonar.theta_rad);
  }
  message.cone_rad = ring.cone_rad;
  return message;
}

SonarRing from_message(const sonar_t& message) {
  SonarRing ring;
  ring.utime = stamp_of(message.utime);
  ring.cone_rad = message.cone_rad;
  require_finite({message.cone_rad}, "sonar_t: cone_rad is not finite");
  for (std::size_t i = 0; i < message.ranges_m.size(); ++i) {
    require_finite({message.ranges_m[i], message.x_m[i], message.y_m[i], message.theta_rad[i]},
                   "sonar_t: a number is not finite");
    ring.readings.push_back(
        {message.ranges_m[i], {message.x_m[i], message.y_m[i], message.theta_rad[i]}});
  }
  return ring;
}

pantilt_command_t to_message(const PanTiltCommand& command) {
  pantilt_command_t message{};
  message.utime = command.utime.us;
  message.kind = static_cast<int8_t>(command.kind);
  message.pan_rad = command.pan_rad;
  message.tilt_rad = command.tilt_rad;
  message.pan_rate_rad_per_s = command.pan_rate_rad_per_s;
  message.tilt_rate_rad_per_s = command.tilt_rate_rad_per_s;
  return message;
}

PanTiltCommand from_message(const pantilt_command_t& message) {
  require_finite(
      {message.pan_rad, message.tilt_rad, message.pan_rate_rad_per_s, message.tilt_rate_rad_per_s},
      "pantilt_command_t: a number is not finite");
  require(message.pan_rate_rad_per_s >= 0.0 && message.tilt_rate_rad_per_s >= 0.0,
          "pantilt_command_t: a rate is below 0");
  PanTiltCommand command;
  command.utime = stamp_of(message.utime);
  command.kind =
      checked(message.kind, PanTiltCommand::Kind::go_to, "pantilt_command_t: unknown kind");
  command.pan_rad = message.pan_rad;
  command.tilt_rad = message.tilt_rad;
  command.pan_rate_rad_per_s = message.pan_rate_rad_per_s;
  command.tilt_rate_rad_per_s = message.tilt_rate_rad_per_s;
  return command;
}

gamepad_t to_message(const GamepadState& state) {
  gamepad_t message{};
  message.utime = state.utime.us;
  message.connected = state.connected ? 1 : 0;
  message.num_axes = static_cast<int32_t>(state.axes.size());
  message.axes = state.axes;
  message.num_buttons = static_cast<int32_t>(state.buttons.size());
  for (const bool pressed : state.buttons) message.buttons.push_back(pressed ? 1 : 0);
  return message;
}

GamepadState from_message(const gamepad_t& message) {
  GamepadState state;
  state.utime = stamp_of(message.utime);
  state.connected = message.connected != 0;
  for (const float axis : message.axes) {
    require(std::isfinite(axis), "gamepad_t: an axis is not finite");
  }
  state.axes = message.axes;
  for (const int8_t pressed : message.buttons) state.buttons.push_back(pressed != 0);
  return state;
}

}  // namespace marco
