#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/files/folder_journal.hpp"

namespace marco::files {

/// How a test makes the disk refuse, or ends the program at a step. Empty functions: as it is.
struct FolderSeams {
  AtStep at_step;
  /// In place of renameat2(RENAME_EXCHANGE). @returns an errno, 0 = done
  std::function<int(const std::filesystem::path&, const std::filesystem::path&)> exchange;
};

/// A folder of results that changes as a whole. Everything is written below path(), a folder beside
/// DIR (DIR.part); commit() puts it on the disk and lets the two exchange names in one step. Until
/// then DIR is as it was, whatever happens: an exception, a signal, kill -9, a full disk. A
/// DIR.part that a killed program left is used again; one in use is locked.
///
/// What becomes of the files that stand in DIR:
/// * Results of an earlier run of the same command go. They are known by the list that each run
///   leaves (.marco-OWNER): a file that was changed since it was written is somebody's own.
/// * Everybody's own files stay, in sub-folders too: they are linked into the new folder. What
///   somebody puts into DIR while the names are exchanged is moved over.
/// * A file that a new result has the name of is replaced.
///
/// Where folders cannot exchange names (the file system refuses, DIR is a mount point, somebody
/// stands in it, its parent is read-only, it holds more than 1000 files of others, or they cannot
/// be linked) the results are written to DIR/.marco-part, and a journal moves them file by file;
/// if that is cut short, the next program that opens the folder finishes it. Not thread-safe.
class OutputFolder {
 public:
  /// @param folder  may be a link to a folder, relative, `.`; is made with its parents when
  /// missing.
  /// @param owner   the command whose earlier results go: letters, digits and minus.
  /// @throws std::runtime_error naming the folder when it cannot be written, or when another
  /// program is writing its results there.
  OutputFolder(const std::filesystem::path& folder, std::string owner, FolderSeams seams = {});
  /// Without commit: removes what was written.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write. Exists, and is empty at first.
  const std::filesystem::path& path() const { return part_; }

  /// A file that the command reads: it stays in the folder, even where it is an earlier result.
  /// Paths outside of the folder, or of nothing, are allowed.
  void keep(const std::filesystem::path& input);

  /// Results of an earlier run that left no list: they go, too, unless kept.
  void drop(const std::vector<std::string>& names);

  /// The new results take their place. Every file below path() must be closed.
  /// @throws std::runtime_error naming the path and cause; then the folder is as it was, or, when
  /// the journal was begun, will be finished by whoever opens it next.
  void commit();

 private:
  void settle_beside();
  void settle_inside();
  bool take_part();
  void step(const char* name) const;
  bool link_others(const std::set<std::string>& results, const std::set<std::string>& stale);
  bool exchange();
  void move_in(const std::set<std::string>& results, const std::set<std::string>& stale);
  void bring_late_files();

  std::filesystem::path folder_;  ///< behind links
  std::string owner_;
  FolderSeams seams_;
  std::filesystem::path part_;
  FolderLock lock_;
  std::string why_not_;   ///< part_ cannot be used
  bool inside_ = false;   ///< part_ is in folder_, for the journal
  bool settled_ = false;  ///< part_ is ours
  bool done_ = false;     ///< nothing of part_ may be removed any more
  std::set<std::string> kept_;
  std::set<std::string> dropped_;
  std::vector<std::string> linked_;
  std::set<ino_t> seen_;  ///< files of folder_ when it was last looked at
};

}  // namespace marco::files
