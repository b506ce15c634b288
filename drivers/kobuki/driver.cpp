#include "drivers/kobuki/driver.hpp"

#include <algorithm>

#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::kobuki {
namespace {

using Link = BaseStatus::Link;

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
    : DifferentialBase("kobuki",
                       options.speeds,
                       options.guard,
                       1.0 / options.ticks_per_m,
                       checked(options).track_m),
      counters_(tick_m()) {}

void KobukiBase::on_connection(bool connected, Utime now) {
  parser_.clear();
  start_session(now);
  note_line(connected, "the robot", now);
}

void KobukiBase::start_session(Utime now) {
  begin_session(now);
  speaks_ = frame_came_ = false;
  last_clock_ms_.reset();
  clock_.reset();
  counters_.forget();
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
  note_sign_of_life(left);
  speaks_ = frame_came_ = true;
  if (feedback.firmware) {
    const auto& [major, minor, patch] = *feedback.firmware;
    firmware_ = ", firmware " + std::to_string(major) + "." + std::to_string(minor) + "." +
                std::to_string(patch);
    if (status().link == Link::up) set_link(Link::up, "Kobuki" + firmware_, left);
  }
  count(feedback, left);
  judge(feedback, left);
  follow_leg(left);
}

void KobukiBase::count(const Feedback& feedback, Utime left) {
  const double step_s = tell_time(feedback);
  const Utime when = clock_.update(robot_s_, left);
  turned(counters_.count(feedback.left_ticks, feedback.right_ticks, step_s), when, left);
  publish_gyro(feedback, when);
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

std::string KobukiBase::why_unsafe(const Feedback& feedback) {
  if (feedback.hanging_wheels != 0) return "a wheel hangs: is the robot lifted?";
  if (feedback.cliffs != 0) return "there is a cliff in front of it: push it back";
  return feedback.on_cable() ? "it charges by its cable: take that out" : "";
}

void KobukiBase::judge(const Feedback& feedback, Utime now) {
  edit_status().battery_v = {0.1 * feedback.decivolts};
  const auto pressed = [&feedback](uint8_t bit) { return (feedback.bumpers & bit) != 0; };
  if (touched({pressed(kLeft), pressed(kCentre), pressed(kRight)}, now)) tell(now);
  if (judge_link(why_unsafe(feedback), "Kobuki" + firmware_, now)) send_at_once(now);
}

// An order for every frame: the robot may wait for them.
void KobukiBase::send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>& out) {
  if (!due && !frame_came_) return;
  frame_came_ = false;
  const double left = speeds.left_m_per_s, right = speeds.right_m_per_s;
  append(out, velocity_request((left + right) / 2.0, (right - left) / track_m()));
}

void KobukiBase::keep_link(Utime now, std::vector<uint8_t>& out) {
  if (speaks_ && silent_for(kSilentS, now)) {
    start_session(now);
    append(out, velocity_request(0.0, 0.0));  // it may still receive
    set_link(Link::down, "the robot is silent: is it switched on?", now);
  }
  if (speaks_ && firmware_.empty() && ask_is_due(kAskEveryS, now)) append(out, version_request());
}

// The zeros end a frame that was sent in part.
std::vector<uint8_t> KobukiBase::stop_bytes() const {
  std::vector<uint8_t> bytes(velocity_request(0.0, 0.0).size(), 0);
  append(bytes, velocity_request(0.0, 0.0));
  return bytes;
}

}  // namespace marco::drivers::kobuki
