#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recordings/ros/byte_file.hpp"
#include "recordings/ros/chunk_merge.hpp"
#include "recordings/ros/mcap_records.hpp"

namespace marco::ros {

/// Where the pieces of an MCAP file are.
struct McapLayout {
  /// A chunk's compressed records, or records outside chunks, at the place of the same index.
  struct Piece {
    uint64_t plain_size = 0;
    uint32_t crc = 0;  ///< of the plain bytes; 0 = none
    bool is_chunk = false;
    uint8_t compression = 0;         ///< index into `compressions`
    std::vector<uint16_t> channels;  ///< those in it; empty: not known
  };
  std::vector<ChunkPlace> places;
  std::vector<Piece> pieces;
  std::vector<std::string> compressions;     ///< those of its chunks
  std::map<uint16_t, McapSchema> schemas;    ///< outside chunks
  std::map<uint16_t, McapChannel> channels;  ///< outside chunks
  std::optional<McapStatistics> statistics;
  Damage damage;
};

/// Walks over the records of the file; chunks are not opened. @throws std::invalid_argument where
/// the file is no MCAP, or its definitions are more than kMostTopicBytes.
McapLayout read_mcap_layout(ByteFile& file, const std::string& path);

}  // namespace marco::ros
