#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

namespace marco::drivers {

/// The device is gone: unplugged, closed by its peer, or its port has vanished. A driver catches
/// it, reports it in its status, and reopens the stream.
class StreamLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class Parity { none, even, odd };

/// How a serial line is driven. A TCP stream ignores it.
struct LineSettings {
  int baud = 9600;  ///< any rate the port can do, 500000 among them
  Parity parity = Parity::none;
};

/// Bytes to and from one device: a serial port, a pseudo-terminal or a TCP connection.
/// One thread at a time.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  /// Waits for bytes or the timeout.
  /// @returns the number of bytes written to the head of `into`; 0 after the timeout.
  /// @throws StreamLost when the device is gone.
  virtual std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) = 0;

  /// Sends all of them. @throws StreamLost when the device is gone, or takes no bytes for 0.4 s:
  /// those that wait are discarded, because an order must not arrive late.
  virtual void write(std::span<const uint8_t> bytes) = 0;

  /// Changes the line after everything written has left. @throws StreamLost.
  virtual void set_line(const LineSettings& line) = 0;

  /// Discards the bytes received and not read.
  virtual void discard_input() = 0;

  /// Raises or lowers the modem line DTR, which switches the motor of some devices. Ignored without
  /// modem lines (TCP, pseudo-terminal).
  virtual void set_dtr(bool /*raised*/) {}

  /// The line itself, for a process that shares it; -1 = there is none.
  virtual int descriptor() const { return -1; }
};

/// @param address  a device path, "serial:PATH", or "tcp:HOST:PORT".
/// A serial port is locked for this process, so that a second driver on it is refused.
/// @throws std::invalid_argument when the address cannot be read, or another process holds the
/// port; StreamLost when nothing answers there now.
std::unique_ptr<ByteStream> open_stream(const std::string& address, const LineSettings& line);

}  // namespace marco::drivers
