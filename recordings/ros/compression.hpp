#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "recordings/ros/byte_buffer.hpp"

namespace marco::ros {

/// No chunk that a recorder writes is larger when it is unpacked.
inline constexpr uint64_t kMostPlainBytes = uint64_t{1} << 28;

/// Unpacks chunk after chunk with the libraries' states kept. Not safe for threads.
class Unpacker {
 public:
  enum class Checksum { none_wrong, wrong };

  Unpacker();
  ~Unpacker();

  /// The plain bytes of a chunk, as far as its compressed ones go: fewer than `plain_size` where
  /// these are cut off or damaged, never more.
  /// @param name  of ROS bags and MCAP: "", "none", "bz2", "lz4" (frames), "zstd"
  /// @returns whether all bytes are there and an LZ4 frame's checksum contradicts them. Where
  /// those of other formats do, bytes are missing.
  /// @throws std::invalid_argument for another name, and for more than kMostPlainBytes.
  Checksum unpack(std::string_view name,
                  std::span<const uint8_t> bytes,
                  uint64_t plain_size,
                  ByteBuffer& plain);

  /// A message that rosbag2 may have packed by itself; CDR begins with a zero. Nothing where its
  /// frame is damaged or too large. Valid until the next call.
  std::span<const uint8_t> message(std::span<const uint8_t> bytes);

 private:
  struct States;
  std::unique_ptr<States> states_;
  ByteBuffer message_;
};

/// Whether the bytes begin a zstd frame.
bool is_zstd(std::span<const uint8_t> bytes);

}  // namespace marco::ros
