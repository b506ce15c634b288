#pragma once

#include <cstdint>
#include <span>

#include "recordings/ros/byte_buffer.hpp"
#include "recordings/ros/compression.hpp"

namespace marco::ros {

/// A window on the plain bytes of a chunk, which moves from the first to the last. It is as wide as
/// what is looked at. Not safe for threads.
class PlainWindow {
 public:
  /// On the chunk that the unpacker has begun, and that it has to keep until the window's next one.
  /// @param with_crc  whether crc() will be asked for
  void begin(Unpacker& unpacker, bool with_crc);

  /// The next bytes, `count` of them and maybe more; fewer at the end alone. Valid until the next
  /// call.
  std::span<const uint8_t> peek(std::size_t count) {
    if (count > held_) fill(count);
    return buffer_.bytes().subspan(from_, held_);
  }
  /// @returns false where there are fewer: the window is at the end then.
  bool skip(uint64_t count);

  /// Bytes that were passed, and those that were unpacked so far.
  uint64_t at() const { return unpacked_ - held_; }
  uint64_t unpacked() const { return unpacked_; }
  /// Of the unpacked ones, as MCAP has it.
  uint32_t crc() const { return crc_; }

 private:
  void fill(std::size_t count);
  std::size_t unpack(std::span<uint8_t> into);

  Unpacker* unpacker_ = nullptr;
  ByteBuffer buffer_;
  std::size_t from_ = 0, held_ = 0;
  uint64_t unpacked_ = 0;
  bool with_crc_ = false;
  uint32_t crc_ = 0;
};

}  // namespace marco::ros
