#include "lcmtypes/convert_robot.hpp"

#include <cmath>
#include <initializer_list>
#include <type_traits>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/field_copy.hpp"

namespace marco {
namespace {

// The messages' constants are the enums' values, in order.
static_assert(base_command_t::KIND_FORGET_SENSORS ==
              static_cast<int>(BaseCommand::Kind::forget_sensors));
static_assert(base_command_t::KIND_VELOCITY == static_cast<int>(BaseCommand::Kind::velocity));
static_assert(base_status_t::LINK_UP == static_cast<int>(BaseStatus::Link::up));
static_assert(base_status_t::COMMAND_ABORTED == static_cast<int>(BaseStatus::Command::aborted));
static_assert(base_status_t::COMMAND_DONE == static_cast<int>(BaseStatus::Command::done));
static_assert(pantilt_command_t::KIND_GO_TO == static_cast<int>(PanTiltCommand::Kind::go_to));

// A visitor of the lists of fields below.
struct RequireFinite {
  const char* what;
  template <class Value, class Field>
  void operator()(const Value& value, const Field& /*field*/) const {
    if constexpr (std::is_floating_point_v<Value>) require(std::isfinite(value), what);
  }
};

void require_finite(std::initializer_list<double> values, const char* what) {
  for (const double value : values) require(std::isfinite(value), what);
}

template <class Enum>
Enum checked(int8_t value, Enum last, const char* what) {
  require(value >= 0 && value <= static_cast<int>(last), what);
  return static_cast<Enum>(value);
}

constexpr auto kBaseCommandFields = [](auto copy, auto& command, auto& message) {
  copy(command.id, message.id);
  copy(command.distance_m, message.distance_m);
  copy(command.angle_rad, message.angle_rad);
  copy(command.velocity_m_per_s, message.velocity_m_per_s);
  copy(command.yaw_rate_rad_per_s, message.yaw_rate_rad_per_s);
  copy(command.point_m.x(), message.x_m);
  copy(command.point_m.y(), message.y_m);
  copy(command.max_velocity_m_per_s, message.max_velocity_m_per_s);
  copy(command.max_yaw_rate_rad_per_s, message.max_yaw_rate_rad_per_s);
  copy(command.acceleration_m_per_s2, message.acceleration_m_per_s2);
};

constexpr auto kBaseStatusFields = [](auto copy, auto& status, auto& message) {
  copy(status.base, message.base);
  copy(status.command_id, message.command_id);
  copy(status.battery_v, message.battery_v);
  copy(status.note, message.note);
};

constexpr auto kPanTiltCommandFields = [](auto copy, auto& command, auto& message) {
  copy(command.pan_rad, message.pan_rad);
  copy(command.tilt_rad, message.tilt_rad);
  copy(command.pan_rate_rad_per_s, message.pan_rate_rad_per_s);
  copy(command.tilt_rate_rad_per_s, message.tilt_rate_rad_per_s);
};

std::vector<int8_t> bytes_of(const std::vector<bool>& flags) {
  return {flags.begin(), flags.end()};
}
std::vector<bool> flags_of(const std::vector<int8_t>& bytes) {
  std::vector<bool> flags;
  flags.reserve(bytes.size());
  for (const int8_t byte : bytes) flags.push_back(byte != 0);
  return flags;
}

}  // namespace

base_command_t to_message(const BaseCommand& command) {
  auto message = message_of<base_command_t>(command, kBaseCommandFields);
  message.kind = static_cast<int8_t>(command.kind);
  return message;
}

BaseCommand from_message(const base_command_t& message) {
  auto command = value_of<BaseCommand>(message, kBaseCommandFields);
  command.kind =
      checked(message.kind, BaseCommand::Kind::forget_sensors, "base_command_t: unknown kind");
  kBaseCommandFields(RequireFinite{"base_command_t: a number is not finite"}, command, message);
  require(message.max_velocity_m_per_s >= 0.0 && message.max_yaw_rate_rad_per_s >= 0.0 &&
              message.acceleration_m_per_s2 >= 0.0,
          "base_command_t: a limit is below 0");
  return command;
}

base_status_t to_message(const BaseStatus& status) {
  auto message = message_of<base_status_t>(status, kBaseStatusFields);
  message.link = static_cast<int8_t>(status.link);
  message.command = static_cast<int8_t>(status.command);
  message.motors_on = status.motors_on ? 1 : 0;
  message.num_batteries = static_cast<int32_t>(status.battery_v.size());
  message.bumpers = bytes_of(status.bumpers);
  message.num_bumpers = static_cast<int32_t>(status.bumpers.size());
  return message;
}

BaseStatus from_message(const base_status_t& message) {
  auto status = value_of<BaseStatus>(message, kBaseStatusFields);
  status.link = checked(message.link, BaseStatus::Link::up, "base_status_t: unknown link");
  status.command =
      checked(message.command, BaseStatus::Command::aborted, "base_status_t: unknown command");
  status.motors_on = message.motors_on != 0;
  status.bumpers = flags_of(message.bumpers);
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
  // A stop holds whatever its stamp says; only a release needs a valid one.
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
  auto message = message_of<pantilt_command_t>(command, kPanTiltCommandFields);
  message.kind = static_cast<int8_t>(command.kind);
  return message;
}

PanTiltCommand from_message(const pantilt_command_t& message) {
  auto command = value_of<PanTiltCommand>(message, kPanTiltCommandFields);
  command.kind =
      checked(message.kind, PanTiltCommand::Kind::go_to, "pantilt_command_t: unknown kind");
  kPanTiltCommandFields(RequireFinite{"pantilt_command_t: a number is not finite"}, command,
                        message);
  require(message.pan_rate_rad_per_s >= 0.0 && message.tilt_rate_rad_per_s >= 0.0,
          "pantilt_command_t: a rate is below 0");
  return command;
}

gamepad_t to_message(const GamepadState& state) {
  gamepad_t message{};
  message.utime = state.utime.us;
  message.connected = state.connected ? 1 : 0;
  message.num_axes = static_cast<int32_t>(state.axes.size());
  message.axes = state.axes;
  message.num_buttons = static_cast<int32_t>(state.buttons.size());
  message.buttons = bytes_of(state.buttons);
  return message;
}

GamepadState from_message(const gamepad_t& message) {
  for (const float axis : message.axes) {
    require(std::isfinite(axis), "gamepad_t: an axis is not finite");
  }
  return {stamp_of(message.utime), message.connected != 0, message.axes, flags_of(message.buttons)};
}

}  // namespace marco
