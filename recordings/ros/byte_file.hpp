#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "lcm_tools/files/readable.hpp"
#include "recordings/ros/byte_buffer.hpp"

namespace marco::ros {

/// A file that is read at any place. Not safe for threads.
class ByteFile {
 public:
  /// @throws std::invalid_argument when it cannot be opened.
  explicit ByteFile(const std::filesystem::path& path);
  ~ByteFile();
  ByteFile(const ByteFile&) = delete;
  ByteFile& operator=(const ByteFile&) = delete;

  int64_t size() const { return size_; }
  /// See files::next_data.
  int64_t next_data(int64_t offset) const { return files::next_data(fd_, offset); }
  /// As many bytes as there are: fewer at the end of the file.
  std::size_t read(int64_t offset, std::span<uint8_t> into) const;
  /// At most `size` bytes. Small reads near each other cost one call of the system.
  std::span<const uint8_t> peek(int64_t offset, std::size_t size);
  /// Exactly this many, and fewer at the end of the file.
  void read(int64_t offset, int64_t size, ByteBuffer& into) const;
  std::vector<uint8_t> bytes(int64_t offset, int64_t size) const;

 private:
  int fd_;
  int64_t size_ = 0;
  int64_t window_at_ = 0;
  std::vector<uint8_t> window_;
};

}  // namespace marco::ros
