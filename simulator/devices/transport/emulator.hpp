#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// A simulated device as seen through its line: bytes in, bytes out, in simulated time. It has no
/// clock, thread or port of its own: a test steps it directly, the live simulator runs it behind a
/// pseudo-terminal or a TCP port (EmulatorPort).
class Emulator {
 public:
  virtual ~Emulator() = default;

  /// Bytes the client sent, complete at `now`.
  /// @param baud  the speed the client's side of the line is set to; 0 = the line has none (TCP).
  virtual void receive(std::span<const uint8_t> bytes, int baud, Utime now) = 0;

  /// Steps the device to `now` and appends the bytes that have left it since the last call.
  /// A device on a serial line paces its bytes at its own baud rate.
  virtual void advance(Utime now, std::vector<uint8_t>& out) = 0;

  /// When advance() next has work; the far future when only receive() can cause some.
  virtual Utime next_event() const = 0;

  /// The client opened (true) or closed the line.
  virtual void on_connection(bool connected, Utime now) = 0;
};

}  // namespace marco::drivers
