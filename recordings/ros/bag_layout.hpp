#pragma once

#include <map>
#include <string>
#include <vector>

#include "recordings/ros/byte_file.hpp"
#include "recordings/ros/chunk_merge.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// Where the pieces of a bag are.
struct BagLayout {
  struct Chunk {
    ChunkPlace place;  ///< its data; the times of its first message and its last
    std::string compression;
    uint64_t plain_size = 0;
    std::vector<uint32_t> connections;  ///< of its messages; empty: not known
  };
  std::vector<Chunk> chunks;              ///< in the order of the file
  std::map<uint32_t, Topic> connections;  ///< those that stand outside chunks
  std::map<uint32_t, int64_t> counts;     ///< messages of each connection, by the index
  bool is_indexed = false;
  Damage damage;
  std::vector<std::string> notes;
};

/// Reads the index, or, where there is none, walks through the file. The times and counts of chunks
/// whose own indexes are missing, too, are left at 0.
/// @throws std::invalid_argument see open_bag.
BagLayout read_bag_layout(ByteFile& file, const std::string& path);

/// Of a connection record. @returns nothing where a field is missing.
std::optional<Topic> topic_of(uint32_t id, std::string name, std::span<const uint8_t> data);

}  // namespace marco::ros
