#pragma once

#include <string>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/sick/codec.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::sick {

struct SickOptions {
  int baud = 38400;             ///< to measure at: 9600, 19200, 38400 or 500000 (RS-422)
  int angle_deg = 180;          ///< 180 or 100
  double resolution_deg = 0.5;  ///< 1, 0.5 or (of 100 degrees) 0.25
  std::string unit = "mm";      ///< of the values: "mm" or "cm"
  int range_m = 32;             ///< mm: 8, 16, 32 (thesis B, app. B); cm: 80, 160, 320
  bool interlaced = false;      ///< each turn of the mirror as a scan of its own, 75 a second
  std::string password = "SICK_LMS";
  double range_min_m = 0.05;
  double range_sigma_m = 0.015;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{9600, 500000});
    v("angle_deg", angle_deg, Limits{100, 180});
    v("resolution_deg", resolution_deg, Limits{0.25, 1.0});
    v("unit", unit);
    v("range_m", range_m, Limits{8, 320});
    v("interlaced", interlaced);
    v("password", password);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Finds the laser at whatever speed it listens to, brings it to the speed, variant and unit of the
/// options (writing its EEPROM only if it differs), lets it stream and turns its telegrams into
/// scans. When it falls silent, resets itself or is read as garbage, it starts over.
///
/// A scan of 0.5 or 0.25 degrees is made by two or four turns of the mirror: its utime is its very
/// first beam's, time_offsets_s says when each of the others was measured. Ranges: 0 for dazzled or
/// faulty beams, sight().range_max_m where nothing came back.
class SickDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver. @throws std::invalid_argument for options the laser has
  /// not.
  SickDriver(ByteStream& stream, const SickOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_line_emptied() override;
  std::string state() const override;
  bool answers() const override { return phase_ != Phase::finding; }
  LaserSight sight() const override;
  const LaserCounts& counts() const override { return counts_; }
  void stop() override;

  bool measuring() const { return phase_ == Phase::measuring; }

 private:
  static constexpr Duration kModePatience = Duration::from_us(3'200'000);

  enum class Phase {
    finding,
    changing_baud,
    settling,
    checking_baud,
    asking_type,
    asking_status,
    setting_variant,
    reading_configuration,
    entering_installation,
    configuring,
    leaving_installation,
    starting,
    measuring,
  };
  enum class Answer { good, refused };

  void enter(Phase phase);
  Phase phase_after(Phase phase) const;
  Bytes request_of(Phase phase) const;
  uint8_t reply_code_of(Phase phase) const;
  Duration patience_of(Phase phase) const;
  void ask();
  void ask_again_within(Duration rest);
  void send(const Bytes& telegram);
  void set_baud(int baud);
  void look_elsewhere();
  void start_over(const std::string& why);
  void receive();
  void on_event(const Event& event, Utime arrival);
  void on_reply(const Event& event);
  Answer read_reply(const Event& event);
  void on_values(const Event& event, Utime arrival);
  void on_timeout();
  TurnCounter::Gap gap_before();
  ArrivedScan to_scan(const MeasuredValues& values, Utime first_beam, Utime arrival) const;
  int turns_per_scan() const;
  int resolution_cdeg() const;
  double scan_period_s() const;

  ByteStream& stream_;
  SickOptions options_;
  Clock clock_;
  TelegramParser parser_{TelegramParser::Side::laser};
  Phase phase_ = Phase::finding;
  std::vector<int> rates_;  ///< tried in turn while finding
  std::size_t rate_ = 0;
  int baud_ = 0;  ///< of our side
  int goal_baud_ = 0;
  int baud_failures_ = 0;
  int tries_ = 0;
  bool streams_here_ = false;  ///< while finding: scans came since the last request
  bool acknowledged_ = false;  ///< while finding: it was heard, but not answered yet
  Utime deadline_;
  Utime last_byte_;
  Utime settled_at_;
  Utime last_scan_;
  int measuring_mode_ = 0;
  Unit unit_ = Unit::mm;
  Configuration wanted_;
  bool configured_ = false;  ///< as wanted already
  std::string type_;
  std::string trouble_;
  uint8_t status_ = kHealthy;
  TurnCounter turns_;
  int64_t dropped_before_ = 0;  ///< telegrams dropped when the last scan was taken
  ClockFilter filter_;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::sick
