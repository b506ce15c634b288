#include "drivers/p2os/driver.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers::p2os {
namespace {

using Link = BaseStatus::Link;

constexpr double kSyncS = 0.5;
constexpr double kPulseS = 0.4;
constexpr double kSilentS = 1.5;
constexpr double kRepeatVelocityS = 0.3;
constexpr double kLegDeadS = 1.0;    // without motion: it is over, or never began
constexpr double kSonarTellS = 0.4;  // a round of sixteen at four a packet
constexpr double kNoEchoM = 5.0;

Duration seconds(double s) { return Duration::from_seconds(s); }

/// Fifteen bits, unwrapped.
int difference(uint16_t now, uint16_t before) {
  const int d = (now - before) & 0x7FFF;
  return d >= 0x4000 ? d - 0x8000 : d;
}

}  // namespace

P2osBase::P2osBase(const P2osOptions& options)
    : BaseDriver("p2os", options.speeds, options.guard), options_(options) {
  validate(options, "p2os");
  ring_.cone_rad = deg_to_rad(options.sonar_cone_deg);
  for (const Pose2& robot_from_sonar : p2dx_sonars()) {
    ring_.readings.push_back({0.0, robot_from_sonar});
  }
}

double P2osBase::stop_distance_m() const {
  const double v = speeds().velocity_m_per_s;
  return 0.5 * v * v / speeds().acceleration_m_per_s2 + 0.25 * v;
}

void P2osBase::say(CommandId id, std::optional<int> value) {
  const Bytes packet = encode_command({id, value, ""});
  to_send_.insert(to_send_.end(), packet.begin(), packet.end());
}

void P2osBase::on_connection(bool connected, Utime now) {
  connected_ = connected;
  parser_.clear();
  to_send_.clear();
  restart_sync(now);
  set_link(Link::down, connected ? "waiting for the robot" : "the line is gone", now);
}

void P2osBase::restart_sync(Utime now) {
  sync_ = 0;
  next_sync_ = now;
  last_packet_ = now;
  last_sip_.reset();
  leg_.reset();
  stop_asked_ = false;
  velocity_mm_per_s_ = rate_deg_per_s_ = 0;
}

void P2osBase::receive(std::span<const uint8_t> bytes, Utime now) {
  parser_.push(bytes);
  while (const auto payload = parser_.next()) on_packet(*payload, now);
}

void P2osBase::on_packet(const Bytes& payload, Utime arrival) {
  last_packet_ = arrival;
  const auto sip = decode_sip(payload);
  if (sync_ < 3) {
    if (sip) {
      // Still open from an earlier client: close it and begin anew.
      say(kClose);
      next_sync_ = arrival + seconds(0.2);
      sync_ = 0;
    } else {
      on_sync(payload, arrival);
    }
    return;
  }
  if (!sip) {
    if (payload[0] == 0xFF || payload[0] <= 2) {  // it was reset and does not know us
      set_link(Link::starting, "the robot was reset", arrival);
      restart_sync(arrival);
    } else {
      ++bad_packets_;
    }
    return;
  }
  const double line_s = (static_cast<double>(payload.size()) + 5.0) * 10.0 / kBaud;
  on_sip(*sip, arrival - seconds(line_s), arrival);
}

void P2osBase::on_sync(const Bytes& payload, Utime now) {
  if (payload[0] != sync_) {
    restart_sync(now);
    next_sync_ = now + seconds(kSyncS);
    return;
  }
  if (sync_ < 2) {
    ++sync_;
    next_sync_ = now;
    return;
  }
  const auto name = decode_name(payload);
  if (!name) {
    ++bad_packets_;
    return;
  }
  name_ = *name;
  sync_ = 3;
  say(kOpen, 1);
  say(kStop);
  say(kSonar, options_.sonar ? 1 : 0);
  speeds_changed();
  say(kEnable, 1);
  set_link(Link::starting, name_.type + " " + name_.subtype + " '" + name_.name + "'", now);
}

void P2osBase::speeds_changed() {
  if (sync_ < 3) return;
  const auto whole = [](double value) { return std::max(1, static_cast<int>(std::lround(value))); };
  say(kSetV, whole(speeds().velocity_m_per_s * 1e3));
  say(kSetA, whole(speeds().acceleration_m_per_s2 * 1e3));
  say(kSetRv, whole(rad_to_deg(speeds().yaw_rate_rad_per_s)));
  say(kSetRa, 100);
}

