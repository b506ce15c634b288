#pragma once

#include <string>

#include "drivers/laser/scan_clock.hpp"
#include "drivers/leuze/codec.hpp"
#include "drivers/leuze/options.hpp"
#include "drivers/leuze/speed_search.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers::leuze {

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
