#pragma once

#include <cstdint>
#include <functional>
#include <memory>
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

/// A message of a chunk.
struct ChunkMessage {
  int64_t received_ns, published_ns;
  uint32_t topic;
  std::span<const uint8_t> bytes;
};

/// Of one file: recorders write a terabyte in fewer.
inline constexpr std::size_t kMostChunks = 2'000'000;
inline constexpr const char* kTooManyChunks = ": holds more than two million chunks";

/// What is held of recordings at a time. Chunks of good ones hold a megabyte, and few of them
/// overlap.
inline constexpr std::size_t kMostHeldBytes = std::size_t{192} << 20;

/// The messages of chunks that may overlap, by the time of receipt; those of one instant in the
/// order of the file. Each chunk is loaded once. Where those that overlap are more than may be
/// held, they are put in order on disk (merge sort of runs: Knuth, The Art of Computer Programming
/// 3, 5.4.1).
class ChunkMerge {
 public:
  using Keep = std::function<void(const ChunkMessage&)>;
  /// Calls Keep for each message of a chunk, in the order of the file.
  using Load = std::function<void(std::size_t chunk, const Keep&)>;

  /// @param places  of all chunks; have to live longer
  /// @param used  indices of those that are read
  ChunkMerge(std::span<const ChunkPlace> places,
             std::vector<uint32_t> used,
             Load load,
             std::size_t most_held_bytes = kMostHeldBytes);
  ~ChunkMerge();

  /// Its bytes are valid until the next call. @throws std::runtime_error where the disk is full.
  std::optional<ChunkMessage> next();
  /// Part of the chunks that was begun, 0..1.
  double progress() const;
  /// Runs that were put on disk.
  std::size_t runs() const { return runs_; }

 private:
  class Stream;
  class InMemory;
  class OnDisk;
  struct IsLater;

  void keep(const ChunkMessage& message);
  /// Whether a chunk that was not loaded begins by then.
  bool is_due(int64_t at_ns) const;
  void load_due();
  void put_on_disk();
  void push(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> pop();

  std::span<const ChunkPlace> places_;
  std::vector<uint32_t> by_start_;
  Load load_;
  std::size_t most_held_bytes_;
  std::size_t begun_ = 0;  ///< of by_start_
  std::size_t held_bytes_ = 0, made_ = 0, runs_ = 0;
  std::unique_ptr<InMemory> loading_, spare_;
  std::unique_ptr<Stream> current_;            ///< of the message that was given last
  std::vector<std::unique_ptr<Stream>> heap_;  ///< the earliest first
};

}  // namespace marco::ros
