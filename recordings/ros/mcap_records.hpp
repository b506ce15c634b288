#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// Kinds of MCAP records (mcap.dev/spec); those that are not named here are ignored.
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
  data_end = 0x0F
};

inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::size_t kMcapRecordHead = 9;    ///< opcode and length
inline constexpr std::size_t kMcapMessageHead = 22;  ///< of a message, before its data

/// Reads the fields of a record one after the other. @throws WireError where it ends too early.
class McapFields {
 public:
  explicit McapFields(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  uint16_t u16() { return number<uint16_t>(); }
  uint32_t u32() { return number<uint32_t>(); }
  uint64_t u64() { return number<uint64_t>(); }
  std::string text();
  std::map<std::string, std::string> text_map();
  std::map<uint16_t, uint64_t> count_map();
  /// As many bytes as a u32 or a u64 before them says.
  std::span<const uint8_t> short_blob() { return take(u32()); }
  std::span<const uint8_t> long_blob() { return take(u64()); }
  std::span<const uint8_t> rest() const { return bytes_; }

 private:
  std::span<const uint8_t> take(uint64_t size);
  template <class Number>
  Number number() {
    Number value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }

  std::span<const uint8_t> bytes_;
};

struct McapSchema {
  uint16_t id = 0;
  std::string name, encoding, data;
};
struct McapChannel {
  uint16_t id = 0, schema_id = 0;
  std::string topic, encoding;
  std::map<std::string, std::string> metadata;
};
struct McapMessage {
  uint16_t channel = 0;
  uint32_t sequence = 0;
  int64_t log_ns = 0, publish_ns = 0;
  std::span<const uint8_t> data;
};
struct McapChunk {
  int64_t start_ns = 0, end_ns = 0;
  uint64_t plain_size = 0;
  uint32_t crc = 0;  ///< of the plain bytes; 0 = none
  std::string compression;
  uint64_t size = 0;     ///< of the compressed records
  std::size_t head = 0;  ///< bytes before them
};
struct McapChunkIndex {
  uint64_t offset = 0;             ///< of the chunk's opcode
  std::vector<uint16_t> channels;  ///< those in it
};
struct McapStatistics {
  uint64_t messages = 0;
  std::map<uint16_t, uint64_t> by_channel;
};

McapSchema parse_schema(McapFields fields);
McapChannel parse_channel(McapFields fields);
McapMessage parse_message(McapFields fields);
/// The fields before the records. @param bytes  may end behind them
McapChunk parse_chunk(std::span<const uint8_t> bytes);
McapChunkIndex parse_chunk_index(McapFields fields);
McapStatistics parse_statistics(McapFields fields);

}  // namespace marco::ros
