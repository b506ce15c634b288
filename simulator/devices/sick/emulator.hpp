#pragma once

#include <optional>
#include <string>

#include "drivers/sick/options.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/devices/sick/mirror.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::sick {

struct SickEmulatorOptions {
  std::string type = "LMS200;30106;V02.30";
  int address = 0x80;            ///< of its replies; the manuals print 80 and 81
  int baud = 9600;               ///< after power-on
  bool permanent_baud = false;   ///< keeps the speed last set over a reset
  bool polluted = false;         ///< complains of a dirty window
  double power_on_s = 8.0;       ///< until it speaks; up to 60 on the device
  double reply_s = 0.010;        ///< to ACK; the reply follows it
  double mode_change_s = 0.030;  ///< up to 3 on the device
  double configure_s = 0.3;      ///< writing its EEPROM; up to 7 on the device
  double turn_s = kTurnS;        ///< of the mirror

  template <class Visitor>
  void visit(Visitor& v) {
    v("type", type);
    v("address", address, Limits{0x80, 0xFF});
    v("baud", baud, Limits{9600, 500000});
    v("permanent_baud", permanent_baud);
    v("polluted", polluted);
    v("power_on_s", power_on_s, kNotNegative);
    v("reply_s", reply_s, Limits{0.0, 0.06});
    v("mode_change_s", mode_change_s, kNotNegative);
    v("configure_s", configure_s, kNotNegative);
    v("turn_s", turn_s, Limits{0.005, 0.1});
  }
};

/// The laser as seen through its line. Deaf and unreadable at a wrong baud rate. Has ACK and NAK,
/// modes, variants, configuration and resets; means, sub-ranges and reflectivities. Scans are in
/// step with its mirror; those for which the line has no time are dropped. Refuses the modes whose
/// replies no source documents (segments, fields, navigation).
class SickEmulator final : public Emulator {
 public:
  SickEmulator(LaserWorld world, const SickEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  /// The power failed and came back at `now`.
  void power_cycle(Utime now);

  int baud() const { return speed_.baud; }
  bool streaming() const;
  int64_t scans_sent() const { return scans_sent_; }
  int64_t scans_dropped() const { return scans_dropped_; }
  const Configuration& configuration() const { return configuration_; }
  Utime last_first_beam() const { return mirror_.last_first_beam(); }

 private:
  /// Baud rates; of the client 0 = the line has none.
  struct Speed {
    int baud;
    int after_reply = 0;  ///< 0 = no change
    int client = 0;
  };

  void boot(Utime now);
  void finish_boot(Utime now);
  bool measuring() const { return streaming() || one_scan_asked_; }
  void handle(const Event& request, Utime now);
  std::optional<SickMirror::Form> form_of(uint8_t mode, std::span<const uint8_t> data) const;
  bool ask_one(uint8_t form, std::span<const uint8_t> arguments, Utime now);
  bool accepts_mode(std::span<const uint8_t> data) const;
  void set_mode(std::span<const uint8_t> data, Utime now);
  void set_variant(std::span<const uint8_t> data, Utime now);
  void set_configuration(std::span<const uint8_t> data, Utime now);
  void reply(const Bytes& payload, Utime now, double after_s);
  void reply_status(Utime now);
  uint8_t status_byte() const;
  void finish_scan();
  void garble(std::vector<uint8_t>& out, std::size_t from) const;

  SickEmulatorOptions options_;
  TelegramParser parser_{TelegramParser::Side::host};
  PacedOutput output_;
  SickMirror mirror_;
  Speed speed_;
  std::optional<Utime> boot_end_;  ///< while it boots
  uint8_t mode_ = kOnRequest;
  bool one_scan_asked_ = false;
  Configuration configuration_;
  Utime last_byte_;
  int64_t scans_sent_ = 0;
  int64_t scans_dropped_ = 0;
};

}  // namespace marco::drivers::sick
