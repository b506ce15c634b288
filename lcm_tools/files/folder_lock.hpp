#pragma once

#include <filesystem>

namespace marco::files {

/// Names that OutputFolder uses next to and inside a folder of results.
inline constexpr const char* kWorkFolder = ".marco-part";      ///< unfinished results in the folder
inline constexpr const char* kWorkMark = ".marco-unfinished";  ///< in unfinished results; locked

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
