#include "drivers/p2os/driver.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/p2os/visca.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr double kAskEveryS = 0.25;
constexpr int kAnswerBytes = 11;  // 90 50, four nibbles of pan, four of tilt, FF

uint8_t speed_code(double rate_rad_per_s, double top_deg_per_s, int top) {
  if (rate_rad_per_s <= 0.0) return static_cast<uint8_t>(top);
  const double code = rad_to_deg(rate_rad_per_s) / top_deg_per_s * top;
  return static_cast<uint8_t>(std::clamp(std::lround(code), 1L, static_cast<long>(top)));
}

int units(double angle_rad, double per_deg, int most) {
  const double wanted = rad_to_deg(angle_rad) * per_deg;
  return static_cast<int>(std::lround(std::clamp<double>(wanted, -most, most)));
}

Bytes to_head(const Bytes& message) {
  return encode_command(
      {CommandId::tty2, std::nullopt, std::string(message.begin(), message.end())});
}

// Fifteen bits, unwrapped.
int difference(uint16_t now, uint16_t before) {
  const int d = (now - before) & 0x7FFF;
  return d >= 0x4000 ? d - 0x8000 : d;
}

using Link = BaseStatus::Link;

constexpr double kRepeatVelocityS = 0.3;
constexpr int kTurnDegPerS2 = 100;
constexpr double kLegDeadS = 1.0;  // without motion: it is over, or never began

int whole(double value) { return static_cast<int>(std::lround(value)); }

}  // namespace

Bytes HeadClient::power_on(Utime now) {
  next_ask_ = now;
  return to_head({0x81, 0x01, 0x04, 0x00, 0x02, kViscaEnd});
}

Bytes HeadClient::look(const PanTiltCommand& command, Utime now) {
  next_ask_ = now + Duration::from_seconds(kAskEveryS);
  const uint8_t pan_speed = speed_code(command.pan_rate_rad_per_s, kTopPanDegPerS, kTopPan);
  const uint8_t tilt_speed = speed_code(command.tilt_rate_rad_per_s, kTopTiltDegPerS, kTopTilt);
  if (command.kind == PanTiltCommand::Kind::stop) {
    return to_head({0x81, 0x01, 0x06, 0x01, pan_speed, tilt_speed, 3, 3, kViscaEnd});
  }
  Bytes message{0x81, 0x01, 0x06, 0x02, pan_speed, tilt_speed};
  put_visca_word(message, -units(command.pan_rad, kUnitsPerPanDeg, kMostPan));
  put_visca_word(message, units(command.tilt_rad, kUnitsPerTiltDeg, kMostTilt));
  message.push_back(kViscaEnd);
  return to_head(message);
}

Bytes HeadClient::ask(Utime now) {
  if (now < next_ask_) return {};
  next_ask_ = now + Duration::from_seconds(kAskEveryS);
  Bytes packets =
      encode_command({CommandId::get_aux, 0, ""});  // drops its answers to the orders before
  for (const Bytes& packet : {to_head({0x81, 0x09, 0x06, 0x12, kViscaEnd}),
                              encode_command({CommandId::get_aux, kAnswerBytes, ""})}) {
    packets.insert(packets.end(), packet.begin(), packet.end());
  }
  return packets;
}

std::optional<PanTiltState> HeadClient::decode(std::span<const uint8_t> payload, Utime arrival) {
  if (payload.size() != 1 + kAnswerBytes || payload[1] != 0x90 || payload[2] != 0x50) {
    return std::nullopt;
  }
  PanTiltState state;
  state.utime = arrival;  // the head's own line and the robot's cycle hide when it was asked
  state.pan_rad = -deg_to_rad(visca_word(payload, 3) / kUnitsPerPanDeg);
  state.tilt_rad = deg_to_rad(visca_word(payload, 7) / kUnitsPerTiltDeg);
  return state;
}

void SipOdometry::begin_leg() {
  leg_start_ = odom_from_robot_;
  turned_rad_ = 0.0;
}

