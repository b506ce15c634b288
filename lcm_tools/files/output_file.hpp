#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace marco::files {

/// When an OutputFile appears under its name.
enum class Appears {
  when_whole,    ///< at finish(), on the disk (fsync)
  when_renamed,  ///< at finish(), without fsync: for the files of an OutputFolder, which does that
  at_once,       ///< from the first byte: a recording, of which a crash should lose little
};

/// A file that is written atomically. Until finish(), and after a failure, PATH is unchanged: the
/// bytes go to PATH.part next to it, which is created exclusively and locked. A PATH.part left by a
/// killed program is removed; one in use, or a link, is left alone and another name is used.
///
/// PATH may be a link: its target is replaced and keeps its permissions. A terminal, a pipe or
/// /dev/null is written into, never replaced. Folders and block devices are refused. Not
/// thread-safe.
class OutputFile {
 public:
  /// @param part_ending  of the unfinished file's name, for libraries that look at it
  /// (".part.mp4").
  /// @throws std::runtime_error naming the path when it cannot be created.
  explicit OutputFile(std::filesystem::path path,
                      Appears appears = Appears::when_whole,
                      const std::string& part_ending = ".part");
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// @throws std::runtime_error naming path and cause, e.g. a full disk.
  void write(std::span<const uint8_t> bytes);
  void write(std::string_view text);

  /// Appends bytes of another file, in the kernel where it can.
  void copy_from(int descriptor, int64_t offset, int64_t count);

  /// Flushes the buffer to the system. @throws as write.
  void flush();

  /// All bytes written so far, buffered ones included.
  int64_t size_bytes() const { return written_ + static_cast<int64_t>(buffer_.size()); }

  /// Renames the file to PATH. @throws as write; PATH is then unchanged.
  void finish();

  /// The path of the bytes until finish(), for libraries that open files by name.
  const std::filesystem::path& unfinished_path() const { return part_path_; }

 private:
  void open_part(const std::filesystem::path& target, const std::string& ending);
  void write_through(std::span<const uint8_t> bytes);
  void put_in_place();
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path path_;       ///< as the caller named it
  std::filesystem::path target_;     ///< behind links
  std::filesystem::path part_path_;  ///< equals target_ when written in place
  Appears appears_;
  int descriptor_ = -1;
  int64_t written_ = 0;
  std::vector<uint8_t> buffer_;
};

/// Waits until a file or folder is on the disk. Ignores pipes and the like.
/// @throws std::runtime_error naming the path when the disk failed.
void sync_to_disk(const std::filesystem::path& path);

/// Where `path` leads when every link is followed, also one whose target is not there yet.
/// Absolute, without a slash at the end. @throws std::runtime_error when links lead in a circle.
std::filesystem::path behind_links(const std::filesystem::path& path);

}  // namespace marco::files
