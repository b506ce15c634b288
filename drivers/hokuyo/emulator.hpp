#pragma once

#include <optional>
#include <string>

#include "drivers/hokuyo/codec.hpp"
#include "drivers/laser/laser_world.hpp"
#include "drivers/transport/emulator.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::hokuyo {

struct HokuyoEmulatorOptions {
  std::string model = "URG-04LX";  ///< or "UTM-30LX"
  int baud = 0;                    ///< after power-on: 19200 on RS-232; 0 = USB or TCP, no speed
  double reply_s = 0.002;
  double start_s = 0.3;  ///< from a reset until it answers
  bool scip1 = false;    ///< old firmware: speaks SCIP 1.1 until it hears "SCIP2.0"

  template <class Visitor>
  void visit(Visitor& v) {
    v("model", model);
    v("baud", baud, Limits{0, 750'000});
    v("reply_s", reply_s, kNotNegative);
    v("start_s", start_s, kNotNegative);
    v("scip1", scip1);
  }
};

Parameters parameters_of_model(const std::string& model);

/// The laser as the line shows it: version, parameters, state, speed, time, one scan or streams,
/// with intensities and in the form for several echoes (of which its world has one) on a UTM-30LX;
/// SCIP 1.1 (V, L, S, G) where the firmware is old.
/// Its time stamps are milliseconds since power-on, of the rear passing before a scan.
class HokuyoEmulator final : public Emulator {
 public:
  HokuyoEmulator(LaserWorld world, const HokuyoEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  void power_cycle(Utime now);
  bool streaming() const { return stream_.has_value(); }
  int64_t scans_sent() const { return scans_sent_; }
  Utime last_first_beam() const { return last_first_beam_; }
  const Measurement& last_measurement() const { return last_measurement_; }

 private:
  void handle(const std::string& line, Utime now);
  void answer(Reply reply, const std::string& tag, Utime now);
  void handle_scip1(const std::string& line, Utime now);
  std::string scip1_scan(int first_step, int last_step, int cluster, Utime now) const;
  std::string handle_time(const std::string& line);
  uint32_t clock_ms(Utime now) const;
  std::string handle_state(const std::string& line, Utime now);
  void handle_scan(const std::string& line, const std::string& tag, Utime now);
  void handle_speed(const std::string& line, const std::string& tag, Utime now);
  void schedule(Utime not_before);
  void finish_scan();
  double turn_s() const { return 60.0 / parameters_.rpm; }
  Utime turn_start(int64_t turn) const;
  double from_rear_s(int step) const;

  LaserWorld world_;
  HokuyoEmulatorOptions options_;
  Parameters parameters_;
  PacedOutput output_;
  int baud_;
  int baud_after_reply_ = 0;
  std::string line_;
  Utime power_on_;
  Utime ready_;
  bool laser_on_ = false;
  bool scip1_ = false;         ///< speaks it now
  bool timing_ = false;        ///< between TM0 and TM2
  bool reboot_asked_ = false;  ///< one RB was heard; the second obeys
  std::optional<Utime> reboot_;
  std::optional<ScanRequest> stream_;
  std::string stream_tag_;
  int remaining_ = 0;
  int64_t turn_ = 0;  ///< of the next scan
  int64_t scans_sent_ = 0;
  Utime last_first_beam_;
  Measurement last_measurement_;
};

}  // namespace marco::drivers::hokuyo
