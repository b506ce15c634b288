#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "recordings/ros/byte_buffer.hpp"
#include "recordings/ros/byte_file.hpp"

namespace marco::ros {

/// Bytes from their first to their last, of memory or of a file, which is read by pieces. Not safe
/// for threads.
class ByteStream {
 public:
  void begin(std::span<const uint8_t> bytes) {
    file_ = nullptr;
    held_ = bytes;
    held_at_ = at_ = 0;
    size_ = static_cast<int64_t>(bytes.size());
  }
  /// The file has to live longer.
  void begin(const ByteFile& file, int64_t offset, int64_t size) {
    begin({});
    file_ = &file;
    offset_ = offset;
    size_ = std::clamp<int64_t>(size, 0, std::max<int64_t>(0, file.size() - offset));
  }
  void rewind() { at_ = 0; }
  int64_t left() const { return size_ - at_; }

  /// The next ones: none at the end, and at most `most`. Valid until the next call.
  std::span<const uint8_t> next(int64_t most) {
    const bool is_held = at_ >= held_at_ && at_ < held_at_ + static_cast<int64_t>(held_.size());
    if (!is_held && left() > 0) read();
    const auto from = static_cast<std::size_t>(at_ - held_at_);
    const auto bytes = held_.subspan(std::min(from, held_.size()));
    const auto given =
        bytes.first(std::min<std::size_t>(bytes.size(), static_cast<std::size_t>(most)));
    at_ += static_cast<int64_t>(given.size());
    return given;
  }

 private:
  void read() {
    constexpr int64_t kPieceBytes = 1 << 20;
    held_at_ = at_;
    if (file_ != nullptr) file_->read(offset_ + at_, std::min(kPieceBytes, left()), buffer_);
    held_ = file_ != nullptr ? buffer_.bytes() : std::span<const uint8_t>{};
    if (held_.empty()) size_ = at_;  // the file became shorter
  }

  const ByteFile* file_ = nullptr;
  int64_t offset_ = 0, size_ = 0, at_ = 0;
  ByteBuffer buffer_;
  std::span<const uint8_t> held_;
  int64_t held_at_ = 0;
};

}  // namespace marco::ros
