#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "drivers/laser/scan_clock.hpp"
#include "drivers/leuze/codec.hpp"
#include "drivers/leuze/options.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers::leuze {

/// The baud rate at which to listen for a laser that sends without being asked.
class SpeedSearch {
 public:
  /// @param wanted  listened at first; 0 = the line has no speed
  explicit SpeedSearch(int wanted);

  int current() const { return rates_[rate_]; }
  /// Whether this is not the rate at which the laser was understood last.
  bool exploring() const { return understood_ && *understood_ != rate_; }
  void on_bytes() { any_byte_ = true; }
  void on_telegram() { understood_ = rate_; }

  /// Nothing was understood at the current rate. Before the first telegram all rates are tried in
  /// turn. After it, the laser has most likely kept its speed: that rate is tried while the line is
  /// quiet, and every other time when there are bytes.
  /// @param lost  whether telegrams were understood until now: then the rate stays
  void next(bool lost);

 private:
  std::vector<int> rates_;
  std::size_t rate_ = 0;
  std::optional<std::size_t> understood_;  ///< the rate of the last telegram
  std::size_t other_ = 0;                  ///< tried last besides
  bool any_byte_ = false;                  ///< at this rate
};

/// Listens to the stream that the laser sends without being asked, at the baud rate of the options
/// or the one at which telegrams are understood.
class LeuzeDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver.
  LeuzeDriver(ByteStream& stream, const LeuzeOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override { return measuring_; }
  LaserProperties properties() const override { return options_.properties(); }
  const LaserCounts& counts() const override { return counts_; }

 private:
  void listen();
  void on_telegram(const Telegram& telegram, Utime arrival);

  ByteStream& stream_;
  LeuzeOptions options_;
  Clock clock_;
  TelegramParser parser_;
  SpeedSearch search_;
  ScanClock scan_clock_{kSweepS};
  bool measuring_ = false;
  Utime deadline_;
  std::string complaint_;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::leuze
