#include "drivers/gamepad/codec.hpp"

#include <algorithm>

namespace marco::drivers::gamepad {
namespace {

constexpr uint8_t kInitial = 0x80;
constexpr uint8_t kMostNumber = 63;
constexpr float kFull = 32767.0F;

}  // namespace

std::vector<uint8_t> encode_event(const Event& event) {
  std::vector<uint8_t> bytes;
  for (int shift = 0; shift < 32; shift += 8) {
    bytes.push_back(static_cast<uint8_t>(event.time_ms >> shift & 0xFF));
  }
  const auto value = static_cast<uint16_t>(event.value);
  bytes.push_back(static_cast<uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<uint8_t>(value >> 8));
  bytes.push_back(
      static_cast<uint8_t>(static_cast<uint8_t>(event.kind) | (event.initial ? kInitial : 0)));
  bytes.push_back(event.number);
  return bytes;
}

std::optional<Event> RecordReader::next() {
  while (unread_.size() >= 8) {
    const std::span<const uint8_t> rest = unread_.rest();
    const uint8_t type = rest[6] & 0x7F;
    const int value = static_cast<int16_t>(rest[4] | rest[5] << 8);
    const bool sound = (type == 1 && (value == 0 || value == 1)) || type == 2;
    if (!sound || rest[7] > kMostNumber) {
      unread_.skip();
      continue;
    }
    Event event;
    for (std::size_t i = 0; i < 4; ++i) event.time_ms |= uint32_t{rest[i]} << (8 * i);
    event.value = static_cast<int16_t>(value);
    event.kind = static_cast<Event::Kind>(type);
    event.initial = (rest[6] & kInitial) != 0;
    event.number = rest[7];
    unread_.take(8);
    return event;
  }
  return std::nullopt;
}

void GamepadModel::apply(const Event& event, Utime when) {
  state_.utime = when;
  state_.connected = true;
  const std::size_t number = event.number;
  if (event.kind == Event::Kind::axis) {
    if (state_.axes.size() <= number) state_.axes.resize(number + 1, 0.0F);
    state_.axes[number] = std::clamp(static_cast<float>(event.value) / kFull, -1.0F, 1.0F);
  } else {
    if (state_.buttons.size() <= number) state_.buttons.resize(number + 1, false);
    state_.buttons[number] = event.value != 0;
  }
}

void GamepadModel::disconnect(Utime when) {
  state_.utime = when;
  state_.connected = false;
  std::fill(state_.axes.begin(), state_.axes.end(), 0.0F);
  std::fill(state_.buttons.begin(), state_.buttons.end(), false);
}

}  // namespace marco::drivers::gamepad
