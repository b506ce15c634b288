#include "simulator/devices/p2os/emulated_drive.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/base/arc.hpp"
#include "simulator/devices/p2os/camera_head.hpp"

namespace marco::drivers::p2os {
namespace {

bool ends_stall(CommandId id) {
  using enum CommandId;
  return id == move || id == velocity || id == heading || id == turn_by || id == wheel_velocities ||
         id == stop || id == emergency_stop;
}

}  // namespace

EmulatedDrive::EmulatedDrive(const P2osEmulatorOptions& options) : options_(options) { reset(); }

void EmulatedDrive::reset() {
  const double acceleration = options_.default_acceleration_m_per_s2;
  const double rate_acceleration = deg_to_rad(options_.default_rate_acceleration_deg_per_s2);
  velocity_ = {options_.default_velocity_m_per_s, acceleration, acceleration};
  rate_ = {deg_to_rad(options_.default_rate_deg_per_s), rate_acceleration, rate_acceleration};
  drop_goals();
  reckoned_ = {};
  motors_on_ = stalled_ = false;
}

void EmulatedDrive::release() {
  motors_on_ = false;
  halt();
}

void EmulatedDrive::brake() {
  velocity_.goal = rate_.goal = 0.0;
  drop_goals();
}

void EmulatedDrive::halt() {
  velocity_.speed = velocity_.goal = 0.0;
  rate_.speed = rate_.goal = 0.0;
}

void EmulatedDrive::drop_goals() {
  way_left_m_.reset();
  heading_goal_.reset();
}

void EmulatedDrive::execute(const Command& command) {
  const int value = command.value.value_or(0);
  if (ends_stall(command.id)) stalled_ = false;
  switch (command.id) {
    case CommandId::enable:
      motors_on_ = value != 0;
      break;
    case CommandId::set_max_velocity:
      velocity_.limit = std::min(std::abs(value) * 1e-3, options_.max_velocity_m_per_s);
      break;
    case CommandId::set_max_rate:
      rate_.limit = deg_to_rad(std::abs(value));
      break;
    case CommandId::set_acceleration:
      velocity_.set_acceleration(value * 1e-3);
      break;
    case CommandId::set_rotation_acceleration:
      rate_.set_acceleration(value * deg_to_rad(1.0));
      break;
    case CommandId::set_origin:
      reckoned_ = {};
      heading_goal_.reset();
      break;
    case CommandId::move:
      way_left_m_ = value * 1e-3;
      break;
    case CommandId::velocity:
      drop_goals();
      velocity_.goal = value * 1e-3;
      break;
    case CommandId::rotate:
    case CommandId::rotation_velocity:
      heading_goal_.reset();
      rate_.goal = deg_to_rad(value);
      break;
    case CommandId::heading:
      heading_goal_ = deg_to_rad(value);
      break;
    case CommandId::turn_by:
      heading_goal_ = normalize_angle(reckoned_.theta_rad + deg_to_rad(value));
      break;
    case CommandId::wheel_velocities:
      set_wheel_velocities(value);
      break;
    case CommandId::stop:
      brake();
      break;
    case CommandId::emergency_stop:
      drop_goals();
      halt();
      break;
    default:
      break;
  }
}

void EmulatedDrive::set_wheel_velocities(int bytes) {
  drop_goals();
  const double right = static_cast<int8_t>(bytes & 0xFF) * 0.020;
  const double left = static_cast<int8_t>(bytes >> 8 & 0xFF) * 0.020;
  velocity_.goal = (left + right) / 2.0;
  rate_.goal = (right - left) / options_.track_m;
}

double EmulatedDrive::to_heading() const {
  return normalize_angle(*heading_goal_ - reckoned_.theta_rad);
}

void EmulatedDrive::step(double dt_s, bool blocked) {
  if (blocked && !stalled_ && (velocity_.speed != 0.0 || rate_.speed != 0.0)) {
    stalled_ = true;
    halt();
    drop_goals();
  }
  if (motors_on_) {
    velocity_.step(way_left_m_, dt_s);
    rate_.step(heading_goal_ ? std::optional(to_heading()) : std::nullopt, dt_s);
  } else {
    velocity_.speed = rate_.speed = 0.0;
  }
  double way_m = velocity_.speed * dt_s, turn_rad = rate_.speed * dt_s;
  if (way_left_m_) {
    if (std::abs(way_m) >= std::abs(*way_left_m_) || std::abs(*way_left_m_) < 5e-4) {
      way_m = *way_left_m_;
      way_left_m_.reset();
      velocity_.speed = velocity_.goal = 0.0;
    } else {
      *way_left_m_ -= way_m;
    }
  }
  if (heading_goal_) {
    const double left = to_heading();
    if (std::abs(turn_rad) >= std::abs(left) || std::abs(left) < 1e-3) {
      turn_rad = left;
      heading_goal_.reset();
      rate_.speed = rate_.goal = 0.0;
    }
  }
  left_m_ += way_m - turn_rad * options_.track_m / 2.0;
  right_m_ += way_m + turn_rad * options_.track_m / 2.0;
  reckoned_ = reckoned_ * along_arc(way_m, turn_rad);
}

}  // namespace marco::drivers::p2os
