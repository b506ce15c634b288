#pragma once

#include <cstdint>
#include <string_view>

namespace marco::files {

/// Kinds of MCAP records (mcap.dev/spec), version 0 of the format.
enum class McapOp : uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  statistics = 0x0B,
  summary_offset = 0x0E,
  data_end = 0x0F
};

/// The first and the last bytes of a file.
inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};

}  // namespace marco::files
