#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers {

/// Diagnoses an open line whose device does not answer: silence, or bytes that make no telegrams.
/// Has no clock of its own.
class LineWatch {
 public:
  static constexpr double kSilentS = 3.0;
  static constexpr double kGarbledS = 10.0;  ///< long enough to search for the baud rate
  static constexpr int64_t kGarbledBytes = 32;

  enum class Trouble { none, silent, garbled };

  explicit LineWatch(std::string address) : address_(std::move(address)) {}

  void on_line(const LineSettings& line) { bauds_.insert(line.baud); }
  void on_bytes(std::span<const uint8_t> bytes);
  /// Call at each step. @param answers  whether the device's telegrams are understood now.
  /// @param now_s  any clock; time between two steps counts up to half a second.
  Trouble judge(bool answers, double now_s);
  /// What is wrong and what to do, in one line; "" without trouble.
  std::string text() const;

 private:
  std::string where() const;
  std::string guess() const;

  std::string address_;
  std::set<int> bauds_;  ///< tried since it answered
  std::optional<double> clock_s_;
  double deaf_s_ = 0.0;   ///< since it answered
  double quiet_s_ = 0.0;  ///< since the last byte
  int64_t count_ = 0;     ///< bytes since it answered; and of these:
  int64_t printable_ = 0, zeros_ = 0, ones_ = 0;
  std::vector<uint8_t> first_;
  Trouble trouble_ = Trouble::none;
};

/// Forwards everything, and reports it to a watch.
class WatchedStream final : public ByteStream {
 public:
  /// Both outlive it.
  WatchedStream(ByteStream& stream, LineWatch& watch) : stream_(stream), watch_(watch) {}

  std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) override {
    const std::size_t count = stream_.read(into, timeout);
    watch_.on_bytes(into.first(count));
    return count;
  }
  void write(std::span<const uint8_t> bytes) override { stream_.write(bytes); }
  void set_line(const LineSettings& line) override {
    stream_.set_line(line);
    watch_.on_line(line);
  }
  void discard_input() override { stream_.discard_input(); }
  void set_dtr(bool raised) override { stream_.set_dtr(raised); }
  int descriptor() const override { return stream_.descriptor(); }

 private:
  ByteStream& stream_;
  LineWatch& watch_;
};

}  // namespace marco::drivers
