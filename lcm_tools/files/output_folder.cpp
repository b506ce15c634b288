#include "lcm_tools/files/output_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <thread>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/result_list.hpp"

namespace marco::files {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw std::runtime_error(path.string() + ": " + why);
}

// Two mounts cannot exchange names, nor hand each other files.
bool on_one_mount(const fs::path& a, const fs::path& b) {
  struct statx of_a = {}, of_b = {};
  const unsigned wanted = STATX_BASIC_STATS | STATX_MNT_ID;
  return statx(AT_FDCWD, a.c_str(), 0, wanted, &of_a) == 0 &&
         statx(AT_FDCWD, b.c_str(), 0, wanted, &of_b) == 0 &&
         of_a.stx_dev_major == of_b.stx_dev_major && of_a.stx_dev_minor == of_b.stx_dev_minor &&
         of_a.stx_mnt_id == of_b.stx_mnt_id;
}

bool somebody_stands_in(const fs::path& folder) {
  std::error_code none;
  const fs::path here = fs::current_path(none).lexically_relative(folder);
  return !none && !here.empty() && *here.begin() != "..";
}

// Whether a sibling folder that we make can replace it.
bool can_be_replaced(const fs::path& folder) {
  struct stat status = {};
  const fs::path parent = folder.parent_path();
  return folder.has_filename() && stat(folder.c_str(), &status) == 0 &&
         (status.st_uid == geteuid() || geteuid() == 0) &&
         access(parent.c_str(), W_OK | X_OK) == 0 && on_one_mount(folder, parent) &&
         !somebody_stands_in(folder);
}

// A folder of somebody's own, whose name happens to be that of our work, is left alone.
bool is_work_of_ours(const fs::path& part) {
  struct stat status = {};
  return lstat(part.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == geteuid() &&
         (fs::is_empty(part) || fs::is_regular_file(fs::symlink_status(part / kWorkMark)));
}

void remove_all_but(const fs::path& folder, const char* name) {
  std::vector<fs::path> rest;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() != name) rest.push_back(entry.path());
  }
  for (const fs::path& path : rest) fs::remove_all(path);
}

void sync_folders_to_disk(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.symlink_status().type() == fs::file_type::directory) sync_to_disk(entry.path());
  }
  sync_to_disk(folder);
}

fs::path old_name_of(const fs::path& folder) { return folder.string() + ".part.old"; }

// Folders that this leaves empty go with their last file.
void remove_with_empty_parents(const fs::path& folder, const std::string& name) {
  std::error_code none;
  fs::remove(folder / name, none);
  for (fs::path parent = fs::path(name).parent_path(); !parent.empty();
       parent = parent.parent_path()) {
    if (rmdir((folder / parent).c_str()) != 0) return;
  }
}

ino_t inode_of(const fs::path& path) {
  struct stat status = {};
  return lstat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

// The permissions and the owner of a folder, and of those in it that are empty or in both.
void copy_folders(const fs::path& from, const fs::path& to) {
  const auto copy_one = [](const fs::path& old, const fs::path& now) {
    struct stat status = {};
    if (stat(old.c_str(), &status) != 0) return;
    mkdir(now.c_str(), 0777);
    const bool given =
        status.st_uid == geteuid() || chown(now.c_str(), status.st_uid, status.st_gid) == 0;
    if (given) chmod(now.c_str(), status.st_mode & 07777U);
  };
  copy_one(from, to);
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    if (entry.symlink_status().type() != fs::file_type::directory) continue;
    const fs::path now = to / entry.path().lexically_relative(from);
    if (fs::is_empty(entry.path()) || fs::is_directory(now)) copy_one(entry.path(), now);
  }
}

