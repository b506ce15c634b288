#include "drivers/p2os/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers::p2os {
namespace {

constexpr int64_t kStepUs = 5000;
constexpr std::size_t kSonarsPerCycle = 4;

}  // namespace

P2osEmulator::P2osEmulator(P2osWorld world, const P2osEmulatorOptions& options)
    : world_(std::move(world)), options_(options), model_(model_of(options.name.subtype)) {
  reset();
}

void P2osEmulator::reset() {
  sync_ = 0;
  open_ = motors_on_ = sonars_on_ = stalled_ = false;
  max_velocity_ = options_.default_velocity_m_per_s;
  max_rate_ = deg_to_rad(options_.default_rate_deg_per_s);
  acceleration_ = options_.default_acceleration_m_per_s2;
  rate_acceleration_ = deg_to_rad(options_.default_rate_acceleration_deg_per_s2);
  deceleration_ = acceleration_;
  rate_deceleration_ = rate_acceleration_;
  encoders_asked_ = ports_asked_ = false;
  digital_out_ = 0;
  aux_wanted_ = 0;
  set_host_baud(0);
  velocity_ = rate_ = velocity_goal_ = rate_goal_ = 0.0;
  way_left_m_.reset();
  heading_goal_.reset();
  reckoned_ = {};
  output_.clear();
  parser_.clear();
}

void P2osEmulator::on_connection(bool /*connected*/, Utime now) {
  run_until(now);
  output_.clear();
  parser_.clear();
}

void P2osEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  run_until(now);
  if (baud != 0 && baud != baud_) return;  // noise at another speed
  parser_.push(bytes);
  while (const auto payload = parser_.next()) handle(*payload, now);
}

void P2osEmulator::handle(std::span<const uint8_t> payload, Utime now) {
  const auto command = decode_command(payload);
  if (!command) return;
  last_packet_ = now;
  if (sync_ < 3) {
    if (command->id != sync_ || command->value) {
      send(encode_packet(std::array<uint8_t, 1>{0xFF}), now);
      sync_ = 0;
    } else if (sync_ == 2) {
      send(encode_name(options_.name), now);
      sync_ = 3;
    } else {
      send(encode_packet(payload), now);
      ++sync_;
    }
    return;
  }
  if (command->id == kOpen) {
    open_ = sonars_on_ = true;  // SONAR 0 silences them
    next_sip_ = now + Duration::from_seconds(options_.cycle_s);
  } else if (command->id == kClose) {
    motors_on_ = open_ = sonars_on_ = false;
    velocity_ = rate_ = velocity_goal_ = rate_goal_ = 0.0;
    encoders_asked_ = ports_asked_ = false;
    set_host_baud(0);
    sync_ = 0;
  } else if (open_ && !answer(*command, now)) {
    obey(*command);
  }
}

void P2osEmulator::set_limit(const Command& command) {
  const int value = command.value.value_or(0);
  // A negative acceleration is how it brakes.
  const auto set = [value](double& faster, double& slower, double unit) {
    if (value != 0) (value > 0 ? faster : slower) = std::abs(value) * unit;
  };
  switch (command.id) {
    case kSetV:
      max_velocity_ = std::min(std::abs(value) * 1e-3, options_.max_velocity_m_per_s);
      break;
    case kSetRv:
      max_rate_ = deg_to_rad(std::abs(value));
      break;
    case kSetA:
      set(acceleration_, deceleration_, 1e-3);
      break;
    default:
      set(rate_acceleration_, rate_deceleration_, deg_to_rad(1.0));
      break;
  }
}

