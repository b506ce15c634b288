#pragma once

#include <array>
#include <functional>
#include <random>

#include "drivers/bno055/codec.hpp"
#include "drivers/transport/paced_output.hpp"
#include "simulator/devices/imu/emulator.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::bno055 {

struct Bno055EmulatorOptions {
  double start_s = 0.65;      ///< from power until it answers
  double overrun_part = 0.1;  ///< share of the reads that it has no time for
  double slow_part = 0.01;    ///< share of the answers that take 0.2 s
  double rate_noise_deg_per_s = 0.05;
  double bias_deg_per_s = 0.2;  ///< of the yaw rate
  uint64_t seed = 1;
};

/// The sensor as seen through its line: registers, modes, overruns. Measures only in a mode of
/// fusion.
class Bno055Emulator : public Emulator {
 public:
  Bno055Emulator(std::function<imu::Motion(Utime)> motion,
                 const Bno055EmulatorOptions& options = {});

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override { output_.advance(now, out); }
  Utime next_event() const override { return output_.next_event(); }
  void on_connection(bool connected, Utime now) override;

  /// As after a brown-out: all registers are as delivered.
  void power_cycle(Utime now);
  Mode mode() const { return static_cast<Mode>(registers_[0x3D]); }

 private:
  Bytes answer_to(const Request& request, Utime now);
  void measure(Utime now);

  std::function<imu::Motion(Utime)> motion_;
  Bno055EmulatorOptions options_;
  std::mt19937_64 random_;
  RequestParser parser_;
  PacedOutput output_{kBaud};
  std::array<uint8_t, 256> registers_{};
  Utime ready_;
};

}  // namespace marco::drivers::bno055
