#include "drivers/bno055/driver.hpp"

#include <algorithm>
#include <utility>

#include "common/pose3.hpp"
#include "drivers/transport/little_endian.hpp"
#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::bno055 {
namespace {

constexpr Duration kPatience = Duration::from_us(250'000);  // a read has taken 200 ms
constexpr Duration kAgain = Duration::from_us(2000);        // after an overrun
constexpr Duration kModeChange = Duration::from_us(30'000);
constexpr Duration kCheckPeriod = Duration::from_us(1'000'000);
constexpr int kManyOverruns = 20;

Eigen::Vector3d vector_at(const Bytes& data, std::size_t at, double scale) {
  return scale * Eigen::Vector3d(get_s16(data, at), get_s16(data, at + 2), get_s16(data, at + 4));
}

}  // namespace

Bno055Driver::Bno055Driver(const Bno055Options& options)
    : options_(options), bias_(deg_to_rad(options.still_deg_per_s), options.still_s) {
  validate(options, "bno055");
  require(options.roll_pitch_yaw_deg.size() == 3,
          "bno055.roll_pitch_yaw_deg: expected three numbers");
  robot_from_sensor_ =
      make_pose3(Eigen::Vector3d::Zero(), deg_to_rad(options.roll_pitch_yaw_deg[0]),
                 deg_to_rad(options.roll_pitch_yaw_deg[1]),
                 deg_to_rad(options.roll_pitch_yaw_deg[2]))
          .linear();
}

std::vector<ImuSample> Bno055Driver::take_samples() { return std::exchange(samples_, {}); }

std::string Bno055Driver::state() const {
  if (!alive_) {
    return "no data from the sensor: is it set to UART (PS1 high, PS0 low), RX and TX "
           "crossed?";
  }
  std::string state = phase_ < Phase::checking_mode ? "setting the sensor up" : "measuring";
  state += ", bias " + std::to_string(rad_to_deg(bias_.rad_per_s().z())) + " deg/s";
  if (overruns_in_a_row_ >= kManyOverruns) state += ", the sensor has no time to answer";
  return state;
}

void Bno055Driver::on_connection(bool connected, Utime now) {
  connected_ = connected;
  alive_ = false;
  overruns_in_a_row_ = 0;
  bias_.restart();
  enter(Phase::asking_id, now);
}

void Bno055Driver::enter(Phase phase, Utime when) {
  phase_ = phase;
  asked_ = false;
  next_request_ = when;
  if (phase == Phase::checking_mode) next_check_ = next_sample_ = when;
}

Bytes Bno055Driver::request() const {
  switch (phase_) {
    case Phase::asking_id:
      return read_request(Register::chip_id, 1);
    case Phase::configuring:
      return write_request(Register::mode, static_cast<uint8_t>(Mode::configuration));
    case Phase::setting_units:
      return write_request(Register::units, kUnits);
    case Phase::starting:
      return write_request(Register::mode, static_cast<uint8_t>(Mode::fusion));
    case Phase::checking_mode:
      return read_request(Register::mode, 1);
    default:
      return read_request(Register::acceleration, kMotionBytes);
  }
}

void Bno055Driver::receive(std::span<const uint8_t> bytes, Utime now) {
  parser_.push(bytes);
  while (asked_) {
    const auto reply = parser_.next();
    if (!reply) break;
    alive_ = true;
    const std::size_t size = 2 + reply->data.size();
    on_reply(*reply, now - line_time(size, kBaud), now);
  }
}

void Bno055Driver::on_reply(const Reply& reply, Utime left, Utime now) {
  asked_ = false;
  const bool wrote = reply.status == kWritten;
  if (reply.status && !wrote) return on_refusal(*reply.status, now);
  overruns_in_a_row_ = 0;
  switch (phase_) {
    case Phase::asking_id:
      if (wrote || reply.data[0] != kChipId) return enter(Phase::asking_id, now + kPatience);
      return enter(Phase::configuring, now);
    case Phase::configuring:
      return enter(Phase::setting_units, now + kModeChange);
    case Phase::setting_units:
      return enter(Phase::starting, now);
    case Phase::starting:
      return enter(Phase::checking_mode, now + kModeChange);
    case Phase::checking_mode:
      if (wrote || reply.data[0] != static_cast<uint8_t>(Mode::fusion)) {
        return enter(Phase::asking_id, now);  // its power was gone for a moment
      }
      phase_ = Phase::reading;
      next_check_ = now + kCheckPeriod;
      next_request_ = next_sample_;
      return;
    case Phase::reading:
      // A sensor that does not measure sends zeros.
      if (std::all_of(reply.data.begin(), reply.data.end(), [](uint8_t b) { return b == 0; })) {
        phase_ = Phase::checking_mode;
        next_request_ = now;
        return;
      }
      on_motion(reply.data, left);
      // Those that it had no time for are left out.
      while (next_sample_ <= now) {
        next_sample_ = next_sample_ + Duration::from_seconds(1.0 / options_.rate_hz);
      }
      next_request_ = next_sample_;
      if (now >= next_check_) {
        phase_ = Phase::checking_mode;
        next_request_ = now;
      }
  }
}

void Bno055Driver::on_refusal(uint8_t code, Utime now) {
  if (code == kOverrun) {
    ++overruns_;
    ++overruns_in_a_row_;
    next_request_ = now + kAgain;
    return;
  }
  enter(Phase::asking_id, now + kPatience);
}

void Bno055Driver::on_motion(const Bytes& data, Utime measured) {
  const Eigen::Vector3d rates = robot_from_sensor_ * vector_at(data, 12, kRadPerS);
  bias_.add(rates, measured);
  ImuSample sample;
  sample.utime = measured;
  sample.angular_velocity_rad_per_s = rates - bias_.rad_per_s();
  sample.acceleration_m_per_s2 = robot_from_sensor_ * vector_at(data, 0, kMetresPerS2);
  samples_.push_back(sample);
}

void Bno055Driver::advance(Utime now, std::vector<uint8_t>& out) {
  if (!connected_) return;
  if (asked_ && now > deadline_) {
    alive_ = false;
    enter(Phase::asking_id, now);
  }
  if (asked_ || now < next_request_) return;
  const Bytes bytes = request();
  const bool reads = bytes[1] == 1;
  parser_.expect(reads ? bytes[3] : 0);
  out.insert(out.end(), bytes.begin(), bytes.end());
  asked_ = true;
  deadline_ = now + kPatience;
}

}  // namespace marco::drivers::bno055
