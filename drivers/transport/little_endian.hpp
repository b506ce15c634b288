#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Words of two bytes, the lower one first, as serial devices send them. Offsets must lie within
/// the bytes.
namespace marco::drivers {

inline uint16_t get_u16(std::span<const uint8_t> bytes, std::size_t at) {
  return static_cast<uint16_t>(bytes[at] | bytes[at + 1] << 8);
}

inline int16_t get_s16(std::span<const uint8_t> bytes, std::size_t at) {
  return static_cast<int16_t>(get_u16(bytes, at));
}

/// The lower 16 bits of `value`.
inline void put_u16(std::vector<uint8_t>& bytes, unsigned value) {
  bytes.push_back(static_cast<uint8_t>(value & 0xFFU));
  bytes.push_back(static_cast<uint8_t>(value >> 8U & 0xFFU));
}

inline void set_u16(std::span<uint8_t> bytes, std::size_t at, unsigned value) {
  bytes[at] = static_cast<uint8_t>(value & 0xFFU);
  bytes[at + 1] = static_cast<uint8_t>(value >> 8U & 0xFFU);
}

}  // namespace marco::drivers
