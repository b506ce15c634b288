#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

/// VISCA, the language of Sony's camera heads: 8x command ... FF, answers 9x ... FF. Angles are
/// words of four nibbles, two's complement; the device counts pan to the right.
namespace marco::drivers::p2os {

inline constexpr uint8_t kViscaEnd = 0xFF;
inline constexpr double kUnitsPerPanDeg = 860.0 / 95.0;
inline constexpr double kUnitsPerTiltDeg = 281.0 / 20.0;
inline constexpr int kMostPan = 860, kMostTilt = 281;
inline constexpr int kTopPan = 24, kTopTilt = 20;                       ///< speed codes
inline constexpr double kTopPanDegPerS = 80.0, kTopTiltDegPerS = 50.0;  ///< at these codes

inline int visca_word(std::span<const uint8_t> message, std::size_t at) {
  int value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 4 | (message[at + i] & 0x0F);
  return static_cast<int16_t>(value);
}

inline void put_visca_word(std::vector<uint8_t>& message, int value) {
  for (int shift = 12; shift >= 0; shift -= 4) {
    message.push_back(static_cast<uint8_t>(value >> shift & 0x0F));
  }
}

}  // namespace marco::drivers::p2os