void P2osBase::on_sip(const Sip& sip, Utime measured, Utime now) {
  reckon(sip, measured);
  edit_status().motors_on = (sip.flags & 1) != 0;
  edit_status().battery_v = {sip.battery / 10.0};
  read_bumpers(sip, now);
  if (options_.sonar) read_sonars(sip, now);
  if (edit_status().link != Link::up) set_link(Link::up, "", now);
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

void P2osBase::read_bumpers(const Sip& sip, Utime now) {
  std::vector<bool> pressed;
  const auto count = options_.bumpers_each_end;
  const auto add = [&](uint8_t bits) {
    for (int i = 0; i < count; ++i) pressed.push_back((bits >> (i + 1) & 1) != 0);
  };
  add(sip.right_stall);  // the byte of the right wheel carries the front bumpers
  add(sip.left_stall);
  const auto middle = pressed.begin() + count;
  const bool front = std::find(pressed.begin(), middle, true) != middle;
  const bool rear = std::find(middle, pressed.end(), true) != pressed.end();
  guard().on_bumpers(front, rear);
  if (pressed == edit_status().bumpers) return;
  edit_status().bumpers = pressed;
  edit_status().utime = now;
  output().status.push_back(status());
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

void P2osBase::watch_motion(const Sip& sip, Utime now) {
  const bool still = !sip.moving && sip.left_speed == 0 && sip.right_speed == 0;
  still_ = still ? still_ + 1 : 0;
  if (stop_asked_) {
    if (still_ >= 2) {
      stop_asked_ = false;
      leg_.reset();
      velocity_mm_per_s_ = rate_deg_per_s_ = 0;
      stopped(now);
    } else if ((now - stop_since_).seconds() > 0.3) {
      stop_wheels(now);
    }
    return;
  }
  if (!leg_) return;
  const bool stalled = ((sip.left_stall | sip.right_stall) & 1) != 0;
  if (stalled) {
    leg_.reset();
    leg_ended(false, "the wheels are stalled", now);
    return;
  }
  const double since_s = (now - leg_since_).seconds();
  if (still_ < 3 || since_s < 0.6) return;
  const double left = std::abs(leg_remaining());
  const bool there = left < (leg_->kind == Leg::Kind::move ? 0.02 : deg_to_rad(1.2));
  if (!there && since_s < kLegDeadS) return;
  const Leg rest{leg_->kind, leg_remaining()};
  leg_.reset();
  if (there || retries_ >= 2) {
    leg_ended(there, there ? "" : "the robot did not get there", now);
  } else {
    const int tries = retries_ + 1;  // the order may have been lost: nothing acknowledges it
    start_leg(rest, now);
    retries_ = tries;
  }
}

void P2osBase::start_leg(const Leg& leg, Utime now) {
  leg_ = leg;
  leg_start_ = pose_;
  leg_turned_rad_ = 0.0;
  leg_since_ = now;
  still_ = 0;
  retries_ = 0;
  if (leg.kind == Leg::Kind::move) {
    say(kMove, std::clamp(static_cast<int>(std::lround(leg.amount * 1e3)), -32000, 32000));
  } else {
    // DHEAD takes the shorter way: beyond half a turn the rest follows as a retry would.
    const double most = deg_to_rad(170.0);
    const int degrees =
        static_cast<int>(std::lround(rad_to_deg(std::clamp(leg.amount, -most, most))));
    if (degrees == 0) {
      leg_.reset();
      leg_ended(true, "", now);
      return;
    }
    say(kDHead, degrees);
  }
}

double P2osBase::leg_remaining() const {
  if (!leg_) return 0.0;
  if (leg_->kind == Leg::Kind::turn) return leg_->amount - leg_turned_rad_;
  return leg_->amount - between(leg_start_, pose_).x_m;
}

void P2osBase::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) {
  const int velocity = static_cast<int>(std::lround(velocity_m_per_s * 1e3));
  const int rate = static_cast<int>(std::lround(rad_to_deg(yaw_rate_rad_per_s)));
  const bool due = (now - velocity_sent_).seconds() > kRepeatVelocityS;
  if (velocity == velocity_mm_per_s_ && rate == rate_deg_per_s_ && !due) return;
  velocity_mm_per_s_ = velocity;
  rate_deg_per_s_ = rate;
  velocity_sent_ = now;
  say(kVel, velocity);
  say(kRVel, rate);
}

void P2osBase::stop_wheels(Utime now) {
  stop_asked_ = true;
  stop_since_ = now;
  still_ = 0;
  say(kStop);
}

void P2osBase::advance(Utime now, std::vector<uint8_t>& out) {
  if (connected_ && sync_ < 3 && now >= next_sync_) {
    next_sync_ = now + seconds(kSyncS);
    say(static_cast<CommandId>(sync_));
  }
  if (connected_ && (now - last_packet_).seconds() > kSilentS) {
    set_link(Link::down, "the robot is silent", now);
    restart_sync(now);
  }
  if (connected_ && sync_ == 3 && to_send_.empty() && (now - last_sent_).seconds() > kPulseS) {
    say(kPulse);
  }
  advance_motion(now);
  if (!connected_ || to_send_.empty()) {
    to_send_.clear();
    return;
  }
  out.insert(out.end(), to_send_.begin(), to_send_.end());
  to_send_.clear();
  last_sent_ = now;
}

void P2osBase::shut_down(std::vector<uint8_t>& out) {
  to_send_.clear();
  say(kStop);
  say(kEnable, 0);
  say(kClose);
  out.insert(out.end(), to_send_.begin(), to_send_.end());
  to_send_.clear();
}

}  // namespace marco::drivers::p2os
