#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace marco::files {

/// Names that OutputFolder uses next to and inside a folder of results.
inline constexpr const char* kWorkFolder = ".marco-part";      ///< unfinished results in the folder
inline constexpr const char* kWorkMark = ".marco-unfinished";  ///< in unfinished results; locked
inline constexpr const char* kJournal = ".marco-journal";      ///< of FolderMove, in the folder

/// Called with the name of each step before it changes the disk; a test may end the program there.
using AtStep = std::function<void(const char* step)>;

/// The remaining moves that put new results into FOLDER, where two folders cannot exchange names.
/// Once it is on the disk it can only be completed.
struct FolderMove {
  std::vector<std::string> put;   ///< files to move from FOLDER/.marco-part, relative
  std::vector<std::string> drop;  ///< files of FOLDER to remove, relative
};

/// Writes FOLDER/.marco-journal, carries it out and removes it and FOLDER/.marco-part. The caller
/// holds the lock of .marco-part. @throws std::runtime_error naming the path; the next
/// finish_interrupted carries out the rest.
void move_results(const std::filesystem::path& folder, const FolderMove& move, const AtStep& at);

/// Completes a FolderMove that a killed program left in `folder`. Every reader of results calls it
/// first (read_whole_file and EventLogReader do). Without a journal it costs one system call.
/// @throws std::runtime_error when it cannot (no right to write, another program holds it).
void finish_interrupted(const std::filesystem::path& folder, const AtStep& at = {});

/// The lock of a folder of unfinished results, on its file .marco-unfinished. Released with the
/// object, or when the process and its children have ended.
class FolderLock {
 public:
  FolderLock() = default;
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Makes the mark, if need be, and locks it. @returns false when another program holds it.
  /// @throws std::runtime_error when the mark cannot be made.
  bool take(const std::filesystem::path& unfinished);

 private:
  int descriptor_ = -1;
};

}  // namespace marco::files