// The programs that a killed command had started hold its lock until they have died, too.
bool take_patiently(FolderLock& lock, const fs::path& part) {
  constexpr int kTries = 20;
  constexpr std::chrono::milliseconds kPause{100};
  for (int i = 0; i < kTries; ++i) {
    if (lock.take(part)) return true;
    std::this_thread::sleep_for(kPause);
  }
  return false;
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& folder, std::string owner, FolderSeams seams)
    : folder_(behind_links(folder)), owner_(std::move(owner)), seams_(std::move(seams)) {
  // A program was killed between two renames.
  if (!fs::exists(folder_) && is_work_of_ours(old_name_of(folder_))) {
    rename(old_name_of(folder_).c_str(), folder_.c_str());
  }
  const bool exists = fs::exists(folder_);
  if (exists && !fs::is_directory(folder_)) refuse(folder, "is a file; give a folder's name");
  if (exists && access(folder_.c_str(), W_OK | X_OK) != 0) {
    refuse(folder, std::string("cannot be written: ") + std::strerror(errno));
  }
  if (!exists) fs::create_directories(folder_.parent_path());
  if (!exists || can_be_replaced(folder_)) settle_beside();
  if (state_ == State::unusable && exists) settle_inside();
  if (state_ == State::unusable)
    refuse(part_, "cannot be used for unfinished results: " + why_not_);
}

void OutputFolder::settle_beside() {
  part_ = folder_;
  part_ += ".part";
  state_ = take_part();
}

void OutputFolder::settle_inside() {
  part_ = folder_ / kWorkFolder;
  inside_ = true;
  state_ = take_part();
}

// @returns unusable when it cannot be made, or is somebody's own.
OutputFolder::State OutputFolder::take_part() {
  if (mkdir(part_.c_str(), 0777) != 0) {
    why_not_ = std::strerror(errno);
    if (errno != EEXIST) return State::unusable;
    why_not_ = "Marco did not make it; move it away";
    if (!is_work_of_ours(part_)) return State::unusable;
  }
  if (!take_patiently(lock_, part_)) {
    refuse(folder_,
           "another program is writing its results there; wait for it, or give another folder");
  }
  remove_all_but(part_, kWorkMark);
  return State::open;
}

OutputFolder::~OutputFolder() {
  std::error_code none;
  if (state_ == State::open) fs::remove_all(part_, none);
}

void OutputFolder::step(const char* name) const {
  if (seams_.at_step) seams_.at_step(name);
}

void OutputFolder::keep(const fs::path& input) {
  std::error_code none;
  const fs::path whole = fs::canonical(input, none);
  if (!none) kept_.insert(whole.lexically_relative(folder_).string());
}

void OutputFolder::drop(const std::vector<std::string>& names) {
  dropped_.insert(names.begin(), names.end());
}

// @returns false when files must be moved one by one; what was linked stands in linked_.
bool OutputFolder::link_others(const std::set<std::string>& results,
                               const std::set<std::string>& stale) try {
  constexpr std::size_t kMostOthers = 1000;
  const std::size_t most = results.size() + stale.size() + kMostOthers;
  const std::vector<std::string> there = files_below(folder_, most);
  if (there.size() > most) return false;
  seen_.clear();
  for (const std::string& name : there) {
    seen_.insert(inode_of(folder_ / name));
    if (results.contains(name) || stale.contains(name)) continue;
    fs::create_directories((part_ / name).parent_path());
    if (linkat(AT_FDCWD, (folder_ / name).c_str(), AT_FDCWD, (part_ / name).c_str(), 0) != 0) {
      return false;
    }
    linked_.push_back(name);
  }
  copy_folders(folder_, part_);
  sync_folders_to_disk(part_);
  return true;
} catch (const fs::filesystem_error&) {  // a sub-folder that we may not read
  return false;
}

bool OutputFolder::exchange() {
  // The old folder gets the mark of what may be removed before it gets the other's name.
  step("mark the old folder");
  const fs::path mark = folder_ / kWorkMark;
  unlink(mark.c_str());
  if (link((part_ / kWorkMark).c_str(), mark.c_str()) != 0) return false;
  step("exchange");
  int error = seams_.exchange ? seams_.exchange(part_, folder_)
              : renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, folder_.c_str(), RENAME_EXCHANGE) == 0
                  ? 0
                  : errno;
  if (error == EINVAL || error == ENOSYS) error = rename_both();
  if (error != 0) {
    unlink(mark.c_str());
    return false;
  }
  state_ = State::done;
  step("sync the parent folder");
  sync_to_disk(folder_.parent_path());
  bring_late_files();
  step("unmark the new folder");
  unlink(mark.c_str());
  step("remove the old folder");
  std::error_code none;
  fs::remove_all(part_, none);
  return true;
}

