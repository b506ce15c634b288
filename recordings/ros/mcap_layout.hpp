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
  struct Piece {
    ChunkPlace place;                ///< a chunk's compressed records, or records outside chunks
    std::optional<McapChunk> chunk;  ///< nothing: records outside chunks
    std::map<uint16_t, uint64_t> channels;  ///< those in it; empty: not known
  };
  std::vector<Piece> pieces;
  std::map<uint16_t, McapSchema> schemas;    ///< outside chunks
  std::map<uint16_t, McapChannel> channels;  ///< outside chunks
  std::optional<McapStatistics> statistics;
  std::map<std::string, std::map<std::string, std::string>> metadata;  ///< the last of each name
  Damage damage;
};

/// Walks over the records of the file; chunks are not opened. @throws std::invalid_argument where
/// the file is no MCAP.
McapLayout read_mcap_layout(ByteFile& file, const std::string& path);

}  // namespace marco::ros
