#include "drivers/base/base_driver.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

namespace marco::drivers {
namespace {

using Kind = BaseCommand::Kind;
using Fate = BaseStatus::Command;

constexpr double kTellEveryS = 0.5;
constexpr const char* kObstacle = "an obstacle is in the way";
constexpr double kLeastMoveM = 0.005;
constexpr double kLeastTurnRad = deg_to_rad(0.3);

}  // namespace

BaseDriver::BaseDriver(std::string name, const BaseSpeeds& speeds, const GuardOptions& guard)
    : speeds_(speeds), guard_(guard) {
  validate(speeds, "speeds");
  status_.base = std::move(name);
}

BaseOutput BaseDriver::take_output() { return std::exchange(output_, {}); }

BaseStatus BaseDriver::status() const {
  BaseStatus told = status_;
  if (!gate_.stopped()) return told;
  told.note = gate_.note() + (status_.note.empty() ? "" : "; " + status_.note);
  return told;
}

std::string BaseDriver::state() const {
  static constexpr const char* kLinks[] = {"does not answer", "is being set up", "ready"};
  static constexpr const char* kFates[] = {"",          ", moving", ", done", ", stopped short",
                                           ", refused", ", aborted"};
  std::string text = status_.base + std::string(" ") + kLinks[static_cast<int>(status_.link)] +
                     kFates[static_cast<int>(status_.command)];
  if (const std::string note = status().note; !note.empty()) text += ": " + note;
  return text;
}

void BaseDriver::tell(Utime now) {
  status_.utime = now;
  last_told_ = now;
  output_.status.push_back(status());
}

void BaseDriver::set_link(BaseStatus::Link link, const std::string& note, Utime now) {
  if (status_.link == link && status_.note == note) return;
  status_.link = link;
  status_.note = note;
  if (link != BaseStatus::Link::up) {
    status_.motors_on = false;
    next_order_.reset();
    if (mode_ != Mode::idle) {
      finish(Fate::aborted, note, now);
      return;
    }
  }
  tell(now);
}

void BaseDriver::command(const BaseCommand& command, Utime now) {
  if (const std::string why = gate_.why_refused(command, now); !why.empty()) {
    return refuse(command, why, now);
  }
  if (command.kind == Kind::set_speed) {
    const auto take = [](double given, double& kept) {
      if (given > 0.0) kept = given;
    };
    take(command.max_velocity_m_per_s, speeds_.velocity_m_per_s);
    take(command.max_yaw_rate_rad_per_s, speeds_.yaw_rate_rad_per_s);
    take(command.acceleration_m_per_s2, speeds_.acceleration_m_per_s2);
    speeds_changed();
    if (mode_ != Mode::idle) return;  // the status remains that of the running order
    order_.command = command;
    finish(Fate::done, "", now);
    return;
  }
  if (status_.link != BaseStatus::Link::up) {
    return refuse(command, "the base does not answer", now);
  }
  order_.newest_came = now;
  if (mode_ == Mode::idle) {
    begin(command, now);
  } else if (mode_ == Mode::velocity && command.kind == Kind::velocity) {
    order_.command = command;
    status_.command_id = command.id;
  } else {
    next_order_ = command;
    request_stop(Fate::aborted, "a newer order came", now);
  }
}

void BaseDriver::refuse(const BaseCommand& command, const std::string& why, Utime now) {
  if (mode_ == Mode::idle) {
    order_.command = command;
    return finish(Fate::refused, why, now);
  }
  // Reported once; after that the status is again that of the running order.
  BaseStatus running = status_;
  status_.command_id = command.id;
  status_.command = Fate::refused;
  status_.note = why;
  tell(now);
  status_ = std::move(running);
}

void BaseDriver::emergency_stop(const EmergencyStop& message, Utime now) {
  const bool was_stopped = gate_.stopped();
  if (!gate_.on_emergency_stop(message, now)) return;
  if (gate_.stopped() && !was_stopped) {
    status_.note.clear();
    brake("", now);
  } else if (!gate_.stopped()) {
    status_.note = "the emergency stop was released";
  }
  tell(now);
}

// Even when nothing was ordered: something else may turn the wheels.
void BaseDriver::brake(const std::string& note, Utime now) {
  next_order_.reset();
  if (status_.link != BaseStatus::Link::up) return;
  status_.note = note;
  after_stop_ = {mode_ == Mode::idle ? status_.command : Fate::aborted, note};
  mode_ = Mode::stopping;
  emergency_brake(now);
}

void BaseDriver::on_hang(double seconds, Utime now) {
  char text[64];
  std::snprintf(text, sizeof text, "the driver hung for %.1f s: stopped", seconds);
  brake(text, now);
  tell(now);
}

void BaseDriver::shut_down(std::vector<uint8_t>& out) {
  const std::vector<uint8_t> bytes = stop_bytes();
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void BaseDriver::begin(const BaseCommand& command, Utime now) {
  order_.command = command;
  status_.command_id = command.id;
  status_.command = Fate::running;
  status_.note.clear();
  journey_ = {};
  mode_ = Mode::leg_due;
  if (command.kind == Kind::stop) {
    request_stop(Fate::done, "", now);
  } else if (command.kind == Kind::velocity) {
    mode_ = Mode::velocity;
  } else if (command.kind == Kind::move) {
    journey_.leg = {Leg::Kind::move, command.distance_m};
  } else if (command.kind == Kind::turn) {
    journey_.leg = {Leg::Kind::turn, command.angle_rad};
  } else {
    const Eigen::Vector2d way = odom_from_robot_.inverse() * command.point_m;
    journey_.leg = {Leg::Kind::turn, way.norm() > kLeastMoveM ? std::atan2(way.y(), way.x()) : 0.0};
    journey_.then_to_point = true;
  }
  tell(now);
}

double BaseDriver::free_part(const Leg& leg, Utime now) const {
  return leg.kind == Leg::Kind::move ? guard_.free_move_m(leg.amount, odom_from_robot_, now)
                                     : guard_.free_turn_rad(leg.amount, odom_from_robot_, now);
}

std::string BaseDriver::pressed_bumpers_or(const char* otherwise) const {
  const bool moves = journey_.leg.kind == Leg::Kind::move;
  const std::string bumpers = moves ? guard_.pressed_bumpers(journey_.leg.amount) : "";
  return bumpers.empty() ? otherwise : bumpers;
}

void BaseDriver::begin_leg(Utime now) {
  const double least = journey_.leg.kind == Leg::Kind::move ? kLeastMoveM : kLeastTurnRad;
  mode_ = Mode::leg;
  if (std::abs(journey_.leg.amount) < least) {
    leg_ended(true, "", now);
    return;
  }
  const double free = free_part(journey_.leg, now);
  if (std::abs(free) < std::abs(journey_.leg.amount)) {
    journey_.limited = true;
    journey_.leg.amount = std::copysign(free, journey_.leg.amount);
    if (std::abs(free) < 4.0 * least) {
      finish(journey_.on_first_leg ? Fate::refused : Fate::shortened, pressed_bumpers_or(kObstacle),
             now);
      return;
    }
  }
  start_leg(journey_.leg, now);
}

void BaseDriver::leg_ended(bool reached, const std::string& note, Utime now) {
  if (mode_ != Mode::leg) return;
  journey_.on_first_leg = false;
  if (!reached) {
    finish(Fate::aborted, note, now);
  } else if (journey_.limited) {
    finish(Fate::shortened, pressed_bumpers_or(kObstacle), now);
  } else if (journey_.then_to_point) {
    journey_.then_to_point = false;
    const Eigen::Vector2d way = odom_from_robot_.inverse() * order_.command.point_m;
    journey_.leg = {Leg::Kind::move, way.x()};
    mode_ = Mode::leg_due;
  } else {
    finish(Fate::done, note, now);
  }
}

void BaseDriver::watch_leg(Utime now) {
  const double remaining = leg_remaining();
  const double free = free_part({journey_.leg.kind, remaining}, now);
  if (std::abs(free) >= std::abs(remaining) - (journey_.leg.kind == Leg::Kind::move ? 0.02 : 0.03))
    return;
  // The way is blocked before the leg's end: brake at the last moment that is early enough.
  const double to_stop = journey_.leg.kind == Leg::Kind::move ? stop_distance_m() : 0.05;
  if (std::abs(free) <= to_stop) {
    request_stop(Fate::shortened, pressed_bumpers_or("an obstacle came into the way"), now);
  }
}

void BaseDriver::watch_velocity(Utime now) {
  if ((now - order_.newest_came).seconds() > kOrderHoldsS) {
    request_stop(Fate::done, "no velocity came for 0.5 s", now);
    return;
  }
  double v = order_.command.velocity_m_per_s, w = order_.command.yaw_rate_rad_per_s;
  std::string note;
  if (v != 0.0) {
    // No faster than can be braked in the room there is.
    const double free = std::abs(guard_.free_move_m(std::copysign(1.5, v), odom_from_robot_, now));
    const double allowed =
        free < 1.5 ? std::sqrt(speeds_.acceleration_m_per_s2 * std::max(0.0, free - 0.02))
                   : std::abs(v);
    if (allowed < std::abs(v)) {
      v = allowed < 0.03 ? 0.0 : std::copysign(allowed, v);
      note = "slowed down before an obstacle";
    }
  }
  if (w != 0.0 &&
      std::abs(guard_.free_turn_rad(std::copysign(0.1, w), odom_from_robot_, now)) < 0.05) {
    w = 0.0;
    note = "no room to turn";
  }
  if (note != status_.note) {
    status_.note = note;
    tell(now);
  }
  drive(v, w, now);
}

void BaseDriver::advance_motion(Utime now) {
  if (status_.link == BaseStatus::Link::up) {
    if (mode_ == Mode::leg_due) begin_leg(now);
    if (mode_ == Mode::leg) watch_leg(now);
    if (mode_ == Mode::velocity) watch_velocity(now);
  }
  if ((now - last_told_).seconds() >= kTellEveryS) tell(now);
}

void BaseDriver::request_stop(BaseStatus::Command fate, const std::string& note, Utime now) {
  after_stop_ = {fate, note};
  if (mode_ == Mode::stopping) return;
  mode_ = Mode::stopping;
  stop_wheels(now);
}

void BaseDriver::stopped(Utime now) {
  if (mode_ != Mode::stopping) return;
  finish(after_stop_.fate, after_stop_.note, now);
  if (const auto next = std::exchange(next_order_, std::nullopt)) begin(*next, now);
}

void BaseDriver::finish(BaseStatus::Command fate, const std::string& note, Utime now) {
  mode_ = Mode::idle;
  status_.command_id = order_.command.id;
  status_.command = fate;
  status_.note = note;
  tell(now);
}

void BaseDriver::publish_odometry(const OdometrySample& sample) {
  odom_from_robot_ = sample.odom_from_robot;
  output_.odometry.push_back(sample);
}

}  // namespace marco::drivers