void P2osEmulator::obey(const Command& command) {
  const int value = command.value.value_or(0);
  const auto free_run = [this] {
    way_left_m_.reset();
    heading_goal_.reset();
    stalled_ = false;
  };
  switch (command.id) {
    case kEnable:
      motors_on_ = value != 0;
      break;
    case kSetV:
    case kSetA:
    case kSetRv:
    case kSetRa:
      set_limit(command);
      break;
    case kSetO:
      reckoned_ = {};
      heading_goal_.reset();
      break;
    case kMove:
      way_left_m_ = value * 1e-3;
      stalled_ = false;
      break;
    case kVel:
      free_run();
      velocity_goal_ = value * 1e-3;
      break;
    case kRotate:
    case kRVel:
      heading_goal_.reset();
      rate_goal_ = deg_to_rad(value);
      break;
    case kHead:
      heading_goal_ = deg_to_rad(value);
      stalled_ = false;
      break;
    case kDHead:
      heading_goal_ = normalize_angle(reckoned_.theta_rad + deg_to_rad(value));
      stalled_ = false;
      break;
    case kVel2: {
      free_run();
      const int word = value;
      const double right = static_cast<int8_t>(word & 0xFF) * 0.020;
      const double left = static_cast<int8_t>(word >> 8 & 0xFF) * 0.020;
      velocity_goal_ = (left + right) / 2.0;
      rate_goal_ = (right - left) / options_.track_m;
      break;
    }
    case kStop:
    case kEStop:
      free_run();
      velocity_goal_ = rate_goal_ = 0.0;
      if (command.id == kEStop) velocity_ = rate_ = 0.0;
      break;
    case kSonar:
      sonars_on_ = value != 0;
      break;
    default:
      break;  // unknown commands are passed over
  }
}

double P2osEmulator::wanted_velocity() const {
  if (!way_left_m_) return std::clamp(velocity_goal_, -max_velocity_, max_velocity_);
  // As fast as can still be braked.
  const double most = std::sqrt(2.0 * deceleration_ * std::abs(*way_left_m_));
  return std::copysign(std::min(most, max_velocity_), *way_left_m_);
}

double P2osEmulator::wanted_rate() const {
  if (!heading_goal_) return std::clamp(rate_goal_, -max_rate_, max_rate_);
  const double left = normalize_angle(*heading_goal_ - reckoned_.theta_rad);
  const double most = std::sqrt(2.0 * rate_deceleration_ * std::abs(left));
  return std::copysign(std::min(most, max_rate_), left);
}

void P2osEmulator::move(double dt_s) {
  const Touch touch = this->touch();
  if (touch.stalled && !stalled_ && (velocity_ != 0.0 || rate_ != 0.0)) {
    stalled_ = true;  // the motors give up until the next order
    velocity_ = rate_ = velocity_goal_ = rate_goal_ = 0.0;
    way_left_m_.reset();
    heading_goal_.reset();
  }
  const bool free = motors_on_;
  const auto change = [dt_s](double value, double goal, double faster, double slower) {
    const bool braking = std::abs(goal) < std::abs(value) || goal * value < 0.0;
    return approach(value, goal, (braking ? slower : faster) * dt_s);
  };
  velocity_ = free ? change(velocity_, wanted_velocity(), acceleration_, deceleration_) : 0.0;
  rate_ = free ? change(rate_, wanted_rate(), rate_acceleration_, rate_deceleration_) : 0.0;
  double way_m = velocity_ * dt_s, turn_rad = rate_ * dt_s;
  if (way_left_m_) {
    if (std::abs(way_m) >= std::abs(*way_left_m_) || std::abs(*way_left_m_) < 5e-4) {
      way_m = *way_left_m_;
      way_left_m_.reset();
      velocity_ = velocity_goal_ = 0.0;
    } else {
      *way_left_m_ -= way_m;
    }
  }
  if (heading_goal_) {
    const double left = normalize_angle(*heading_goal_ - reckoned_.theta_rad);
    if (std::abs(turn_rad) >= std::abs(left) || std::abs(left) < 1e-3) {
      turn_rad = left;
      heading_goal_.reset();
      rate_ = rate_goal_ = 0.0;
    }
  }
  left_m_ += way_m - turn_rad * options_.track_m / 2.0;
  right_m_ += way_m + turn_rad * options_.track_m / 2.0;
  reckoned_ = reckoned_ *
              Pose2{way_m * std::cos(turn_rad / 2.0), way_m * std::sin(turn_rad / 2.0), turn_rad};
}

