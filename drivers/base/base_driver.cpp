#include "drivers/base/base_driver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lcm_tools/base/format.hpp"

namespace marco::drivers {
namespace {

using Kind = BaseCommand::Kind;
using Fate = BaseStatus::Command;

constexpr double kTellEveryS = 0.5;
constexpr double kJudgeEveryS = 0.02;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();
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
  told.note = gate_.note();
  add_words(told.note, status_.note);
  if (const std::string words = guard_.words(); !words.empty()) {
    add_words(told.note, kGuardNote + words);
  }
  return told;
}

BaseSpeeds BaseDriver::speeds() const {
  BaseSpeeds speeds = speeds_;
  speeds.velocity_m_per_s = std::min(speeds.velocity_m_per_s, leg_limit_m_per_s_);
  speeds.yaw_rate_rad_per_s =
      std::min(speeds.yaw_rate_rad_per_s, leg_limit_m_per_s_ / guard_.radius_m());
  return speeds;
}

void BaseDriver::limit_legs(double m_per_s) {
  if (std::exchange(leg_limit_m_per_s_, m_per_s) != m_per_s) speeds_changed();
}

ObstacleGuard::Drive BaseDriver::drive_of() const {
  return {dynamics(), [this](const BaseVelocity& order) { return as_driven(order); }};
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
  std::string why = gate_.why_refused(command, now);
  const bool drives = command.kind != Kind::forget_sensors && command.kind != Kind::set_speed;
  // Without a device orders are read once a second: that they are old says nothing.
  if (drives && status_.link != BaseStatus::Link::up && (why.empty() || !gate_.stopped())) {
    why = "the base does not answer";
  }
  if (!why.empty()) return answer(command, Fate::refused, why, now);
  if (command.kind == Kind::forget_sensors) {
    const std::string names = guard_.forget_sensors();
    return answer(command, Fate::done, "forgot " + (names.empty() ? "no sensor" : names), now);
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
  if (const std::string held = why_held(command, now); !held.empty()) {
    return answer(command, Fate::refused, held, now);
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

/// What fell silent while it moved must not move by itself when it is back.
std::string BaseDriver::why_held(const BaseCommand& command, Utime now) {
  guard_.note_time(now);
  const bool streams = command.kind == Kind::velocity;
  const bool rests =
      streams && command.velocity_m_per_s == 0.0 && command.yaw_rate_rad_per_s == 0.0;
  if (streams) {
    const double pause_s = (now - std::exchange(stream_.came, now)).seconds();
    if (rests || pause_s >= kOrderHoldsS) stream_.held = false;
  }
  if (rests || command.kind == Kind::stop) return "";
  const std::string silent = guard_.silent();
  if (streams && !silent.empty()) stream_.held = true;
  if (streams && stream_.held && silent.empty()) {
    return "a sensor was silent: release the stick, then order again";
  }
  return silent;
}

void BaseDriver::answer(const BaseCommand& command, Fate fate, const std::string& note, Utime now) {
  if (mode_ == Mode::idle) {
    order_.command = command;
    return finish(fate, note, now);
  }
  // Reported once; after that the status is again that of the running order.
  BaseStatus running = status_;
  status_.command_id = command.id;
  status_.command = fate;
  status_.note = note;
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
  brake(format("the driver hung for %.1f s: stopped", seconds), now);
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
    judged_ = {};
    limit_legs(kNoLimit);
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

void BaseDriver::begin_leg(Utime now) {
  const bool moves = journey_.leg.kind == Leg::Kind::move;
  const double least = moves ? kLeastMoveM : kLeastTurnRad;
  mode_ = Mode::leg;
  if (std::abs(journey_.leg.amount) < least) {
    leg_ended(true, "", now);
    return;
  }
  const ObstacleGuard::FreeWay free =
      moves ? guard_.free_move(journey_.leg.amount) : guard_.free_turn(journey_.leg.amount);
  if (std::abs(free.amount) < std::abs(journey_.leg.amount)) {
    journey_.limited = free.why;
    journey_.leg.amount = free.amount;
    if (std::abs(free.amount) < 4.0 * least) {
      return finish(journey_.on_first_leg ? Fate::refused : Fate::shortened, free.why, now);
    }
  }
  limit_legs(std::min(free.speed_limit_m_per_s, guard_.speed_limit_m_per_s()));
  start_leg(journey_.leg, now);
}

void BaseDriver::leg_ended(bool reached, const std::string& note, Utime now) {
  if (mode_ != Mode::leg) return;
  journey_.on_first_leg = false;
  if (!reached) {
    finish(Fate::aborted, note, now);
  } else if (!journey_.limited.empty()) {
    finish(Fate::shortened, journey_.limited, now);
  } else if (journey_.then_to_point) {
    journey_.then_to_point = false;
    const Eigen::Vector2d way = odom_from_robot_.inverse() * order_.command.point_m;
    journey_.leg = {Leg::Kind::move, way.x()};
    mode_ = Mode::leg_due;
  } else {
    finish(Fate::done, note, now);
  }
}

bool BaseDriver::judgement_is_due(Utime now) {
  if (std::abs((now - judged_).seconds()) < kJudgeEveryS) return false;
  judged_ = now;
  return true;
}

void BaseDriver::watch_leg(Utime now) {
  if (!judgement_is_due(now)) return;
  const double remaining = leg_remaining();
  const BaseSpeeds limits = speeds();
  const BaseVelocity speed =
      journey_.leg.kind == Leg::Kind::move
          ? BaseVelocity{std::copysign(limits.velocity_m_per_s, remaining), 0.0}
          : BaseVelocity{0.0, std::copysign(limits.yaw_rate_rad_per_s, remaining)};
  std::string why = guard_.why_end_leg(speed, remaining, drive_of());
  if (guard_.speed_limit_m_per_s() < leg_limit_m_per_s_) why = guard_.words();
  guard_.on_sent(speed);
  if (!why.empty()) request_stop(Fate::shortened, why, now);
}

void BaseDriver::watch_velocity(Utime now) {
  if ((now - order_.newest_came).seconds() > kOrderHoldsS) {
    request_stop(Fate::done, "no velocity came for 0.5 s", now);
    return;
  }
  const auto within = [](double value, double most) { return std::clamp(value, -most, most); };
  const BaseVelocity order{within(order_.command.velocity_m_per_s, speeds_.velocity_m_per_s),
                           within(order_.command.yaw_rate_rad_per_s, speeds_.yaw_rate_rad_per_s)};
  if (judgement_is_due(now)) verdict_ = guard_.judge(order, drive_of());
  if (verdict_.why != status_.note) {
    status_.note = verdict_.why;
    tell(now);
  }
  guard_.on_sent(as_driven(verdict_.velocity));
  drive(verdict_.velocity.ahead_m_per_s, verdict_.velocity.turn_rad_per_s, now);
}

void BaseDriver::watch_sensors(Utime now) {
  const std::string silent = guard_.silent();
  if (silent.empty() || mode_ == Mode::idle || mode_ == Mode::stopping) return;
  const BaseCommand& order = order_.command;
  stream_.held =
      mode_ == Mode::velocity && (order.velocity_m_per_s != 0.0 || order.yaw_rate_rad_per_s != 0.0);
  request_stop(Fate::aborted, silent, now);
  if (mode_ != Mode::stopping) return;
  status_.note = silent;  // not only when it stands
  tell(now);
}

void BaseDriver::advance_motion(Utime now) {
  guard_.note_time(now);
  if (status_.link == BaseStatus::Link::up) {
    watch_sensors(now);
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
  guard_.on_sent({});
  stop_wheels(now);
}

void BaseDriver::stopped(Utime now) {
  if (mode_ != Mode::stopping) return;
  finish(after_stop_.fate, after_stop_.note, now);
  if (const auto next = std::exchange(next_order_, std::nullopt)) begin(*next, now);
}

void BaseDriver::finish(BaseStatus::Command fate, const std::string& note, Utime now) {
  mode_ = Mode::idle;
  guard_.on_rest();
  status_.command_id = order_.command.id;
  status_.command = fate;
  status_.note = note;
  tell(now);
}

void BaseDriver::publish_odometry(const OdometrySample& sample) {
  odom_from_robot_ = sample.odom_from_robot;
  guard_.on_odometry(sample);
  output_.odometry.push_back(sample);
}

}  // namespace marco::drivers
