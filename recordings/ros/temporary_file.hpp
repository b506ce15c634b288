#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace marco::ros {

/// A file of our own while this lives, in the folder that TMPDIR names.
class TemporaryFile {
 public:
  /// @param what  "to unpack a zstd file", for messages
  /// @throws std::runtime_error where it cannot be made.
  explicit TemporaryFile(std::string what);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// @throws std::runtime_error where that would leave too little space to others.
  void append(std::span<const uint8_t> bytes);

 private:
  [[noreturn]] void refuse(const std::string& why) const;

  std::string what_;
  std::filesystem::path path_;
  int fd_ = -1;
  uint64_t may_write_ = 0;  ///< before the space is looked at again
};

}  // namespace marco::ros
