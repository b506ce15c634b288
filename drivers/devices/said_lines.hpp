#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/devices/kind.hpp"

namespace marco::drivers::devices {

/// What lines of text say about their sender: Marco's text protocol, thesis B's boards, a satellite
/// receiver (two NMEA sentences with right sums), a login prompt, or some text.
/// @param asked  who was asked; silence = nobody.
/// @returns nothing when the bytes are not text.
std::optional<Claim> judge_lines(std::span<const uint8_t> bytes, Kind asked);

/// Whether it is "$GPGGA,...*47" with the exclusive or of what stands between $ and *.
bool is_nmea_sentence(std::string_view line);

}  // namespace marco::drivers::devices
