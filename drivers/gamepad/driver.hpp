#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/gamepad/codec.hpp"
#include "drivers/transport/serial_stream.hpp"

namespace marco::drivers::gamepad {

/// Reads a joystick device, or a FIFO that stands for one. A device that is not there or goes away
/// is looked for again every second. A FIFO whose writer goes is a gamepad that was pulled; the
/// next writer brings it back.
class GamepadDriver {
 public:
  explicit GamepadDriver(std::string path) : path_(std::move(path)) {}

  static constexpr double kRepeatS = 0.1;

  /// Waits up to `timeout_ms`. @returns the states that came, the last the newest; the last one
  /// again each kRepeatS while the device is there; one that says connected = false when it was
  /// lost.
  std::vector<GamepadState> step(int timeout_ms, Utime now);
  /// At the end: what tells the others that it is gone; nothing when no state was ever told.
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
  std::optional<Utime> told_;  ///< when a state was last told of this device
  std::string trouble_;
};

}  // namespace marco::drivers::gamepad