void P2osEmulator::run_until(Utime now) {
  if (!started_) {
    started_ = true;
    now_ = last_packet_ = now;
  }
  while (now_ + Duration::from_us(kStepUs) <= now) {
    now_ = now_ + Duration::from_us(kStepUs);
    if ((now_ - last_packet_).seconds() > options_.watchdog_s) {
      velocity_goal_ = rate_goal_ = 0.0;
      way_left_m_.reset();
      heading_goal_.reset();
    }
    move(kStepUs * 1e-6);
    head_.advance(now_);
    if (open_ && now_ >= next_sip_) {
      next_sip_ = next_sip_ + Duration::from_seconds(options_.cycle_s);
      send(encode_sip(sip()), now_);
      send_asked(now_);
    }
  }
}

Touch P2osEmulator::touch() const {
  Touch touch = world_.touch ? world_.touch() : Touch{};
  if (options_.bumpers_each_end == 0) touch.front = touch.rear = 0x7F;
  return touch;
}

Sip P2osEmulator::sip() {
  Sip sip;
  const auto wrap = [](double raw) {
    return static_cast<uint16_t>(static_cast<int64_t>(std::lround(raw)) & 0x7FFF);
  };
  sip.moving = velocity_ != 0.0 || rate_ != 0.0;
  sip.x = wrap(reckoned_.x_m * 1e3 / model_.mm_per_distance);
  sip.y = wrap(reckoned_.y_m * 1e3 / model_.mm_per_distance);
  sip.heading = static_cast<int16_t>(std::lround(reckoned_.theta_rad / kRadPerHeading));
  const double spread = rate_ * options_.track_m / 2.0;
  sip.left_speed = static_cast<int16_t>(std::lround((velocity_ - spread) * 1e3));
  sip.right_speed = static_cast<int16_t>(std::lround((velocity_ + spread) * 1e3));
  const double volts = world_.battery_v ? world_.battery_v() : 12.6;
  sip.battery = static_cast<uint8_t>(std::clamp(std::lround(volts * 10.0), 0L, 255L));
  const Touch touch = this->touch();
  sip.left_stall = static_cast<uint8_t>((stalled_ ? 1 : 0) | touch.rear << 1);
  sip.right_stall = static_cast<uint8_t>((stalled_ ? 1 : 0) | touch.front << 1);
  sip.digital_out = digital_out_;
  sip.flags = static_cast<uint16_t>((motors_on_ ? 1 : 0) | (sonars_on_ ? 0x1E : 0));
  if (!sonars_on_) return sip;
  for (std::size_t i = 0; i < kSonarsPerCycle; ++i) {
    const std::size_t number = next_sonar_++ % 16;
    constexpr double kNoEchoMm = 5000.0;
    double mm = world_.sonar_range_m ? world_.sonar_range_m(number) * 1e3 : kNoEchoMm;
    mm = std::min(mm, kNoEchoMm);
    sip.sonars.push_back({static_cast<uint8_t>(number),
                          static_cast<uint16_t>(std::lround(mm / model_.mm_per_range))});
  }
  return sip;
}

void P2osEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  run_until(now);
  output_.advance(now, out);
  if (baud_after_sending_ != 0 && output_.empty()) {
    baud_ = std::exchange(baud_after_sending_, 0);
    output_.set_baud(baud_);
  }
}

Utime P2osEmulator::next_event() const {
  if (!started_) return Utime{};
  return std::min(now_ + Duration::from_us(kStepUs), output_.next_event());
}

}  // namespace marco::drivers::p2os
