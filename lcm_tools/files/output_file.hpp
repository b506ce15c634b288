#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace marco::files {

/// How an OutputFile comes to its name.
enum class Appears {
  when_whole,    ///< at finish(), on the disk (fsync)
  when_renamed,  ///< at finish(), without fsync: for the files of an OutputFolder, which does that
  at_once,       ///< from the first byte: a recording of which a crash must leave what there was
};

/// A file that one of our programs writes. Until finish(), and after a failure, PATH is as it was:
/// the bytes go to PATH.part beside it. PATH.part is made exclusively and locked; one that a killed
/// program left is removed, one that is in use (or a link that somebody planted) is passed by.
///
/// PATH may be a link: its target is replaced, and keeps its permissions. What is no regular file
/// (a terminal, a pipe, /dev/null) is never replaced but written into. Folders and block devices
/// are refused. Not thread-safe.
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

  /// Hands the bytes written so far to the system. @throws as write.
  void flush();

  /// All bytes written so far, buffered ones included.
  int64_t size_bytes() const { return written_ + static_cast<int64_t>(buffer_.size()); }

  /// Gives the file its name. @throws as write; then PATH is as it was.
  void finish();

  /// Where the bytes stand until finish(), for a library that opens files by their names.
  const std::filesystem::path& unfinished_path() const { return part_path_; }

 private:
  void open_part(const std::filesystem::path& target, const std::string& ending);
  void write_through(std::span<const uint8_t> bytes);
  void put_in_place();
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path path_;       ///< as the caller named it
  std::filesystem::path target_;     ///< behind links
  std::filesystem::path part_path_;  ///< target_ itself where the bytes go straight there
  Appears appears_;
  int descriptor_ = -1;
  int64_t written_ = 0;
  std::vector<uint8_t> buffer_;
};

/// Waits until a file or a folder is on the disk. What knows no such thing (a pipe) is left alone.
/// @throws std::runtime_error naming the path when the disk failed.
void sync_to_disk(const std::filesystem::path& path);

/// Where `path` leads when every link is followed, also one whose target is not there yet.
/// Absolute, without a slash at the end. @throws std::runtime_error when links lead in a circle.
std::filesystem::path behind_links(const std::filesystem::path& path);

}  // namespace marco::files
