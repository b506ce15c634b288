#include "lcm_tools/procman/process/folders.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "lcm_tools/process/state_folder.hpp"

namespace marco::procman {
namespace {

std::string lock_path(const std::string& runtime_folder) { return runtime_folder + "/lock"; }

// Its owner could make this deputy adopt commands that it never started.
void refuse_foreign_folder(const std::string& folder) {
  struct stat owner = {};
  if (stat(folder.c_str(), &owner) != 0 || (owner.st_uid != getuid() && owner.st_uid != 0)) {
    throw std::runtime_error("the runtime folder " + folder + " belongs to another user");
  }
}

}  // namespace

std::string default_runtime_folder() {
  const char* session = std::getenv("XDG_RUNTIME_DIR");
  return session == nullptr || *session == '\0' ? "/tmp/marco-procman-" + std::to_string(getuid())
                                                : std::string(session) + "/marco-procman";
}

std::string default_output_folder() { return process::state_folder("marco-procman"); }

Descriptor lock_runtime_folder(const std::string& runtime_folder) {
  std::filesystem::create_directories(runtime_folder);
  chmod(runtime_folder.c_str(), 0700);
  refuse_foreign_folder(runtime_folder);
  refuse_foreign_folder(std::filesystem::path(runtime_folder).parent_path());
  const std::string path = lock_path(runtime_folder);
  Descriptor lock(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!lock.is_open()) throw_errno("cannot open " + path);
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    throw std::runtime_error("another deputy uses the runtime folder " + runtime_folder);
  }
  return lock;
}

bool deputy_is_at_work(const std::string& deputy_id) {
  const std::string folder = default_runtime_folder() + "/" + process::file_name_of(deputy_id);
  const Descriptor lock(open(lock_path(folder).c_str(), O_RDONLY | O_CLOEXEC));
  return lock.is_open() && flock(lock.get(), LOCK_SH | LOCK_NB) != 0;
}

}  // namespace marco::procman
