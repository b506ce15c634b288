#pragma once

#include <string>

#include "drivers/cola/codec.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::cola {

/// A TiM561 unless changed.
struct ColaEmulatorOptions {
  std::string model = "TiM561";
  double turns_per_s = 15.0;
  int step_e4 = 3333;       ///< 1/10000 deg
  int beams = 811;          ///< from -45 deg, counter-clockwise; 90 deg is ahead
  double power_on_s = 5.0;  ///< until it answers
  double warm_up_s = 1.0;   ///< from then on, until it is ready
  bool login = true;        ///< false: it answers 0 to it, and takes settings all the same
  bool binary = false;      ///< speaks CoLa B
  double range_max_m = 10.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("model", model);
    v("turns_per_s", turns_per_s, Limits{1.0, 100.0});
    v("step_e4", step_e4, Limits{100, 100'000});
    v("beams", beams, Limits{2, 4000});
    v("power_on_s", power_on_s, kNotNegative);
    v("warm_up_s", warm_up_s, kNotNegative);
    v("login", login);
    v("binary", binary);
    v("range_max_m", range_max_m, kPositive);
  }
};

ColaEmulatorOptions tim551();
ColaEmulatorOptions lms111();

/// The laser as seen through its connection: identity, state, login, single scans, streams, with
/// intensities when asked for. It does not measure while somebody is logged in.
class ColaEmulator final : public Emulator {
 public:
  ColaEmulator(LaserWorld world, const ColaEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  void power_cycle(Utime now);
  bool streaming() const { return streaming_; }
  /// In the status of scans from now on: 1 error, 2 dirty window.
  void set_status(uint32_t status) { status_ = status; }

 private:
  std::string answer_to(const std::string& text, Utime now);
  std::string answer_method(const std::string& name, const std::string& text, Utime now);
  ScanData measure(int64_t turn);
  Utime begin_of(int64_t turn) const;
  Utime sent_at(int64_t turn) const;
  /// The first turn that begins after.
  int64_t turn_after(Utime when) const;
  uint32_t clock_us(Utime when) const;

  LaserWorld world_;
  ColaEmulatorOptions options_;
  TelegramParser parser_;
  PacedOutput output_;
  Utime power_on_;  ///< 0 before
  Utime ready_;
  bool streaming_ = false;
  bool single_ = false;  ///< the next scan answers a request
  bool logged_in_ = false;
  bool intensities_ = false;
  int64_t next_turn_ = 0;
  uint32_t scans_ = 0;
  uint32_t status_ = 0;
};

}  // namespace marco::drivers::cola
