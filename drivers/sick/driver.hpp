#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/laser/scan_clock.hpp"
#include "drivers/sick/dialogue.hpp"
#include "drivers/sick/link.hpp"
#include "drivers/sick/options.hpp"

namespace marco::drivers::sick {

/// Turns value telegrams into scans with the time of every beam. A scan of 0.5 or 0.25 degrees is
/// interlaced: two or four turns of the mirror measure whole degrees each, one shifted against the
/// other, so that neighbouring beams lie a turn apart in time.
class ScanAssembler {
 public:
  /// @throws std::invalid_argument for options that the laser does not have.
  explicit ScanAssembler(const SickOptions& options);

  /// Takes a telegram of measured values, or counts why not.
  /// @param arrival  of its last byte
  void add(const Event& event, Utime arrival, int baud);
  void restart_clock() { clock_.reset(); }

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  LaserProperties properties() const;
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  double period_s() const { return options_.scan_period_s(); }
  const ClockFilter& filter() const { return clock_.filter(); }

 private:
  const char* reason_to_drop(const Event& event, const std::optional<MeasuredValues>& values) const;
  LaserScan scan_of(const MeasuredValues& values, Utime first_beam) const;

  SickOptions options_;
  RangeRule rule_;
  ScanClock clock_;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

/// Finds the laser at any baud rate, sets speed, variant and unit from the options, and starts the
/// stream of scans. Starts over when the laser falls silent, resets, or sends garbage.
///
/// Ranges: 0 for dazzled or faulty beams, properties().range_max_m where nothing came back.
class SickDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver. @throws std::invalid_argument for options that the laser
  /// does not have.
  SickDriver(ByteStream& stream, const SickOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override { return phase_ != Phase::finding; }
  LaserProperties properties() const override { return assembler_.properties(); }
  const LaserCounts& counts() const override { return assembler_.counts(); }
  void stop() override;

  bool measuring() const { return phase_ == Phase::measuring; }

 private:
  void enter(Phase phase);
  void ask();
  void ask_again_within(Duration rest);
  void try_next_baud_rate();
  void start_over(const std::string& why);
  void receive();
  void on_event(const Event& event, Utime arrival);
  void on_reply(const Event& event);
  void on_timeout();
  Duration silence_allowed() const;

  Clock clock_;
  SickLink link_;
  Dialogue dialogue_;
  ScanAssembler assembler_;
  Phase phase_ = Phase::finding;
  int tries_ = 0;
  bool streams_here_ = false;  ///< while finding: scans came since the last request
  bool acknowledged_ = false;  ///< while finding: the request was acknowledged, not yet answered
  Utime deadline_;             ///< of the phase; while measuring, of the next scan
  uint8_t status_ = kHealthy;
  std::string trouble_;
};

}  // namespace marco::drivers::sick
