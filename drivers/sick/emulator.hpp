#pragma once

#include <string>

#include "drivers/laser/laser_world.hpp"
#include "drivers/sick/codec.hpp"
#include "drivers/transport/emulator.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"

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
  double turn_s = 1.0 / 75.0;    ///< of the mirror

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

/// The laser as the line shows it: deaf and unreadable at a wrong speed, ACK and NAK, its modes,
/// variants, configuration and resets, scans in step with its mirror, of which it drops those the
/// line has no time for, means, parts and reflectivities. Modes of which no source shows the
/// replies (segments, fields, navigation) are refused. A scan of 0.5 or 0.25 degrees is made of two
/// or four turns of whole degrees, each asked of the world at its own time.
class SickEmulator final : public Emulator {
 public:
  SickEmulator(LaserWorld world, const SickEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  /// The power failed and came back at `now`.
  void power_cycle(Utime now);

  int baud() const { return baud_; }
  bool streaming() const;
  int64_t scans_sent() const { return scans_sent_; }
  int64_t scans_dropped() const { return scans_dropped_; }
  const Configuration& configuration() const { return configuration_; }

  /// What it sent last, for tests that compare value by value.
  const MeasuredValues& last_values() const { return last_values_; }
  Utime last_first_beam() const { return last_first_beam_; }

 private:
  void boot(Utime now);
  void finish_boot(Utime now);
  void handle(const Event& request, Utime now);
  bool take_arguments(uint8_t form, std::span<const uint8_t> data);
  bool ask_one(uint8_t form, std::span<const uint8_t> arguments, Utime now);
  bool accepts_mode(std::span<const uint8_t> data);
  void set_mode(std::span<const uint8_t> data, Utime now);
  void set_variant(std::span<const uint8_t> data, Utime now);
  void set_configuration(std::span<const uint8_t> data, Utime now);
  void reply(const Bytes& payload, Utime now, double after_s);
  void reply_status(Utime now);
  void start_measuring(uint8_t mode, Utime now);
  int turns_per_scan() const;
  bool partial_mode() const { return form_ == kPartialScans; }
  void finish_turn();
  Utime turn_end_time() const;
  void schedule_turn(Utime not_before);
  uint8_t reflectivity_of(uint16_t word) const;
  uint16_t word_of_range(double range_m) const;
  MeasuredValues measure(Utime first_beam) const;
  void garble(std::vector<uint8_t>& out, std::size_t from) const;

  LaserWorld world_;
  SickEmulatorOptions options_;
  TelegramParser parser_{TelegramParser::Side::host};
  PacedOutput output_;
  int baud_;
  int baud_after_reply_ = 0;
  int client_baud_ = 0;
  Utime boot_end_;
  bool booting_ = false;
  Utime mirror_start_;
  uint8_t mode_ = kOnRequest;
  uint8_t form_ = kOnRequest;                  ///< of the replies that are measured now, as a mode
  uint8_t samples_ = 0;                        ///< scans in a mean
  std::vector<std::vector<uint16_t>> summed_;  ///< of the mean that is coming
  bool installation_ = false;
  bool one_scan_asked_ = false;
  std::array<uint16_t, 2> sub_range_{1, 1};
  int angle_deg_ = 180;
  int resolution_cdeg_ = 50;
  Configuration configuration_;
  int64_t turn_end_ = 0;  ///< the number of the mirror's turn whose end is the next scan's end
  Utime last_byte_;
  int64_t scans_sent_ = 0;
  int64_t scans_dropped_ = 0;
  MeasuredValues last_values_;
  Utime last_first_beam_;
};

}  // namespace marco::drivers::sick
