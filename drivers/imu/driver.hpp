#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "drivers/imu/codec.hpp"
#include "drivers/imu/gyro_bias.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::imu {

struct ImuOptions {
  int baud = 9600;   ///< as delivered; 115200 for 100 samples a second and more
  int rate_hz = 20;  ///< set at the start, not saved in the sensor
  std::vector<double> roll_pitch_yaw_deg{0.0, 0.0, 0.0};  ///< of the sensor on the robot
  double still_deg_per_s = 1.0;  ///< slower for `still_s` counts as standing: the bias is learnt
  double still_s = 2.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{4800, 921600});
    v("rate_hz", rate_hz, Limits{1, 200});
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg);
    v("still_deg_per_s", still_deg_per_s, kPositive);
    v("still_s", still_s, kPositive);
  }
};

/// Driver of a WitMotion sensor without port or clock. Sets content and rate, again while nothing
/// comes, and estimates the gyroscope's bias whenever the robot stands. A sample's stamp is the
/// beginning of its first frame on the line.
class ImuDriver {
 public:
  static constexpr std::chrono::microseconds kStep{20'000};  ///< to wait for bytes

  explicit ImuDriver(const ImuOptions& options);

  void on_connection(bool connected, Utime now);
  void receive(std::span<const uint8_t> bytes, Utime now);
  void advance(Utime now, std::vector<uint8_t>& out);

  std::vector<ImuSample> take_samples();
  std::string state() const;
  bool alive() const { return alive_; }
  const Eigen::Vector3d& bias_rad_per_s() const { return bias_.rad_per_s(); }
  int64_t garbage_bytes() const { return parser_.garbage_bytes(); }

 private:
  void on_rates(const Eigen::Vector3d& rates, Utime measured);

  ImuOptions options_;
  Eigen::Matrix3d robot_from_sensor_;
  FrameParser parser_;
  std::vector<ImuSample> samples_;
  bool connected_ = false;
  bool alive_ = false;
  Utime last_frame_, next_setting_;
  Eigen::Vector3d acceleration_;
  GyroBias bias_;
};

}  // namespace marco::drivers::imu
