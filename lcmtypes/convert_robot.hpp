#pragma once

#include "common/robot_values.hpp"
#include "marco/base_command_t.hpp"
#include "marco/base_status_t.hpp"
#include "marco/emergency_stop_t.hpp"
#include "marco/gamepad_t.hpp"
#include "marco/pantilt_command_t.hpp"
#include "marco/sonar_t.hpp"

/// Message <-> value: orders to a robot and its reports; the rest is in convert.hpp.
/// from_message throws std::invalid_argument, naming the cause, when a message holds a number that
/// is not finite or an unknown kind.
namespace marco {

base_command_t to_message(const BaseCommand& command);
BaseCommand from_message(const base_command_t& message);

base_status_t to_message(const BaseStatus& status);
BaseStatus from_message(const base_status_t& message);

emergency_stop_t to_message(const EmergencyStop& stop);
EmergencyStop from_message(const emergency_stop_t& message);

sonar_t to_message(const SonarRing& ring);
SonarRing from_message(const sonar_t& message);

pantilt_command_t to_message(const PanTiltCommand& command);
PanTiltCommand from_message(const pantilt_command_t& message);

gamepad_t to_message(const GamepadState& state);
GamepadState from_message(const gamepad_t& message);

}  // namespace marco
