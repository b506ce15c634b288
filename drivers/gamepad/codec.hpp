#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "drivers/transport/unread_bytes.hpp"

/// Records of the Linux joystick interface (/dev/input/jsN), eight bytes each: time u32 [ms] |
/// value s16 | type u8 (1 button, 2 axis, + 80 in the initial report) | number u8.
namespace marco::drivers::gamepad {

struct Event {
  enum class Kind : uint8_t { button = 1, axis = 2 };
  uint32_t time_ms = 0;
  int16_t value = 0;  ///< axis -32767 (left, up) .. 32767; button 0 or 1
  Kind kind = Kind::axis;
  bool initial = false;
  uint8_t number = 0;
  bool operator==(const Event&) const = default;
};
std::vector<uint8_t> encode_event(const Event& event);

/// Cuts a stream into records, however a FIFO splits it. Bytes that cannot be a record are passed
/// over one by one and counted, so that a lost byte costs some records, not all that follow.
class RecordReader : public UnreadParser {
 public:
  std::optional<Event> next();
};

/// State of a gamepad after its events. Axes and buttons without an event are at rest.
class GamepadModel {
 public:
  void apply(const Event& event, Utime when);
  /// The device went away: everything rests.
  void disconnect(Utime when);
  const GamepadState& state() const { return state_; }

 private:
  GamepadState state_;
};

}  // namespace marco::drivers::gamepad
