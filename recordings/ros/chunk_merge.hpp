#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

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
  std::vector<uint8_t> bytes;
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

  /// @param load  the chunk of an index into `places`
  ChunkMerge(std::vector<ChunkPlace> places, std::function<LoadedChunk(std::size_t)> load);

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
  void open_due();
  std::vector<Open>::iterator earliest();

  std::vector<ChunkPlace> places_;
  std::vector<std::size_t> by_start_;  ///< indices of places_
  std::function<LoadedChunk(std::size_t)> load_;
  std::size_t begun_ = 0;  ///< of by_start_
  std::vector<Open> open_;
};

}  // namespace marco::ros
