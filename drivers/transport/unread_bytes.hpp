#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace marco::drivers {

/// What came over a line and is in no frame yet: the buffer of a parser of frames, which takes
/// frames off its front and skips what begins none.
class UnreadBytes {
 public:
  /// Ends the validity of rest().
  void push(std::span<const uint8_t> bytes) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(read_));
    read_ = 0;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void clear() {
    bytes_.clear();
    read_ = 0;
  }

  bool empty() const { return size() == 0; }
  std::size_t size() const { return bytes_.size() - read_; }
  std::span<const uint8_t> rest() const { return std::span<const uint8_t>(bytes_).subspan(read_); }

  void take(std::size_t count) { read_ += count; }
  void skip(std::size_t count = 1) {
    read_ += count;
    skipped_ += static_cast<int64_t>(count);
  }
  /// Bytes that were skipped, ever.
  int64_t skipped() const { return skipped_; }

 private:
  std::vector<uint8_t> bytes_;
  std::size_t read_ = 0;
  int64_t skipped_ = 0;
};

/// What parsers of frames have in common: where bytes wait to become one.
class UnreadParser {
 public:
  void push(std::span<const uint8_t> bytes) { unread_.push(bytes); }
  void clear() { unread_.clear(); }
  /// In no frame, ever.
  int64_t garbage_bytes() const { return unread_.skipped(); }

 protected:
  std::span<const uint8_t> rest() const { return unread_.rest(); }

  UnreadBytes unread_;
};

}  // namespace marco::drivers
