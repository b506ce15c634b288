#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace marco::logs {

enum class Existing { refuse, replace };

/// A file that appears under its name when it is complete; until then, and after a failure, there
/// is at most NAME.part, which the destructor removes.
class OutputFile {
 public:
  /// @param inputs files that must not be written over.
  /// @throws std::invalid_argument when `path` exists and shall be kept, or is an input;
  /// std::runtime_error naming the path when it cannot be created.
  OutputFile(std::filesystem::path path,
             Existing existing,
             const std::vector<std::filesystem::path>& inputs);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// @throws std::runtime_error naming path and cause, e.g. a full disk.
  void write(std::span<const uint8_t> bytes);
  void write(std::string_view text);

  /// Appends bytes of another file, in the kernel where it can.
  void copy_from(int descriptor, int64_t offset, int64_t count);

  /// All bytes written so far, buffered ones included.
  int64_t size_bytes() const { return written_ + static_cast<int64_t>(buffer_.size()); }

  /// Gives the file its name.
  void finish();

 private:
  void flush();
  void write_through(std::span<const uint8_t> bytes);
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  std::filesystem::path part_path_;
  int descriptor_ = -1;
  int64_t written_ = 0;
  std::vector<uint8_t> buffer_;
};

/// As the constructor above, for programs that write a path by other means.
void check_output_path(const std::filesystem::path& path,
                       Existing existing,
                       const std::vector<std::filesystem::path>& inputs);

}  // namespace marco::logs
