#pragma once

#include <string>

#include "drivers/rplidar/codec.hpp"
#include "drivers/rplidar/model.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::rplidar {

struct RplidarEmulatorOptions {
  int model = 0x18;           ///< A1; 0x28 = A2
  int baud = 115'200;         ///< 256000 for some A2
  double turns_per_s = 5.5;   ///< of the head
  double sample_s = 508e-6;   ///< standard scan
  double express_s = 254e-6;  ///< express scan
  double reset_s = 0.5;       ///< from a reset until it answers
  int health = 0;             ///< 0 good, 1 warning, 2 error
  int typical_mode = 1;       ///< told to newer tools: 0 standard, 1 express
  int capsules = kCapsules;   ///< of its usual scan; dense: C1, S2; ultra: A3, S1; ultra dense: S3
  double range_max_m = 12.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("model", model, Limits{0, 255});
    v("baud", baud, Limits{9600, 1'000'000});
    v("turns_per_s", turns_per_s, Limits{1.0, 20.0});
    v("sample_s", sample_s, Limits{1e-5, 1e-2});
    v("express_s", express_s, Limits{1e-5, 1e-2});
    v("reset_s", reset_s, kNotNegative);
    v("health", health, Limits{0, 2});
    v("typical_mode", typical_mode, Limits{0, 1});
    v("capsules", capsules, Limits{kCapsules, kUltraDenseCapsules});
    v("range_max_m", range_max_m, kPositive);
  }
};

RplidarEmulatorOptions a3();
RplidarEmulatorOptions s1();
RplidarEmulatorOptions c1();
RplidarEmulatorOptions s2();
RplidarEmulatorOptions s3();

/// The laser as seen through its line: information, health, the configuration queries of newer
/// tools, standard scans (nodes) and legacy express scans (capsules). The motor of an A1 always
/// turns (the DTR line of its USB bridge does not reach us), that of an A2 when the host sets its
/// PWM.
class RplidarEmulator final : public Emulator {
 public:
  RplidarEmulator(LaserWorld world, const RplidarEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  void power_cycle(Utime now);

 private:
  void handle(const Request& request, Utime now);
  void answer(uint8_t kind, const Bytes& data, Utime now);
  Bytes configuration_answer(const Bytes& question) const;
  void start_scan(uint8_t kind, Utime now);
  void send_batch();
  void send_nodes();
  void send_capsule();
  /// When the next block leaves: an ultra capsule encodes a sample relative to the next one.
  Utime next_batch() const {
    return sample_time(next_sample_ + batch() + (scan_kind_ == kUltraCapsules ? 1 : 0));
  }
  std::vector<int> measure_behind(int count) const;
  double sample_period_s() const;
  Utime sample_time(int64_t sample) const;
  double angle_deg(int64_t sample) const;
  /// @param behind_deg  how far the spots measured lie behind the samples' angles
  std::vector<double> measure(int count, double behind_deg = 0.0) const;
  int batch() const { return scan_kind_ == kNodes ? 8 : capsule_samples(scan_kind_); }
  /// C1: with the scan; A1: always.
  bool turns_by_itself() const {
    return family_of(options_.model) == 1 || family_of(options_.model) == 4;
  }

  LaserWorld world_;
  RplidarEmulatorOptions options_;
  RequestParser parser_;
  PacedOutput output_;
  Utime ready_;
  bool greeted_ = true;  ///< the boot text after a reset is out
  bool turning_ = true;
  uint8_t scan_kind_ = 0;
  bool first_capsule_ = false;
  Utime scan_start_;
  int64_t next_sample_ = 0;
};

}  // namespace marco::drivers::rplidar
