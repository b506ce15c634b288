#pragma once

#include <string>
#include <vector>

#include "drivers/gamepad/codec.hpp"
#include "drivers/transport/serial_stream.hpp"

namespace marco::drivers::gamepad {

/// Reads a joystick device, or a FIFO that stands for one. A device that is not there or goes away
/// is looked for again every second; a FIFO without a writer only keeps silent.
class GamepadDriver {
 public:
  explicit GamepadDriver(std::string path) : path_(std::move(path)) {}

  /// Waits up to `timeout_ms`. @returns the states that came, the last the newest; one that says
  /// connected = false when the device was lost.
  std::vector<GamepadState> step(int timeout_ms, Utime now);
  bool open() const { return file_.valid(); }
  int64_t garbage_bytes() const { return reader_.garbage_bytes(); }

 private:
  void try_to_open(Utime now);

  std::string path_;
  FileHandle file_;
  bool fifo_ = false;
  RecordReader reader_;
  GamepadModel model_;
  Utime next_try_;
};

}  // namespace marco::drivers::gamepad
