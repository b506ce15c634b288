#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/leuze/codec.hpp"
#include "drivers/leuze/options.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers::leuze {

/// A stream that opens a connection for each write() and closes the one before. Without a
/// connection, read() only lets time pass.
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

/// Asks thesis A's service for a scan every poll_s. The service gives no time: the scan is assumed
/// to have ended half a sweep before the answer, an error of 20 ms at most.
class LeuzeServiceDriver final : public LaserDriver {
 public:
  /// @param stream  a ConnectionPerRequest; outlives the driver.
  LeuzeServiceDriver(ByteStream& stream, const LeuzeOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override { return counts_.scans > 0; }
  LaserProperties properties() const override { return options_.properties(); }
  const LaserCounts& counts() const override { return counts_; }

 private:
  void end_request();

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
