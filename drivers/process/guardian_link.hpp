#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "drivers/process/guardian_beat.hpp"
#include "drivers/transport/serial_stream.hpp"

namespace marco::drivers {

/// The driver's side of marco-guardian, the process that stops a device when its driver hangs or
/// dies (docs/stopping.md). One thread at a time.
class GuardianLink {
 public:
  /// @param arguments  of marco-guardian
  explicit GuardianLink(std::vector<std::string> arguments);
  ~GuardianLink();
  GuardianLink(const GuardianLink&) = delete;
  GuardianLink& operator=(const GuardianLink&) = delete;

  /// Starts a guardian unless one is at work. Waits for it up to 5 s. @throws StreamLost.
  void start();

  /// Shares the line with it. @throws StreamLost when it does not answer.
  void share(int line);
  /// It closes the line. One that does not is killed.
  void let_go() noexcept;

  /// A step has ended and its bytes were sent. @param stop_bytes  what stops the device now; empty:
  /// nothing moves. @throws StreamLost when the guardian has ended or hangs.
  void beat(const std::vector<uint8_t>& stop_bytes);

  /// Whether this process stood still for 0.5 s, or the guardian has stopped the device. It lasts
  /// until take_hang_s(): what a late process decided before must not be sent.
  bool late() const;
  /// @returns how long it stood still; 0 = it is not late.
  double take_hang_s();
  const std::vector<uint8_t>& stop_bytes() const { return stop_bytes_; }

 private:
  void spawn();
  bool send(GuardianWord word, const std::vector<uint8_t>& bytes, int descriptor = -1) const;
  bool await(GuardianWord word, int timeout_ms);
  void end_it();

  std::vector<std::string> arguments_;
  FileHandle memory_;
  GuardianBeat* shared_;
  FileHandle socket_;
  pid_t pid_ = 0;
  std::vector<uint8_t> stop_bytes_;
  int64_t its_beat_ns_ = 0;
  int64_t its_silence_ns_ = 0;  ///< of this process's own time
};

/// A line that is shared with a guardian: what a late driver writes becomes a stop.
class GuardedStream final : public ByteStream {
 public:
  /// Both outlive it. @throws as GuardianLink::share.
  GuardedStream(ByteStream& stream, GuardianLink& guardian);
  ~GuardedStream() override { guardian_.let_go(); }
  GuardedStream(const GuardedStream&) = delete;
  GuardedStream& operator=(const GuardedStream&) = delete;

  std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) override;
  void write(std::span<const uint8_t> bytes) override;
  void set_line(const LineSettings& line) override { stream_.set_line(line); }
  void discard_input() override { stream_.discard_input(); }

  /// Called from read(), where a driver mostly is when it hangs, with the seconds for which it did.
  std::function<void(double)> on_hang;

 private:
  ByteStream& stream_;
  GuardianLink& guardian_;
};

}  // namespace marco::drivers
