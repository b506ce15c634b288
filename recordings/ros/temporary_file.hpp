#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace marco::ros {

/// A file of our own in the folder that TMPDIR names. It has no name there: whatever ends the
/// process, nothing is left behind.
class TemporaryFile {
 public:
  static constexpr uint64_t kLeftToOthers = uint64_t{1} << 30;

  /// @param what  "to unpack a zstd file", for messages
  /// @param left_to_others  bytes of the disk: one that is full stops recorders and desktops
  /// @throws std::runtime_error where it cannot be made.
  explicit TemporaryFile(std::string what, uint64_t left_to_others = kLeftToOthers);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// For this process alone, and while this lives.
  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }
  /// @throws std::runtime_error where that would leave too little space to others.
  void append(std::span<const uint8_t> bytes);

 private:
  [[noreturn]] void refuse(const std::string& why) const;

  std::string what_;
  std::filesystem::path folder_;
  uint64_t left_to_others_;
  int fd_;
  uint64_t may_write_ = 0;  ///< before the space is looked at again
};

}  // namespace marco::ros
