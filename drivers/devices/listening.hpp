#pragma once

#include <cstdint>
#include <span>

#include "drivers/devices/kind.hpp"

namespace marco::drivers::devices {

/// Who sent these bytes. Only frames with right checksums count: two or more when nobody was asked,
/// one when the sender was. Pure; costs a pass for each protocol.
/// @param bytes  as they came, begun and ended anywhere. @param asked  who was asked; silence =
/// nobody.
Claim judge(std::span<const uint8_t> bytes, Kind asked);

}  // namespace marco::drivers::devices
