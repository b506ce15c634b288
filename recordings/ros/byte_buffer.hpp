#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

namespace marco::ros {

/// Bytes whose memory is kept for the next ones, and is not zeroed: a recording that is read chunk
/// after chunk costs no new pages.
class ByteBuffer {
 public:
  ByteBuffer() = default;
  ByteBuffer(ByteBuffer&& other) noexcept { swap(other); }
  ByteBuffer& operator=(ByteBuffer&& other) noexcept {
    swap(other);
    return *this;
  }

  std::span<const uint8_t> bytes() const { return {data_.get(), size_}; }
  std::size_t size() const { return size_; }

  /// What was in it stays, up to the smaller size; what follows is not set.
  std::span<uint8_t> resize(std::size_t size) {
    if (size > room_) {
      const std::size_t room = std::max(size, 2 * room_);
      auto larger = std::make_unique_for_overwrite<uint8_t[]>(room);
      std::copy_n(data_.get(), size_, larger.get());
      data_ = std::move(larger);
      room_ = room;
    }
    size_ = size;
    return {data_.get(), size_};
  }

 private:
  void swap(ByteBuffer& other) {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(room_, other.room_);
  }

  std::unique_ptr<uint8_t[]> data_;
  std::size_t size_ = 0, room_ = 0;
};

}  // namespace marco::ros
