#pragma once

#include <optional>
#include <string>

#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/devices/hokuyo/mirror.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::hokuyo {

struct HokuyoEmulatorOptions {
  std::string model = "URG-04LX";  ///< or "UTM-30LX", "UST-10LX"
  int baud = 0;                    ///< after power-on: 19200 on RS-232; 0 = USB or TCP, no speed
  double reply_s = 0.002;
  double start_s = 0.3;  ///< from a reset until it answers
  bool scip1 = false;    ///< old firmware: speaks SCIP 1.1 until it receives "SCIP2.0"

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

/// The laser as seen through its line: version, parameters, state, speed, time, single scans and
/// streams. A UTM-30LX has intensities and the replies for several echoes (its world has one). Old
/// firmware speaks SCIP 1.1 (V, L, S, G). Time stamps are milliseconds since power-on, of the
/// mirror's passing the rear before a scan.
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
  Utime last_first_beam() const { return mirror_.last_first_beam(); }

 private:
  struct Speed {
    int baud;
    int after_reply = 0;  ///< 0 = no change
  };
  struct Reboot {
    bool asked = false;  ///< one RB was received; the second one is obeyed
    std::optional<Utime> at;
  };
  /// Scans that are being sent, one or many.
  struct Stream {
    ScanRequest request;
    std::string tag;
    int remaining;
    int64_t turn;  ///< of the next scan
  };

  bool is_urg() const { return options_.model == "URG-04LX"; }
  /// Ethernet alone: no speed to set, never another protocol.
  bool is_ust() const { return options_.model == "UST-10LX"; }
  void handle(const std::string& line, Utime now);
  void answer(const Reply& reply, const std::string& tag, Utime now);
  void handle_scip1(const std::string& line, Utime now);
  std::string handle_time(const std::string& line);
  std::string handle_state(const std::string& line, Utime now);
  void handle_scan(const std::string& line, const std::string& tag, Utime now);
  void handle_speed(const std::string& line, const std::string& tag, Utime now);
  void finish_scan();
  Utime scan_end() const;

  HokuyoEmulatorOptions options_;
  HokuyoMirror mirror_;
  PacedOutput output_;
  Speed speed_;
  std::string line_;
  Utime ready_;
  bool laser_on_ = false;
  bool scip1_ = false;   ///< speaks it now
  bool timing_ = false;  ///< between TM0 and TM2
  Reboot reboot_;
  std::optional<Stream> stream_;
  int64_t scans_sent_ = 0;
};

}  // namespace marco::drivers::hokuyo
