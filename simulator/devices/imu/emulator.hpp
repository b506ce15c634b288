#pragma once

#include <functional>
#include <random>

#include "drivers/imu/codec.hpp"
#include "drivers/transport/paced_output.hpp"
#include "simulator/devices/transport/emulator.hpp"

#include <Eigen/Core>

namespace marco::drivers::imu {

/// What the sensor feels at a moment, robot frame.
struct Motion {
  Eigen::Vector3d rates_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_m_per_s2{0.0, 0.0, kGravity};  ///< gravity included
};

struct ImuEmulatorOptions {
  int baud = 9600;
  double rate_noise_deg_per_s = 0.05;  ///< standard deviation of a sample
  double acceleration_noise_m_per_s2 = 0.02;
  double bias_deg_per_s = 0.4;            ///< of the yaw rate at power-on
  double drift_deg_per_s_sqrt_s = 0.002;  ///< random walk of the bias
  uint64_t seed = 1;
};

/// A WT901: streams acceleration, rates and angles at 10 Hz unless configured otherwise.
class ImuEmulator : public Emulator {
 public:
  ImuEmulator(std::function<Motion(Utime)> motion, const ImuEmulatorOptions& options = {});

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override { return next_sample_; }
  void on_connection(bool connected, Utime now) override;

  double bias_deg_per_s() const { return bias_deg_per_s_; }
  int rate_hz() const { return rate_hz_; }

 private:
  void measure(Utime when);
  void execute(uint8_t which, uint16_t value);

  std::function<Motion(Utime)> motion_;
  ImuEmulatorOptions options_;
  std::mt19937_64 random_;
  PacedOutput output_;
  Bytes command_;
  bool unlocked_ = false;
  bool readable_ = true;     ///< the client listens at our speed
  uint16_t content_ = 0x0E;  ///< acceleration, rates, angles
  int rate_hz_ = 10;
  double bias_deg_per_s_;
  Utime next_sample_;
};

}  // namespace marco::drivers::imu
