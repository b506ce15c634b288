#pragma once

#include <random>
#include <string>

#include "drivers/ldlidar/codec.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::ldlidar {

/// An LD06 or LD19 unless changed.
struct LdlidarEmulatorOptions {
  int baud = 230'400;
  double samples_per_s = 4500.0;
  double turns_per_s = 10.0;
  double power_on_s = 2.0;  ///< from power until it talks
  double range_max_m = 12.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{9600, 1'000'000});
    v("samples_per_s", samples_per_s, Limits{1000.0, 50'000.0});
    v("turns_per_s", turns_per_s, Limits{2.0, 20.0});
    v("power_on_s", power_on_s, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
  }
};

LdlidarEmulatorOptions stl27l();

/// The laser as seen through its line. It receives nothing; at another baud rate a client reads
/// garbage.
class LdlidarEmulator final : public Emulator {
 public:
  LdlidarEmulator(LaserWorld world, const LdlidarEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  void power_cycle(Utime now);

 private:
  void send_packet();
  Utime sample_time(int64_t sample) const;
  double angle_deg(int64_t sample) const;

  LaserWorld world_;
  LdlidarEmulatorOptions options_;
  PacedOutput output_;
  int client_baud_ = 0;
  bool on_ = false;
  Utime start_;  ///< of sample 0
  int64_t next_sample_ = 0;
  std::mt19937 noise_{1};  ///< what a client at another speed reads
};

}  // namespace marco::drivers::ldlidar