OdometrySample SipOdometry::add(const Sip& sip, const Model& model, Utime measured) {
  if (last_) {
    const double mm = model.mm_per_distance * 1e-3;
    const double dx = difference(sip.x, last_->x) * mm;
    const double dy = difference(sip.y, last_->y) * mm;
    const double was = last_->heading * kRadPerHeading;
    const double turned = normalize_angle((sip.heading - last_->heading) * kRadPerHeading);
    constexpr double kMostM = 0.6;  // in a cycle, even when some are lost
    if (std::hypot(dx, dy) < kMostM) {
      const double c = std::cos(was), s = std::sin(was);
      odom_from_robot_ = odom_from_robot_ * Pose2{c * dx + s * dy, -s * dx + c * dy, turned};
      turned_rad_ += turned;
    }
  }
  last_ = sip;
  OdometrySample sample;
  sample.utime = measured;
  sample.odom_from_robot = odom_from_robot_;
  const double mm_per_s = model.mm_per_s_per_velocity;
  sample.velocity_m_per_s = (sip.left_speed + sip.right_speed) / 2.0 * mm_per_s * 1e-3;
  sample.yaw_rate_rad_per_s =
      (sip.right_speed - sip.left_speed) / 2.0 * mm_per_s * model.rad_per_mm_per_s;
  return sample;
}

void SonarCollector::fit(const Model& model) {
  m_per_range_ = model.mm_per_range * 1e-3;
  ring_.readings.clear();
  reading_of_.clear();
  for (const std::optional<Pose2>& robot_from_sonar : model.robot_from_sonar) {
    reading_of_.push_back(robot_from_sonar ? std::optional(ring_.readings.size()) : std::nullopt);
    if (robot_from_sonar) ring_.readings.push_back({0.0, *robot_from_sonar});
  }
}

std::optional<SonarRing> SonarCollector::add(const Sip& sip, Utime now) {
  constexpr double kNoEchoM = 5.0;
  constexpr double kSixteenS = 0.4;  // four a packet
  for (const Sip::Sonar& sonar : sip.sonars) {
    if (sonar.number >= reading_of_.size() || !reading_of_[sonar.number]) continue;
    const double range_m = sonar.range * m_per_range_;
    ring_.readings[*reading_of_[sonar.number]].range_m = range_m < kNoEchoM - 0.001 ? range_m : 0.0;
  }
  const double ring_s = reading_of_.size() > 16 ? 2.0 * kSixteenS : kSixteenS;
  if (ring_.readings.empty() || (now - last_ring_).seconds() < ring_s) return std::nullopt;
  last_ring_ = ring_.utime = now;
  return ring_;
}

P2osBase::P2osBase(const P2osOptions& options)
    : BaseDriver("p2os", options.speeds, options.guard),
      options_(options),
      outfit_(options.bumpers_each_end),
      sonars_(deg_to_rad(options.sonar_cone_deg)) {
  validate(options, "p2os");
  const bool known = options.mm_per_distance > 0.0;
  require(
      known == (options.mm_per_range > 0.0) && known == (options.rad_per_mm_per_s > 0.0),
      "p2os: mm_per_distance, mm_per_range and rad_per_mm_per_s are set together or not at all");
}

BaseDynamics P2osBase::dynamics() const {
  const double ahead = speeds().acceleration_m_per_s2, turn = deg_to_rad(kTurnDegPerS2);
  return {ahead, ahead, turn, turn};
}

void P2osBase::on_connection(bool connected, Utime now) {
  session_.on_connection(connected, now);
  restart_session(now);
  set_link(Link::down, connected ? "waiting for the robot" : "the line is gone", now);
}

void P2osBase::restart_session(Utime now) {
  session_.restart(now);
  outfit_.restart();
  odometry_.restart();
  sonars_.forget_stamps();
  leg_.reset();
  stopping_.reset();
  sent_velocity_ = {};  // the host's clock may have been set back
}

void P2osBase::receive(std::span<const uint8_t> bytes, Utime now) {
  for (const Bytes& payload : session_.receive(bytes, now)) on_packet(payload, now);
}

void P2osBase::on_packet(const Bytes& payload, Utime arrival) {
  if (!session_.is_open()) {
    if (session_.on_sync(payload, arrival)) set_up(arrival);
    return;
  }
  const auto sip = decode_sip(payload);
  if (!sip) return on_other_packet(payload, arrival);
  const double line_s = (static_cast<double>(payload.size()) + 5.0) * 10.0 / session_.baud();
  on_sip(*sip, arrival - Duration::from_seconds(line_s), arrival);
}

