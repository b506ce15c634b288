#include "drivers/imu/driver.hpp"

#include <cmath>
#include <utility>

#include "common/pose3.hpp"

namespace marco::drivers::imu {
namespace {

constexpr double kSilentS = 1.5;
constexpr double kSettingS = 2.0;

Eigen::Vector3d vector_of(const Frame& frame, double scale) {
  return scale * Eigen::Vector3d(frame.values[0], frame.values[1], frame.values[2]);
}

}  // namespace

ImuDriver::ImuDriver(const ImuOptions& options)
    : options_(options), bias_(deg_to_rad(options.still_deg_per_s), options.still_s) {
  validate(options, "imu");
  require(rate_code(options.rate_hz).has_value(),
          "imu.rate_hz: the sensor supports 1, 2, 5, 10, 20, 50, 100 and 200");
  // Two frames of eleven bytes a sample.
  require(static_cast<std::size_t>(options.rate_hz) * 2 * kFrameBytes * 10 <=
              static_cast<std::size_t>(options.baud),
          "imu.rate_hz: too high for imu.baud");
  require(options.roll_pitch_yaw_deg.size() == 3, "imu.roll_pitch_yaw_deg: expected three numbers");
  robot_from_sensor_ =
      make_pose3(Eigen::Vector3d::Zero(), deg_to_rad(options.roll_pitch_yaw_deg[0]),
                 deg_to_rad(options.roll_pitch_yaw_deg[1]),
                 deg_to_rad(options.roll_pitch_yaw_deg[2]))
          .linear();
}

std::vector<ImuSample> ImuDriver::take_samples() { return std::exchange(samples_, {}); }

std::string ImuDriver::state() const {
  if (!alive_) return "no data from the sensor: is the baud rate right?";
  return "measuring, bias " + std::to_string(rad_to_deg(bias_.rad_per_s().z())) + " deg/s";
}

void ImuDriver::on_connection(bool connected, Utime now) {
  connected_ = connected;
  alive_ = false;
  parser_.clear();
  last_frame_ = now;
  next_setting_ = now;
  bias_.restart();
  acceleration_.setConstant(std::numeric_limits<double>::quiet_NaN());
}

void ImuDriver::receive(std::span<const uint8_t> bytes, Utime now) {
  parser_.push(bytes);
  while (const auto frame = parser_.next()) {
    // What waits behind it in the buffer has come after it.
    const double line_s =
        static_cast<double>(parser_.waiting() + 2 * kFrameBytes) * 10.0 / options_.baud;
    last_frame_ = now;
    alive_ = true;
    if (frame->kind == static_cast<uint8_t>(Kind::acceleration)) {
      acceleration_ = robot_from_sensor_ * vector_of(*frame, kMetresPerS2);
    } else if (frame->kind == static_cast<uint8_t>(Kind::rates)) {
      on_rates(robot_from_sensor_ * vector_of(*frame, kRadPerS),
               now - Duration::from_seconds(line_s));
    }
  }
}

void ImuDriver::on_rates(const Eigen::Vector3d& rates, Utime measured) {
  bias_.add(rates, measured);
  ImuSample sample;
  sample.utime = measured;
  sample.angular_velocity_rad_per_s = rates - bias_.rad_per_s();
  sample.acceleration_m_per_s2 = acceleration_;
  samples_.push_back(sample);
}

void ImuDriver::advance(Utime now, std::vector<uint8_t>& out) {
  if (!connected_) return;
  if ((now - last_frame_).seconds() > kSilentS) alive_ = false;
  if (now < next_setting_) return;
  // Once at the start, and again as long as nothing comes: the sensor may just be starting.
  next_setting_ =
      alive_ ? now + Duration::from_seconds(1e9) : now + Duration::from_seconds(kSettingS);
  const auto send = [&out](const Bytes& bytes) {
    out.insert(out.end(), bytes.begin(), bytes.end());
  };
  send(unlock_request());
  send(set_request(Register::content, kContentRatesAndAcceleration));
  send(set_request(Register::rate, *rate_code(options_.rate_hz)));
}

}  // namespace marco::drivers::imu
