#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/leuze/codec.hpp"
#include "drivers/leuze/geometry.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::leuze {

struct LeuzeOptions {
  int baud = 57'600;     ///< 4800..115200; 0 = TCP
  bool service = false;  ///< thesis A's socket service instead of the laser itself
  double poll_s = 0.4;   ///< of the service: time from a scan to the next
  LeuzeGeometry geometry;
  double range_min_m = 0.1;
  double range_max_m = 64.0;
  double range_sigma_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{0, 115'200});
    v("service", service);
    v("poll_s", poll_s, kNotNegative);
    v("geometry", geometry);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Listens to the laser's stream, at the speed of the options or whichever makes sense.
class LeuzeDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver.
  LeuzeDriver(ByteStream& stream, const LeuzeOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_line_emptied() override;
  std::string state() const override;
  bool answers() const override { return measuring_; }
  LaserSight sight() const override;
  const LaserCounts& counts() const override { return counts_; }

 private:
  void listen_at(std::size_t rate);
  void listen_on();
  void on_telegram(const Telegram& telegram, Utime arrival);

  ByteStream& stream_;
  LeuzeOptions options_;
  Clock clock_;
  TelegramParser parser_;
  std::vector<int> rates_;
  std::size_t rate_ = 0;
  std::optional<std::size_t> good_rate_;  ///< at which it was heard last
  std::size_t other_ = 0;                 ///< looked at last besides
  bool heard_ = false;                    ///< any byte since listening at this rate
  bool measuring_ = false;
  Utime deadline_;
  std::string complaint_;
  TurnCounter turns_{kSweepS};
  int64_t bad_before_ = 0;  ///< checksums, when the last scan was taken
  ClockFilter filter_;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

/// A stream of which each write() goes through a connection of its own: the one before is closed.
/// Between them read() only lets time pass.
class ConnectionPerRequest final : public ByteStream {
 public:
  using Connect = std::function<std::unique_ptr<ByteStream>()>;

  /// @param connect  throws StreamLost when nobody answers.
  explicit ConnectionPerRequest(Connect connect) : connect_(std::move(connect)) {}

  std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) override;
  void write(std::span<const uint8_t> bytes) override;
  void set_line(const LineSettings&) override {}
  void discard_input() override { connection_.reset(); }

 private:
  Connect connect_;
  std::unique_ptr<ByteStream> connection_;
};

/// Asks thesis A's service for a scan every poll_s. It tells no time: a scan is taken for one that
/// ended half a sweep before the answer, which errs by 20 ms at most.
class LeuzeServiceDriver final : public LaserDriver {
 public:
  /// @param stream  a ConnectionPerRequest; outlives the driver.
  LeuzeServiceDriver(ByteStream& stream, const LeuzeOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_line_emptied() override;
  std::string state() const override;
  bool answers() const override { return counts_.scans > 0; }
  LaserSight sight() const override;
  const LaserCounts& counts() const override { return counts_; }

 private:
  ByteStream& stream_;
  LeuzeOptions options_;
  Clock clock_;
  bool waiting_ = false;
  Utime next_request_;
  Utime deadline_;
  Bytes answer_;
  LaserCounts counts_;
};

}  // namespace marco::drivers::leuze
