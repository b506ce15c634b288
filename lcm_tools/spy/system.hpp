#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "lcm_tools/spy/picture.hpp"

namespace marco::spy {

std::optional<GrayImage> decode_jpeg(std::span<const uint8_t> bytes);

int64_t wall_clock_us();

}  // namespace marco::spy
