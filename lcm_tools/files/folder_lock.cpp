#include "lcm_tools/files/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace marco::files {

namespace fs = std::filesystem;

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

}  // namespace marco::files