void P2osBase::on_other_packet(const Bytes& payload, Utime arrival) {
  if (payload[0] == kAuxPacket) {
    if (const auto state = HeadClient::decode(payload, arrival)) output().head.push_back(*state);
  } else if (payload[0] == kConfigPacket) {
    if (!outfit_.on_config(payload)) session_.reject();
  } else if (payload[0] == 0xFF || payload[0] <= 2) {  // it was reset and does not know us
    set_link(Link::starting, "the robot was reset", arrival);
    restart_session(arrival);
  } else {
    session_.reject();
  }
}

void P2osBase::set_up(Utime now) {
  model_ = model();
  if (model_) sonars_.fit(*model_);
  session_.say(CommandId::open, 1);
  session_.say(CommandId::stop);
  session_.say(CommandId::sonar, options_.sonar ? 1 : 0);
  speeds_changed();
  session_.say(CommandId::enable, 1);
  ask_outfit(now);
  if (options_.camera_head) session_.send(head_.power_on(now));
  const RobotName& robot = session_.name();
  set_link(Link::starting, robot.type + " " + robot.subtype + " '" + robot.name + "'", now);
}

void P2osBase::ask_outfit(Utime now) {
  session_.say(CommandId::config, 1);
  outfit_.on_asked(now);
}

void P2osBase::speeds_changed() {
  if (!session_.is_open()) return;
  session_.say(CommandId::set_max_velocity, std::max(1, whole(speeds().velocity_m_per_s * 1e3)));
  session_.say(CommandId::set_max_rate,
               std::max(1, whole(rad_to_deg(speeds().yaw_rate_rad_per_s))));
  // Below 0 it is the deceleration, which else is as somebody left it.
  const int acceleration = std::max(1, whole(speeds().acceleration_m_per_s2 * 1e3));
  for (const int sign : {1, -1}) {
    session_.say(CommandId::set_acceleration, sign * acceleration);
    session_.say(CommandId::set_rotation_acceleration, sign * kTurnDegPerS2);
  }
}

std::optional<Model> P2osBase::model() const {
  std::optional<Model> model = model_of(session_.name().subtype);
  if (options_.mm_per_distance == 0.0) return model;
  if (!model) model.emplace();
  model->mm_per_distance = options_.mm_per_distance;
  model->mm_per_range = options_.mm_per_range;
  model->rad_per_mm_per_s = options_.rad_per_mm_per_s;
  return model;
}

void P2osBase::on_sip(const Sip& sip, Utime measured, Utime now) {
  if (!model_) {
    // Another's units would put it elsewhere without a word.
    return set_link(Link::down,
                    "a Pioneer '" + session_.name().subtype +
                        "' is not known: set mm_per_distance, mm_per_range and rad_per_mm_per_s "
                        "(DistConvFactor, RangeConvFactor, DiffConvFactor of its parameter file)",
                    now);
  }
  publish_odometry(odometry_.add(sip, *model_, measured));
  edit_status().motors_on = (sip.flags & 1) != 0;
  edit_status().battery_v = {sip.battery / 10.0};
  if (options_.sonar) {
    if (const auto ring = sonars_.add(sip, now)) {
      guard().on_sonar(*ring, odom_from_robot(), now);
      output().sonar.push_back(*ring);
    }
  }
  if (outfit_.must_ask(now)) ask_outfit(now);
  if (outfit_.known(now)) {
    read_bumpers(sip, now);
    if (edit_status().link != Link::up) set_link(Link::up, outfit_.note(), now);
  }
  watch_motion(sip, now);
}

void P2osBase::read_bumpers(const Sip& sip, Utime now) {
  Outfit::Bumpers bumpers = outfit_.bumpers(sip);
  guard().on_bumpers(std::move(bumpers.front_pressed), std::move(bumpers.rear_pressed));
  if (bumpers.all == edit_status().bumpers) return;
  edit_status().bumpers = std::move(bumpers.all);
  tell(now);
}

