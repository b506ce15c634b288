#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "recordings/ros/byte_buffer.hpp"
#include "recordings/ros/byte_stream.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// Unpacks chunk after chunk with the libraries' states kept, each by pieces: a chunk may be larger
/// than the memory. Not safe for threads.
class Unpacker {
 public:
  enum class Checksum { none_wrong, wrong };

  Unpacker();
  ~Unpacker();
  Unpacker(Unpacker&&) noexcept;
  Unpacker& operator=(Unpacker&&) noexcept;  ///< to give memory back: `unpacker = Unpacker()`

  /// A chunk from its first byte on.
  /// @param name  of ROS bags and MCAP: "", "none", "bz2", "lz4" (frames), "zstd"
  /// @param packed  has to live until the chunk's last byte was read
  /// @throws std::invalid_argument for another name.
  void begin(std::string_view name, ByteStream& packed, uint64_t plain_size);

  /// The next plain bytes. @returns how many; 0 behind `plain_size` bytes, or earlier where the
  /// packed ones are cut off or damaged.
  std::size_t read(std::span<uint8_t> into);

  /// After the last byte: whether all are there and a checksum within the packed ones contradicts
  /// them.
  Checksum checksum() const;

  /// A message that rosbag2 may have packed by itself; CDR begins with a zero. Nothing where its
  /// frame is damaged or too large. Valid until the next call; a chunk that was begun is ended.
  std::span<const uint8_t> message(std::span<const uint8_t> bytes);

 private:
  struct States;
  std::size_t read_copied(std::span<uint8_t> into);
  std::size_t read_bz2(std::span<uint8_t> into);
  std::size_t read_lz4(std::span<uint8_t> into);
  std::size_t read_zstd(std::span<uint8_t> into);
  void restart_zstd();

  std::unique_ptr<States> states_;
  std::size_t (Unpacker::*read_some_)(std::span<uint8_t>) = &Unpacker::read_copied;
  ByteStream* packed_ = nullptr;
  uint64_t plain_size_ = 0, done_ = 0;
  bool ended_ = true, failed_ = false;
  ByteStream packed_message_;
  ByteBuffer message_;
};

/// Whether the bytes begin a zstd frame.
bool is_zstd(std::span<const uint8_t> bytes);

}  // namespace marco::ros
