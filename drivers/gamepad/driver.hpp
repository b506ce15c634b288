#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/gamepad/codec.hpp"
#include "drivers/transport/serial_stream.hpp"

namespace marco::drivers::gamepad {

/// Reads a joystick device, or a FIFO in its place. A missing or lost device is opened again every
/// second. A FIFO whose writer closes is an unplugged gamepad; the next writer plugs it in again.
class GamepadDriver {
 public:
  explicit GamepadDriver(std::string path) : path_(std::move(path)) {}

  static constexpr double kRepeatS = 0.1;

  /// Waits up to `timeout_ms`. @returns the new states, oldest first; without any, the last one
  /// each kRepeatS while the device is there; a state with connected = false when it was lost.
  std::vector<GamepadState> step(int timeout_ms, Utime now);
  /// At the end: the message that it has disconnected; nothing if no state was ever sent.
  std::optional<GamepadState> leave(Utime now);
  bool open() const { return file_.valid(); }
  /// Why the device is not open; "" when it is.
  const std::string& trouble() const { return trouble_; }
  int64_t garbage_bytes() const { return reader_.garbage_bytes(); }

 private:
  void try_to_open(Utime now);
  GamepadState lose(Utime now);

  std::string path_;
  FileHandle file_;
  bool fifo_ = false;
  RecordReader reader_;
  GamepadModel model_;
  Utime next_try_;
  std::optional<Utime> told_;  ///< when a state of this device was last sent
  std::string trouble_;
};

}  // namespace marco::drivers::gamepad
