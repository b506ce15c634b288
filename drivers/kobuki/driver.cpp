#include "drivers/kobuki/driver.hpp"

#include <algorithm>

#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::kobuki {
namespace {

using Link = BaseStatus::Link;

constexpr double kSilentS = 0.5;
constexpr double kAskEveryS = 1.0;
// Frames come every 20 ms, several at once where the cable's converter collects them. When the
// robot's clock steps by more than this, it was switched off and on.
constexpr double kLongestStepS = 1.0;

void append(std::vector<uint8_t>& out, const Bytes& bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

const KobukiOptions& checked(const KobukiOptions& options) {
  validate(options, "kobuki");
  return options;
}

}  // namespace

KobukiBase::KobukiBase(const KobukiOptions& options)
    : BaseDriver("kobuki", options.speeds, options.guard),
      options_(checked(options)),
      odometry_(1.0 / options.ticks_per_m, options.track_m),
      counters_(1.0 / options.ticks_per_m),
      plan_(1.0 / options.ticks_per_m, options.track_m) {
  KobukiBase::speeds_changed();
}

void KobukiBase::on_connection(bool connected, Utime now) {
  connected_ = connected;
  parser_.clear();
  begin_session(now);
  set_link(Link::down, connected ? "waiting for the robot" : "the line is gone", now);
}

void KobukiBase::begin_session(Utime now) {
  speaks_ = frame_came_ = false;
  next_ask_ = understood_ = now;
  last_clock_ms_.reset();
  clock_.reset();
  counters_.forget();
  odometry_.forget_stamps();
  plan_.stand();
}

void KobukiBase::receive(std::span<const uint8_t> bytes, Utime now) {
  parser_.push(bytes);
  while (const auto received = parser_.next()) {
    if (const auto feedback = decode_feedback(received->payload)) {
      on_feedback(*feedback, now - line_time(received->bytes_after, kBaud));
    } else {
      ++undecodable_;
    }
  }
}

void KobukiBase::on_feedback(const Feedback& feedback, Utime left) {
  understood_ = left;
  speaks_ = frame_came_ = true;
  if (feedback.firmware) {
    const auto& [major, minor, patch] = *feedback.firmware;
    firmware_ = ", firmware " + std::to_string(major) + "." + std::to_string(minor) + "." +
                std::to_string(patch);
    if (status().link == Link::up) set_link(Link::up, "Kobuki" + firmware_, left);
  }
  const double step_s = tell_time(feedback);
  const Utime when = clock_.update(robot_s_, left);
  const Pose2 before = odom_from_robot();
  const auto step = counters_.count(feedback.left_ticks, feedback.right_ticks, step_s);
  const bool moved = step.left_clicks != 0.0 || step.right_clicks != 0.0;
  publish_odometry(odometry_.count(step, when));
  publish_gyro(feedback, when);
  plan_.note_motion(moved);
  judge_bumpers(feedback, left);
  judge_link(feedback, left);
  if (const auto end = plan_.follow(before, odom_from_robot(), moved, left)) {
    leg_ended(end->reached, end->why_not, left);
  }
}

double KobukiBase::tell_time(const Feedback& feedback) {
  const auto since_ms =
      static_cast<uint16_t>(feedback.clock_ms - last_clock_ms_.value_or(feedback.clock_ms));
  last_clock_ms_ = feedback.clock_ms;
  const double step_s = 1e-3 * since_ms;
  if (step_s > kLongestStepS) {
    clock_.reset();
    counters_.forget();
    return kFrameS;
  }
  robot_s_ += step_s;
  return std::max(step_s, kFrameS);
}

// The gyro is turned by a quarter: its x points left, its y backwards.
void KobukiBase::publish_gyro(const Feedback& feedback, Utime when) {
  ImuSample sample{when};
  sample.angular_velocity_rad_per_s.z() = deg_to_rad(0.01 * feedback.rate_cdeg_per_s);
  if (!feedback.gyro.empty()) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& [x, y, z] : feedback.gyro) mean += Eigen::Vector3d(-y, x, z);
    mean /= static_cast<double>(feedback.gyro.size());
    sample.angular_velocity_rad_per_s = deg_to_rad(kGyroDegPerS) * mean;
  }
  output().imu.push_back(sample);
}