void P2osBase::watch_motion(const Sip& sip, Utime now) {
  const bool still = !sip.moving && sip.left_speed == 0 && sip.right_speed == 0;
  still_ = still ? still_ + 1 : 0;
  if (stopping_) return watch_stop(now);
  if (!leg_) return;
  const bool stalled = ((sip.left_stall | sip.right_stall) & 1) != 0;
  if (stalled) {
    leg_.reset();
    return leg_ended(false, "the wheels are stalled", now);
  }
  const double since_s = (now - leg_since_).seconds();
  if (still_ < 3 || since_s < 0.6) return;
  const double left = std::abs(leg_remaining());
  const bool there = left < (leg_->kind == Leg::Kind::move ? 0.02 : deg_to_rad(1.2));
  if (!there && since_s < kLegDeadS) return;
  const Leg rest{leg_->kind, leg_remaining()};
  leg_.reset();
  if (there || retries_ >= 2) {
    leg_ended(there, there ? "" : "the robot did not reach the goal", now);
  } else {
    const int tries = retries_ + 1;  // the order may have been lost: nothing acknowledges it
    start_leg(rest, now);
    retries_ = tries;
  }
}

void P2osBase::watch_stop(Utime now) {
  if (still_ >= 2) {
    stopping_.reset();
    leg_.reset();
    sent_velocity_.mm_per_s = sent_velocity_.deg_per_s = 0;
    stopped(now);
  } else if ((now - *stopping_).seconds() > 0.3) {
    stop_wheels(now);
  }
}

void P2osBase::start_leg(const Leg& leg, Utime now) {
  leg_ = leg;
  odometry_.begin_leg();
  leg_since_ = now;
  still_ = 0;
  retries_ = 0;
  if (leg.kind == Leg::Kind::move) {
    session_.say(CommandId::move, std::clamp(whole(leg.amount * 1e3), -32000, 32000));
  } else {
    // DHEAD takes the shorter way: beyond half a turn the rest follows as a retry would.
    const double most = deg_to_rad(170.0);
    const int degrees = whole(rad_to_deg(std::clamp(leg.amount, -most, most)));
    if (degrees == 0) {
      leg_.reset();
      leg_ended(true, "", now);
      return;
    }
    session_.say(CommandId::turn_by, degrees);
  }
}

double P2osBase::leg_remaining() const {
  if (!leg_) return 0.0;
  return leg_->amount -
         (leg_->kind == Leg::Kind::turn ? odometry_.turned_rad() : odometry_.moved_m());
}

void P2osBase::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) {
  const SentVelocity wanted{whole(velocity_m_per_s * 1e3), whole(rad_to_deg(yaw_rate_rad_per_s)),
                            now};
  const bool due = (now - sent_velocity_.when).seconds() > kRepeatVelocityS;
  if (wanted.mm_per_s == sent_velocity_.mm_per_s && wanted.deg_per_s == sent_velocity_.deg_per_s &&
      !due) {
    return;
  }
  sent_velocity_ = wanted;
  session_.say(CommandId::velocity, wanted.mm_per_s);
  session_.say(CommandId::rotation_velocity, wanted.deg_per_s);
}

void P2osBase::halt(CommandId how, Utime now) {
  stopping_ = now;
  still_ = 0;
  session_.say(how);
}

void P2osBase::look(const PanTiltCommand& command, Utime now) {
  if (options_.camera_head && session_.is_open()) session_.send(head_.look(command, now));
}

void P2osBase::advance(Utime now, std::vector<uint8_t>& out) {
  if (!session_.advance(now)) {
    set_link(Link::down, "the robot is silent", now);
    restart_session(now);
  }
  if (options_.camera_head && session_.is_open()) session_.send(head_.ask(now));
  advance_motion(now);
  session_.flush(now, out);
}

// The zeros end a packet that was sent in part; the longest goes to the camera's head.
std::vector<uint8_t> P2osBase::stop_bytes() const {
  std::vector<uint8_t> bytes(32, 0);
  const Bytes packet = encode_command({CommandId::emergency_stop, std::nullopt, ""});
  bytes.insert(bytes.end(), packet.begin(), packet.end());
  return bytes;
}

}  // namespace marco::drivers::p2os
