#include "lcm_tools/procman/process/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <stdexcept>

namespace marco::procman {

void OutputFile::open() {
  file_.reset(::open(state_.output_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  struct stat status = {};
  if (!file_.is_open() || fstat(file_.get(), &status) != 0) {
    throw_errno("cannot write " + state_.output_file);
  }
  state_.output_inode = static_cast<int64_t>(status.st_ino);
  state_.output_end = status.st_size;
}

void OutputFile::begin_new_file() {
  try {
    const std::string old = state_.output_file + ".1";
    if (rename(state_.output_file.c_str(), old.c_str()) != 0) throw_errno(old);
    open();
    state_.output_begin = state_.output_shown = 0;
  } catch (const std::runtime_error&) {
    // Somebody has removed the folder: the open file is emptied instead.
    if (file_.is_open() && ftruncate(file_.get(), 0) == 0) state_.output_end = 0;
  }
}

void OutputFile::write(const char* bytes, std::size_t size) {
  if (state_.output_end > 0 &&
      state_.output_end + static_cast<int64_t>(size) > state_.output_limit) {
    begin_new_file();
  }
  while (size > 0) {
    const ssize_t written = ::write(file_.get(), bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      state_.output_lost += static_cast<int64_t>(size);
      return;
    }
    bytes += written;
    size -= static_cast<std::size_t>(written);
    state_.output_end += written;
  }
}

}  // namespace marco::procman
