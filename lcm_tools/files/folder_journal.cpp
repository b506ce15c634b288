#include "lcm_tools/files/folder_journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/readable.hpp"

namespace marco::files {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFirstLine = "marco journal 1";
constexpr const char* kLastLine = "end";

void step(const AtStep& at, const char* name) {
  if (at) at(name);
}

[[noreturn]] void cannot_finish(const fs::path& folder, const std::string& why) {
  throw std::runtime_error(folder.string() +
                           ": a command was killed while it stored its results here, and they "
                           "cannot be completed now (" +
                           why + "); use the folder once as the user it belongs to");
}

// @returns nothing when the file is not a whole journal.
std::optional<FolderMove> read_journal(const fs::path& path) {
  std::istringstream file(first_bytes(path, 16 << 20));
  FolderMove move;
  std::string line;
  if (!std::getline(file, line) || line != kFirstLine) return std::nullopt;
  while (std::getline(file, line)) {
    if (line == kLastLine) return move;
    if (line.starts_with("put ")) move.put.push_back(line.substr(4));
    if (line.starts_with("drop ")) move.drop.push_back(line.substr(5));
  }
  return std::nullopt;
}

// Folders that this leaves empty go with their last file.
void remove_with_empty_parents(const fs::path& folder, const std::string& name) {
  std::error_code none;
  fs::remove(folder / name, none);
  for (fs::path parent = fs::path(name).parent_path(); !parent.empty();
       parent = parent.parent_path()) {
    if (rmdir((folder / parent).c_str()) != 0) return;
  }
}

void carry_out(const fs::path& folder, const FolderMove& move, const AtStep& at) {
  const fs::path work = folder / kWorkFolder;
  std::set<fs::path> changed{folder};
  for (const std::string& name : move.put) {
    const fs::path from = work / name, to = folder / name;
    struct stat status = {};
    if (lstat(from.c_str(), &status) != 0) continue;  // moved before the program was killed
    step(at, "move a result");
    std::error_code failure;
    fs::create_directories(to.parent_path(), failure);
    if (rename(from.c_str(), to.c_str()) != 0) cannot_finish(folder, std::strerror(errno));
    changed.insert(to.parent_path());
  }
  for (const std::string& name : move.drop) {
    struct stat status = {};
    if (lstat((folder / name).c_str(), &status) != 0) continue;
    step(at, "remove an old result");
    remove_with_empty_parents(folder, name);
  }
  for (const fs::path& path : changed) sync_to_disk(path);
  step(at, "remove the journal");
  if (unlink((folder / kJournal).c_str()) != 0) cannot_finish(folder, std::strerror(errno));
  sync_to_disk(folder);
  step(at, "remove the work folder");
  std::error_code none;
  fs::remove_all(work, none);
}

}  // namespace

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool FolderLock::take(const fs::path& unfinished) {
  const fs::path mark = unfinished / kWorkMark;
  constexpr int kTries = 10;  // the program that held it may just have removed it
  for (int i = 0; i < kTries; ++i) {
    // Not closed in programs that this one starts: they write into the folder, and may outlive it.
    const int descriptor = open(mark.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW, 0666);
    if (descriptor < 0) {
      throw std::runtime_error(mark.string() + ": cannot be created: " + std::strerror(errno));
    }
    struct stat ours = {}, there = {};
    const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
    const bool same = fstat(descriptor, &ours) == 0 && lstat(mark.c_str(), &there) == 0 &&
                      ours.st_ino == there.st_ino;
    if (locked && same) {
      descriptor_ = descriptor;
      return true;
    }
    close(descriptor);
    if (!locked) return false;
  }
  return false;
}

void move_results(const fs::path& folder, const FolderMove& move, const AtStep& at) {
  std::string text = std::string(kFirstLine) + "\n";
  for (const std::string& name : move.put) text += "put " + name + "\n";
  for (const std::string& name : move.drop) text += "drop " + name + "\n";
  text += std::string(kLastLine) + "\n";
  // What may still fail for want of space is done before there is no way back.
  for (const std::string& name : move.put) fs::create_directories((folder / name).parent_path());
  step(at, "write the journal");
  OutputFile journal(folder / kJournal);
  journal.write(text);
  journal.finish();
  carry_out(folder, move, at);
}

void finish_interrupted(const fs::path& folder, const AtStep& at) {
  const fs::path journal = (folder.empty() ? fs::path(".") : folder) / kJournal;
  if (access(journal.c_str(), F_OK) != 0) return;
  const fs::path home = journal.parent_path();
  const fs::path work = home / kWorkFolder;
  // Somebody may be at it right now: that takes milliseconds.
  constexpr std::chrono::seconds kPatience{10};
  const auto end = std::chrono::steady_clock::now() + kPatience;
  FolderLock lock;
  while (access(work.c_str(), F_OK) == 0 && !lock.take(work)) {
    if (std::chrono::steady_clock::now() > end) cannot_finish(home, "another program is using it");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  if (access(journal.c_str(), F_OK) != 0) return;
  const std::optional<FolderMove> move = read_journal(journal);
  // Without its new files the old ones are all there is.
  const bool whole = move.has_value() && access(work.c_str(), F_OK) == 0;
  carry_out(home, whole ? *move : FolderMove{}, at);
}

}  // namespace marco::files
