#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lcm_tools/log/output_file.hpp"

namespace marco::logs {

/// When a message was recorded, and when it was sent.
struct McapTimes {
  uint64_t log_ns = 0;
  uint64_t publish_ns = 0;
};

/// Writes an MCAP file (version 0 of the format): messages in chunks of about 1 MB, compressed by
/// zstd, with their message indexes, then the summary (schemas, channels, statistics, chunk
/// indexes), with checksums. Memory: one chunk, and about 100 bytes for each chunk written.
class McapWriter {
 public:
  /// @param out must outlive it; finish() it after finish().
  /// @param profile  "ros1", "ros2", or "" for none: what readers may rely on
  explicit McapWriter(OutputFile& out, std::string_view profile = "");

  /// @param encoding "jsonschema", ... @returns its id, > 0. @throws std::runtime_error when there
  /// are more than 65535.
  uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data);

  /// @param encoding of the messages: "json", ... @throws std::runtime_error as above.
  uint16_t add_channel(uint16_t schema,
                       std::string_view topic,
                       std::string_view encoding,
                       const std::map<std::string, std::string>& metadata);

  void write(uint16_t channel, uint32_t sequence, McapTimes times, std::string_view data);

  /// Writes the last chunk and the summary. Nothing may be written after it.
  void finish();

  uint64_t messages() const { return written_.messages; }

 private:
  struct Span {
    uint64_t messages = 0;
    uint64_t start_ns = 0, end_ns = 0;
    void add(uint64_t time_ns);
  };
  struct Chunk {
    std::string bytes;
    Span span;
    std::map<uint16_t, std::vector<std::pair<uint64_t, uint64_t>>> index;  // time, offset
  };
  struct ChunkIndex {
    uint64_t start_ns = 0, end_ns = 0;
    uint64_t offset = 0, bytes = 0;
    std::vector<std::pair<uint16_t, uint64_t>> indexes;  // channel -> offset of its message index
    uint64_t index_bytes = 0;
    uint64_t records_bytes = 0, packed_bytes = 0;
  };
  void emit(std::string_view bytes);
  void flush_chunk();
  std::string summary(uint64_t start, std::string& offsets) const;

  OutputFile& out_;
  uint32_t written_crc_ = 0;
  std::vector<std::string> schemas_;   // whole records
  std::vector<std::string> channels_;  // whole records
  Chunk chunk_;
  Span written_;
  std::vector<ChunkIndex> chunks_;
  std::map<uint16_t, uint64_t> counts_;  // messages by channel
};

}  // namespace marco::logs