// For file systems that know no exchange. @returns an errno, 0 = done.
int OutputFolder::rename_both() {
  const fs::path old = old_name_of(folder_);
  if (is_work_of_ours(old)) fs::remove_all(old);  // of a program that was killed later on
  if (rename(folder_.c_str(), old.c_str()) != 0) return errno;
  step("name the new folder");
  if (rename(part_.c_str(), folder_.c_str()) != 0) {
    const int error = errno;
    rename(old.c_str(), folder_.c_str());
    return error;
  }
  part_ = old;
  return 0;
}

// What somebody made, or replaced, in the old folder since it was looked through.
void OutputFolder::bring_late_files() {
  for (const std::string& name : files_below(part_)) {
    const fs::path from = part_ / name, to = folder_ / name;
    if (seen_.contains(inode_of(from))) continue;
    std::error_code none;
    fs::create_directories(to.parent_path(), none);
    rename(from.c_str(), to.c_str());
  }
}

void OutputFolder::move_in(const std::set<std::string>& results,
                           const std::set<std::string>& stale) {
  for (const std::string& name : linked_) unlink((part_ / name).c_str());
  if (!inside_) {
    step("bring the work folder in");
    const fs::path within = folder_ / kWorkFolder;
    std::error_code none;
    fs::remove_all(within, none);
    if (rename(part_.c_str(), within.c_str()) != 0) {
      refuse(folder_, std::string("cannot be written: ") + std::strerror(errno));
    }
    part_ = within;
    inside_ = true;
  }
  // What may fail for want of space is done before the first of them moves.
  for (const std::string& name : results) fs::create_directories((folder_ / name).parent_path());
  const std::string list = list_name(owner_);
  for (const std::string& name : results) {
    if (name != list) move_one(name);
  }
  for (const std::string& name : stale) {
    if (results.contains(name)) continue;
    step("remove an old result");
    remove_with_empty_parents(folder_, name);
  }
  move_one(list);  // last: until then the next run knows the old results
  state_ = State::done;
  std::error_code none;
  fs::remove_all(part_, none);
}

void OutputFolder::move_one(const std::string& name) const {
  step("move a result");
  const fs::path to = folder_ / name;
  if (rename((part_ / name).c_str(), to.c_str()) != 0) {
    refuse(to, std::string("cannot be written: ") + std::strerror(errno));
  }
  sync_to_disk(to.parent_path());
}

void OutputFolder::commit() {
  require(state_ == State::open, "OutputFolder: committed twice");
  std::set<std::string> results, stale = dropped_;
  for (std::string& name : files_below(part_)) results.insert(std::move(name));
  std::vector<std::string> kept;  // earlier results that stay stay results
  for (std::string& name : unchanged_results(folder_, owner_)) stale.insert(std::move(name));
  for (const std::string& name : kept_) {
    if (stale.erase(name) > 0 && !results.contains(name)) kept.push_back(name);
  }
  write_result_list(part_, owner_, folder_, kept);
  results.insert(list_name(owner_));
  for (const std::string& name : results) {
    if (fs::is_directory(fs::symlink_status(folder_ / name))) {
      refuse(folder_ / name, "is a folder; a result with this name belongs there");
    }
    sync_to_disk(part_ / name);
  }
  sync_folders_to_disk(part_);
  if (!fs::exists(folder_)) {
    step("name the new folder");
    if (rename(part_.c_str(), folder_.c_str()) != 0) {
      refuse(folder_, std::string("cannot be created: ") + std::strerror(errno));
    }
    state_ = State::done;
    sync_to_disk(folder_.parent_path());
    step("unmark the new folder");
    unlink((folder_ / kWorkMark).c_str());
    return;
  }
  step("link others' files");
  if (!inside_ && link_others(results, stale) && exchange()) return;
  move_in(results, stale);
}

}  // namespace marco::files
