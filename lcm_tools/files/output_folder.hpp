#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/files/folder_lock.hpp"

namespace marco::files {

/// Lets a test make the disk fail, or end the program at a step. Empty functions: the real thing.
struct FolderSeams {
  /// Called with the name of each step before it changes the disk.
  std::function<void(const char* step)> at_step;
  /// In place of renameat2(RENAME_EXCHANGE). @returns an errno, 0 = done
  std::function<int(const std::filesystem::path&, const std::filesystem::path&)> exchange;
};

/// A folder of results that changes atomically. Everything is written below path(), a folder next
/// to DIR (DIR.part). commit() syncs it to the disk and exchanges the two names in one step. Until
/// then DIR is unchanged, whatever happens: an exception, a signal, kill -9, a full disk. A
/// DIR.part left by a killed program is reused; one in use is locked.
///
/// Existing files in DIR:
/// * Results of an earlier run of the same command are removed. Each run leaves a list of its
///   results (.marco-OWNER). A file changed since then belongs to the user.
/// * The user's files stay, in sub-folders too: they are linked into the new folder. Files that
///   appear in DIR during the exchange are moved over.
/// * A file with the name of a new result is replaced.
///
/// Where the file system has no exchange, the two folders are renamed one after the other. A
/// program killed in between leaves no DIR but DIR.part.old, which the next run puts back.
///
/// Some folders cannot be replaced: DIR is a mount point or a process's working directory, its
/// parent is read-only, or it holds more than 1000 other files or files that cannot be linked. Then
/// the results are moved file by file out of DIR/.marco-part. A program killed meanwhile leaves
/// results of both runs, each file whole. Not thread-safe.
class OutputFolder {
 public:
  /// @param folder  may be a link to a folder, relative, or `.`; created with its parents if
  /// missing
  /// @param owner   the command whose earlier results are removed: letters, digits and minus
  /// @throws std::runtime_error naming the folder when it cannot be written, or when another
  /// program is writing results there
  OutputFolder(const std::filesystem::path& folder, std::string owner, FolderSeams seams = {});
  /// Without commit: removes what was written.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write. Exists, and is empty at first.
  const std::filesystem::path& path() const { return part_; }

  /// Keeps a file that the command reads, even if it is an earlier result. Paths outside the folder
  /// and missing files are allowed.
  void keep(const std::filesystem::path& input);

  /// Also removes these results of an earlier run that left no list, unless they are kept.
  void drop(const std::vector<std::string>& names);

  /// Puts the new results in place. Every file below path() must be closed.
  /// @throws std::runtime_error naming the path and cause. The folder is then unchanged, unless
  /// results were being moved file by file.
  void commit();

 private:
  enum class State { unusable, open, done };
  void settle_beside();
  void settle_inside();
  State take_part();
  void step(const char* name) const;
  bool link_others(const std::set<std::string>& results, const std::set<std::string>& stale);
  bool exchange();
  int rename_both();
  void move_in(const std::set<std::string>& results, const std::set<std::string>& stale);
  void move_one(const std::string& name) const;
  void bring_late_files();

  std::filesystem::path folder_;  ///< behind links
  std::string owner_;
  FolderSeams seams_;
  std::filesystem::path part_;
  FolderLock lock_;
  std::string why_not_;            ///< part_ cannot be used
  bool inside_ = false;            ///< part_ is in folder_, whose files it replaces one by one
  State state_ = State::unusable;  ///< open: part_ is ours; done: it must not be removed
  std::set<std::string> kept_;
  std::set<std::string> dropped_;
  std::vector<std::string> linked_;
  std::set<ino_t> seen_;  ///< files of folder_ when it was last looked at
};

}  // namespace marco::files
