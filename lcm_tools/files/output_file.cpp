#include "lcm_tools/files/output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace marco::files {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = 256 << 10;
constexpr mode_t kEverybodyReads = 0666;

[[noreturn]] void cannot_write(const fs::path& path, const std::string& why) {
  throw std::runtime_error(path.string() + ": cannot be written: " + why);
}

// What a device or a pipe takes is not replaced; nor are names of descriptors (/dev/stdout).
bool written_in_place(const fs::path& path, const struct stat& status) {
  const std::string& name = path.native();
  return !S_ISREG(status.st_mode) || name.starts_with("/dev/") || name.starts_with("/proc/");
}

bool locked(int descriptor) {
  return flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

// @returns whether the unfinished file of a program that was killed stood there, and is gone.
bool remove_left_over(const fs::path& part) {
  const int descriptor = open(part.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return false;
  struct stat status = {};
  const bool removed = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) &&
                       status.st_uid == geteuid() && locked(descriptor) &&
                       unlink(part.c_str()) == 0;
  close(descriptor);
  return removed;
}

bool still_there(int descriptor, const fs::path& path) {
  struct stat ours = {}, there = {};
  return fstat(descriptor, &ours) == 0 && lstat(path.c_str(), &there) == 0 &&
         ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
}

int create_exclusively(const fs::path& part) {
  const int flags = O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  int descriptor = open(part.c_str(), flags, kEverybodyReads);
  if (descriptor < 0 && errno == EEXIST) {
    if (!remove_left_over(part)) {
      errno = EEXIST;
      return -1;
    }
    descriptor = open(part.c_str(), flags, kEverybodyReads);
  }
  if (descriptor < 0) return -1;
  // Another program may have taken it for a left-over before it was locked.
  if (locked(descriptor) && still_there(descriptor, part)) return descriptor;
  close(descriptor);
  errno = EEXIST;
  return -1;
}

}  // namespace

fs::path behind_links(const fs::path& path) {
  fs::path target = fs::absolute(path).lexically_normal();
  if (!target.has_filename()) target = target.parent_path();
  constexpr int kMostLinks = 40;
  for (int links = 0; links < kMostLinks; ++links) {
    std::error_code none;
    fs::path whole = fs::canonical(target, none);
    if (!none) return whole;
    const fs::path link = fs::read_symlink(target, none);
    if (none) {
      const fs::path parent = fs::canonical(target.parent_path(), none);
      return none ? target : parent / target.filename();
    }
    target = (target.parent_path() / link).lexically_normal();
    if (!target.has_filename()) target = target.parent_path();
  }
  cannot_write(path, "its links form a cycle");
}

void sync_to_disk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;  // a link, or not ours to read: nothing of ours is in it
  const bool failed = fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS;
  const int error = errno;
  close(descriptor);
  if (failed) cannot_write(path, std::strerror(error));
}

OutputFile::OutputFile(fs::path path, Appears appears, const std::string& part_ending)
    : path_(std::move(path)), appears_(appears) {
  struct stat status = {};
  const bool exists = stat(path_.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) cannot_write(path_, "it is a folder");
  if (exists && S_ISBLK(status.st_mode)) cannot_write(path_, "it is a disk");
  if (exists && written_in_place(path_, status)) appears_ = Appears::at_once;
  if (appears_ == Appears::at_once) {
    part_path_ = target_ = path_;
    descriptor_ =
        open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOCTTY | O_CLOEXEC, kEverybodyReads);
    if (descriptor_ < 0) fail("created");
  } else {
    target_ = behind_links(path_);
    open_part(target_, part_ending);
    // Whom it belongs to and who may read it stays; only root can give a file away.
    const bool same_owner = !exists || status.st_uid == geteuid() ||
                            fchown(descriptor_, status.st_uid, status.st_gid) == 0;
    if (exists && same_owner) fchmod(descriptor_, status.st_mode & 07777U);
  }
  buffer_.reserve(kBufferBytes);
}

void OutputFile::open_part(const fs::path& target, const std::string& ending) {
  constexpr int kMostNames = 100;
  for (int i = 0; i < kMostNames; ++i) {
    part_path_ = target;
    if (i > 0) part_path_ += "." + std::to_string(getpid()) + "-" + std::to_string(i);
    part_path_ += ending;
    descriptor_ = create_exclusively(part_path_);
    if (descriptor_ >= 0) return;
    if (errno != EEXIST) break;
  }
  fail("created");
}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  if (appears_ == Appears::at_once) {
    try {
      flush();
    } catch (const std::runtime_error&) {  // callers who need the error use flush() or finish()
    }
  } else if (still_there(descriptor_, part_path_)) {
    unlink(part_path_.c_str());
  }
  close(descriptor_);
}

void OutputFile::fail(const char* what) const {
  const int error = errno;
  throw std::runtime_error(path_.string() + ": cannot be " + what + ": " + std::strerror(error));
}

void OutputFile::write_through(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail("written");
    written_ += done;
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
}

void OutputFile::flush() {
  write_through(buffer_);
  buffer_.clear();
}

void OutputFile::write(std::span<const uint8_t> bytes) {
  if (buffer_.size() + bytes.size() > kBufferBytes) flush();
  if (bytes.size() >= kBufferBytes) {
    write_through(bytes);
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
}

void OutputFile::write(std::string_view text) {
  write(std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
}

void OutputFile::copy_from(int descriptor, int64_t offset, int64_t count) {
  flush();
  off64_t from = offset;
  while (count > 0) {
    const ssize_t done = copy_file_range(descriptor, &from, descriptor_, nullptr,
                                         static_cast<std::size_t>(count), 0);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) break;  // other file systems, old kernels: copied below
    written_ += done;
    count -= done;
  }
  offset = from;
  while (count > 0) {
    if (buffer_.size() == kBufferBytes) flush();
    const std::size_t old_size = buffer_.size();
    const std::size_t step = std::min(static_cast<std::size_t>(count), kBufferBytes - old_size);
    buffer_.resize(old_size + step);
    const ssize_t got = pread(descriptor, buffer_.data() + old_size, step, offset);
    buffer_.resize(old_size + static_cast<std::size_t>(std::max<ssize_t>(0, got)));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw std::runtime_error(path_.string() + ": its source shrank while it was read");
    offset += got;
    count -= got;
  }
}

void OutputFile::put_in_place() {
  if (!still_there(descriptor_, part_path_)) {
    cannot_write(path_, "another program took " + part_path_.filename().string() + " away");
  }
  if (rename(part_path_.c_str(), target_.c_str()) != 0) fail("written");
  if (appears_ == Appears::when_whole) sync_to_disk(target_.parent_path());
}

void OutputFile::finish() {
  flush();
  if (appears_ != Appears::when_renamed && fsync(descriptor_) != 0 && errno != EINVAL &&
      errno != EROFS && errno != ENOTSUP) {
    fail("written");
  }
  if (appears_ != Appears::at_once) put_in_place();
  if (close(std::exchange(descriptor_, -1)) != 0) fail("written");
}

}  // namespace marco::files
