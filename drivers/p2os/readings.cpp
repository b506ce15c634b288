// What the driver makes of an information packet.
#include <algorithm>
#include <cmath>

#include "drivers/p2os/driver.hpp"

namespace marco::drivers::p2os {
namespace {

using Link = BaseStatus::Link;

constexpr double kNoEchoM = 5.0;
constexpr double kSonarTellS = 0.4;  // a round of sixteen at four a packet
/// Fifteen bits, unwrapped.
int difference(uint16_t now, uint16_t before) {
  const int d = (now - before) & 0x7FFF;
  return d >= 0x4000 ? d - 0x8000 : d;
}

}  // namespace

void P2osBase::on_sip(const Sip& sip, Utime measured, Utime now) {
  reckon(sip, measured);
  edit_status().motors_on = (sip.flags & 1) != 0;
  edit_status().battery_v = {sip.battery / 10.0};
  if (options_.sonar) read_sonars(sip, now);
  if (knows_its_outfit(now)) {
    read_bumpers(sip, now);
    if (edit_status().link != Link::up) set_link(Link::up, outfit_note(), now);
  }
  watch_motion(sip, now);
  last_sip_ = sip;
}

void P2osBase::reckon(const Sip& sip, Utime measured) {
  const Model& model = model_of(name_.subtype);
  if (last_sip_) {
    const double mm = model.mm_per_distance * 1e-3;
    const double dx = difference(sip.x, last_sip_->x) * mm;
    const double dy = difference(sip.y, last_sip_->y) * mm;
    const double was = last_sip_->heading * kRadPerHeading;
    const double turned = normalize_angle((sip.heading - last_sip_->heading) * kRadPerHeading);
    constexpr double kMostM = 0.6;  // in a cycle, even with some lost
    if (std::hypot(dx, dy) < kMostM) {
      // The step as the robot saw it, appended to the path here: an origin set anew moves nothing.
      const double c = std::cos(was), s = std::sin(was);
      pose_ = pose_ * Pose2{c * dx + s * dy, -s * dx + c * dy, turned};
      leg_turned_rad_ += turned;
    }
  }
  OdometrySample sample;
  sample.utime = measured;
  sample.odom_from_robot = pose_;
  sample.velocity_m_per_s = (sip.left_speed + sip.right_speed) / 2.0 * 1e-3;
  sample.yaw_rate_rad_per_s = (sip.right_speed - sip.left_speed) / 2.0 * model.rad_per_mm_per_s;
  publish_odometry(sample);
}

void P2osBase::ask_outfit(Utime now) {
  constexpr double kPatienceS = 0.3;  // the answer takes 0.15 s at 9600 baud
  say(kConfig, 1);
  ++config_asked_;
  next_config_ = now + Duration::from_seconds(kPatienceS);
}

/// Asks until the robot tells it, or has shown that it does not.
bool P2osBase::knows_its_outfit(Utime now) {
  constexpr int kAskedAtMost = 3;
  if (config_) return true;
  if (now < next_config_) return false;
  if (config_asked_ >= kAskedAtMost) return true;
  ask_outfit(now);
  return false;
}

std::string P2osBase::outfit_note() const {
  constexpr int kLongWatchdogMs = 3000;
  if (!config_) {
    return "the robot does not tell its bumpers: " + std::to_string(options_.bumpers_each_end) +
           " at each end are taken for fitted (bumpers_each_end)";
  }
  if (config_->watchdog_ms == 0) return "the robot's watchdog is off: a cut line does not stop it";
  if (config_->watchdog_ms <= kLongWatchdogMs) return "";
  return "the robot's watchdog waits " + std::to_string(config_->watchdog_ms) +
         " ms before it stops for a cut line";
}

void P2osBase::read_bumpers(const Sip& sip, Utime now) {
  constexpr int kBits = 7;  // beside the stall
  const auto fitted = [&](int RobotConfig::*end) {
    return config_ ? std::clamp((*config_).*end, 0, kBits) : options_.bumpers_each_end;
  };
  std::vector<bool> pressed;
  const auto read = [&pressed](uint8_t bits, int count) {
    std::vector<int> numbers;
    for (int i = 0; i < count; ++i) {
      pressed.push_back((bits >> (i + 1) & 1) != 0);
      if (pressed.back()) numbers.push_back(i + 1);
    }
    return numbers;
  };
  // The byte of the right wheel carries the front bumpers.
  std::vector<int> front = read(sip.right_stall, fitted(&RobotConfig::front_bumpers));
  std::vector<int> rear = read(sip.left_stall, fitted(&RobotConfig::rear_bumpers));
  guard().on_bumpers(std::move(front), std::move(rear));
  if (pressed == edit_status().bumpers) return;
  edit_status().bumpers = std::move(pressed);
  tell(now);
}

void P2osBase::read_sonars(const Sip& sip, Utime now) {
  const double m = model_of(name_.subtype).mm_per_range * 1e-3;
  for (const Sip::Sonar& sonar : sip.sonars) {
    if (sonar.number >= ring_.readings.size()) continue;
    const double range_m = sonar.range * m;
    ring_.readings[sonar.number].range_m = range_m < kNoEchoM - 0.001 ? range_m : 0.0;
  }
  if ((now - ring_told_).seconds() < kSonarTellS) return;
  ring_told_ = now;
  ring_.utime = now;
  guard().on_sonar(ring_, odom_from_robot(), now);
  output().sonar.push_back(ring_);
}

}  // namespace marco::drivers::p2os
