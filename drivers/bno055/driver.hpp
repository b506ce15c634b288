#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "drivers/bno055/codec.hpp"
#include "drivers/imu/gyro_bias.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::bno055 {

struct Bno055Options {
  int rate_hz = 100;
  std::vector<double> roll_pitch_yaw_deg{0.0, 0.0, 0.0};  ///< of the sensor on the robot
  double still_deg_per_s = 1.0;  ///< slower for `still_s` counts as standing: the bias is learnt
  double still_s = 2.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("rate_hz", rate_hz, Limits{1, 100});
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg);
    v("still_deg_per_s", still_deg_per_s, kPositive);
    v("still_s", still_s, kPositive);
  }
};

/// Driver of a BNO055 without port or clock. Sets units and mode, then reads acceleration and
/// rates; sets it up again when it falls silent, or when a power cut has put it back into its first
/// mode. A sample's stamp is the beginning of its reply on the line.
class Bno055Driver {
 public:
  static constexpr std::chrono::microseconds kStep{1000};  ///< to wait for bytes

  explicit Bno055Driver(const Bno055Options& options);

  void on_connection(bool connected, Utime now);
  void receive(std::span<const uint8_t> bytes, Utime now);
  void advance(Utime now, std::vector<uint8_t>& out);

  std::vector<ImuSample> take_samples();
  std::string state() const;
  bool alive() const { return alive_; }
  const Eigen::Vector3d& bias_rad_per_s() const { return bias_.rad_per_s(); }
  int64_t overruns() const { return overruns_; }

 private:
  enum class Phase { asking_id, configuring, setting_units, starting, checking_mode, reading };

  void enter(Phase phase, Utime when);
  void on_reply(const Reply& reply, Utime left, Utime now);
  void on_refusal(uint8_t code, Utime now);
  void on_motion(const Bytes& data, Utime measured);
  Bytes request() const;

  Bno055Options options_;
  Eigen::Matrix3d robot_from_sensor_;
  ReplyParser parser_;
  imu::GyroBias bias_;
  std::vector<ImuSample> samples_;
  Phase phase_ = Phase::asking_id;
  bool connected_ = false;
  bool alive_ = false;
  bool asked_ = false;  ///< an answer is awaited, until:
  Utime deadline_;
  Utime next_request_, next_check_, next_sample_;
  int64_t overruns_ = 0;
  int overruns_in_a_row_ = 0;
};

}  // namespace marco::drivers::bno055
