#pragma once

#include <random>
#include <string>

#include "drivers/transport/paced_output.hpp"
#include "drivers/ydlidar/codec.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::ydlidar {

/// An X4 unless changed.
struct YdlidarEmulatorOptions {
  int baud = 128'000;
  int model = 6;
  double samples_per_s = 5000.0;
  double turns_per_s = 7.0;
  bool hears = true;          ///< false: an X2 talks from its power-on
  int health_command = 0x91;  ///< the one it knows
  int health = 0;             ///< 0 good, 1 warning, 2 error
  int intensity_bytes = 0;    ///< 1: a B model; 2: time of flight
  double power_on_s = 0.5;    ///< until it answers
  double spin_up_s = 0.5;     ///< from the start until samples come
  double range_max_m = 10.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{9600, 1'000'000});
    v("model", model, Limits{0, 255});
    v("samples_per_s", samples_per_s, Limits{1000.0, 20'000.0});
    v("turns_per_s", turns_per_s, Limits{2.0, 20.0});
    v("hears", hears);
    v("health_command", health_command, Limits{0, 255});
    v("health", health, Limits{0, 2});
    v("intensity_bytes", intensity_bytes, Limits{0, 2});
    v("power_on_s", power_on_s, kNotNegative);
    v("spin_up_s", spin_up_s, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
  }
};

YdlidarEmulatorOptions x2();
YdlidarEmulatorOptions g4();

/// The laser as seen through its line. A triangulating one measures each sample beside the angle it
/// reports, as the real one does. At another baud rate it receives nothing, and a client reads
/// garbage.
class YdlidarEmulator final : public Emulator {
 public:
  YdlidarEmulator(LaserWorld world, const YdlidarEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  void power_cycle(Utime now);

 private:
  void handle(uint8_t command, Utime now);
  void answer(uint8_t kind, const Bytes& data, Utime now);
  Bytes info() const;
  void start_scan(Utime now);
  int next_count() const;
  void send_packet();
  Sample measure(int64_t sample);
  Utime sample_time(int64_t sample) const;
  double angle_deg(int64_t sample) const;
  bool starts_turn(int64_t sample) const;

  LaserWorld world_;
  YdlidarEmulatorOptions options_;
  SampleForm form_;
  PacedOutput output_;
  bool marked_ = false;  ///< the byte A5 came, the command is next
  int client_baud_ = 0;
  bool on_ = false;
  Utime ready_;
  bool scanning_ = false;
  Utime scan_start_;
  int64_t next_sample_ = 0;
  double last_range_mm_ = 1000.0;
  std::mt19937 noise_{1};  ///< what a client at another speed reads
};

}  // namespace marco::drivers::ydlidar
