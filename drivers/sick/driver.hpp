#pragma once

#include <string>

#include "drivers/sick/dialogue.hpp"
#include "drivers/sick/link.hpp"
#include "drivers/sick/scan_assembler.hpp"

namespace marco::drivers::sick {

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
