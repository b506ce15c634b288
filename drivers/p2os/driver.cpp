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
constexpr double kLegDeadS = 1.0;  // without motion: it is over, or never began

Duration seconds(double s) { return Duration::from_seconds(s); }

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
  config_.reset();
  config_asked_ = 0;
  next_sync_ = now;
  last_packet_ = now;
  velocity_sent_ = ring_told_ = {};  // the host's clock may have been set back
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
    if (payload[0] == kAuxPacket) {
      on_head(payload, arrival);
    } else if (payload[0] == kConfigPacket) {
      config_ = decode_config(payload);
      if (!config_) ++bad_packets_;
    } else if (payload[0] == 0xFF || payload[0] <= 2) {  // it was reset and does not know us
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
  ask_outfit(now);
  next_head_ = now;
  if (options_.camera_head) say_to_head({0x81, 0x01, 0x04, 0x00, 0x02, 0xFF});  // power on
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

void P2osBase::halt(CommandId how, Utime now) {
  stop_asked_ = true;
  stop_since_ = now;
  still_ = 0;
  say(how);
}

void P2osBase::stop_wheels(Utime now) { halt(kStop, now); }

void P2osBase::emergency_brake(Utime now) { halt(kEStop, now); }

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
  if (options_.camera_head && sync_ == 3 && now >= next_head_) ask_head(now);
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