void KobukiBase::judge_bumpers(const Feedback& feedback, Utime now) {
  const std::vector<bool> bumpers{(feedback.bumpers & kLeft) != 0,
                                  (feedback.bumpers & kCentre) != 0,
                                  (feedback.bumpers & kRight) != 0};
  std::vector<int> pressed;
  for (std::size_t i = 0; i < bumpers.size(); ++i) {
    if (bumpers[i]) pressed.push_back(static_cast<int>(i) + 1);
  }
  guard().on_bumpers(pressed, {});
  if (!pressed.empty() && plan_.velocity_m_per_s() > 0.0) {  // a ramp would push on
    plan_.cut_velocity();
    next_motion_ = now;
  }
  edit_status().battery_v = {0.1 * feedback.decivolts};
  const bool news = bumpers != edit_status().bumpers;
  edit_status().bumpers = bumpers;
  if (news) tell(now);
}

std::string KobukiBase::why_unsafe(const Feedback& feedback) {
  if (feedback.hanging_wheels != 0) return "a wheel hangs: is the robot lifted?";
  if (feedback.cliffs != 0) return "there is a cliff in front of it: push it back";
  return feedback.on_cable() ? "it charges by its cable: take that out" : "";
}

// Nothing that was ordered before resumes.
void KobukiBase::judge_link(const Feedback& feedback, Utime now) {
  const std::string why_not = why_unsafe(feedback);
  edit_status().motors_on = why_not.empty();
  if (!why_not.empty()) {
    if (status().link == Link::starting && status().note == why_not) return;
    plan_.stand();
    next_motion_ = now;
    set_link(Link::starting, why_not, now);
  } else if (status().link != Link::up) {
    plan_.stand();
    set_link(Link::up, "Kobuki" + firmware_, now);
  }
}

void KobukiBase::start_leg(const Leg& leg, Utime now) {
  plan_.start_leg(leg, odom_from_robot(), now);
}

void KobukiBase::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime /*now*/) {
  plan_.drive(velocity_m_per_s, yaw_rate_rad_per_s);
}

void KobukiBase::emergency_brake(Utime now) {
  plan_.stop();
  plan_.halt();
  next_motion_ = now;
}

// An order for every frame: the robot may wait for them.
void KobukiBase::send_motion(Utime now, std::vector<uint8_t>& out) {
  if (!speaks_) return;
  const bool due = now >= next_motion_;
  if (due) {
    next_motion_ = now + Duration::from_seconds(WheelPlan::kStepS);
    if (status().link == Link::up) {
      plan_.step(odom_from_robot());
    } else {
      plan_.halt();
    }
  }
  if (!due && !frame_came_) return;
  frame_came_ = false;
  const double left = plan_.left_m_per_s(), right = plan_.right_m_per_s();
  append(out, velocity_request((left + right) / 2.0, (right - left) / options_.track_m));
}

void KobukiBase::advance(Utime now, std::vector<uint8_t>& out) {
  if (!connected_) return;
  if (speaks_ && (now - understood_).seconds() > kSilentS) {
    begin_session(now);
    append(out, velocity_request(0.0, 0.0));  // perhaps it still hears us
    set_link(Link::down, "the robot is silent: is it switched on?", now);
  }
  if (speaks_ && firmware_.empty() && now >= next_ask_) {
    next_ask_ = now + Duration::from_seconds(kAskEveryS);
    append(out, version_request());
  }
  advance_motion(now);
  if (plan_.came_to_stand()) stopped(now);
  send_motion(now, out);
}

// The zeros end a frame that was sent in part.
std::vector<uint8_t> KobukiBase::stop_bytes() const {
  std::vector<uint8_t> bytes(velocity_request(0.0, 0.0).size(), 0);
  append(bytes, velocity_request(0.0, 0.0));
  return bytes;
}

}  // namespace marco::drivers::kobuki
