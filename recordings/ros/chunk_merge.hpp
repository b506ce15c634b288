#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "recordings/ros/byte_buffer.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// Where a piece of a recording lies, and the times of its messages.
struct ChunkPlace {
  int64_t start_ns = 0, end_ns = 0;
  int64_t offset = 0;  ///< in the file
  int64_t size = 0;    ///< there
};

/// A chunk in memory.
struct LoadedChunk {
  struct Entry {
    int64_t received_ns, published_ns;
    uint32_t topic;
    std::size_t offset, size;  ///< of the message in `bytes`
  };
  ByteBuffer bytes;
  std::vector<Entry> entries;  ///< in the order of the file
};

/// The messages of chunks that may overlap, by the time of receipt; those of one instant in the
/// order of the file. Holds as many chunks as overlap at a time, but never more than 32: then the
/// order is the best that these allow.
class ChunkMerge {
 public:
  struct Item {
    LoadedChunk::Entry entry;
    std::span<const uint8_t> bytes;  ///< valid until the next call
  };

  /// The chunk of an index into `places`, in the memory of one that was read to its end.
  using Load = std::function<LoadedChunk(std::size_t, LoadedChunk)>;

  ChunkMerge(std::vector<ChunkPlace> places, Load load);

  std::optional<Item> next();
  void rewind();
  /// Part of the chunks that was begun, 0..1.
  double progress() const;

 private:
  struct Open {
    std::size_t place;
    LoadedChunk chunk;
    std::size_t next = 0;
  };
  void close_read();
  void open_due();
  std::vector<Open>::iterator earliest();

  std::vector<ChunkPlace> places_;
  std::vector<std::size_t> by_start_;  ///< indices of places_
  Load load_;
  std::size_t begun_ = 0;  ///< of by_start_
  std::vector<Open> open_;
  std::vector<LoadedChunk> spare_;  ///< their memory
};

}  // namespace marco::ros
