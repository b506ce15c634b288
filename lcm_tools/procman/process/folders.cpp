#include "lcm_tools/procman/process/folders.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>

namespace marco::procman {
namespace {

constexpr std::size_t kMaxFileName = 200;

std::string from_environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

std::string lock_path(const std::string& runtime_folder) { return runtime_folder + "/lock"; }

// Its owner could make this deputy adopt commands that it never started.
void refuse_foreign_folder(const std::string& folder) {
  struct stat owner = {};
  if (stat(folder.c_str(), &owner) != 0 || (owner.st_uid != getuid() && owner.st_uid != 0)) {
    throw std::runtime_error("the runtime folder " + folder + " belongs to another user");
  }
}

}  // namespace

std::string file_name_of(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '_' || c == '-' || (c == '.' && !out.empty());
    if (plain) {
      out += c;
    } else {
      const char* digits = "0123456789ABCDEF";
      out += '%';
      out += digits[static_cast<unsigned char>(c) >> 4];
      out += digits[static_cast<unsigned char>(c) & 15];
    }
  }
  if (out.size() <= kMaxFileName) return out;
  return out.substr(0, kMaxFileName) + "-" + std::to_string(std::hash<std::string>{}(name));
}

std::string default_runtime_folder() {
  const std::string session = from_environment("XDG_RUNTIME_DIR");
  return session.empty() ? "/tmp/marco-procman-" + std::to_string(getuid())
                         : session + "/marco-procman";
}

std::string state_folder(const std::string& program) {
  const std::string state = from_environment("XDG_STATE_HOME");
  if (!state.empty()) return state + "/" + program;
  const std::string home = from_environment("HOME");
  return home.empty() ? "/tmp/" + program + "-" + std::to_string(getuid())
                      : home + "/.local/state/" + program;
}

std::string default_output_folder() {
  return from_environment("XDG_STATE_HOME").empty() && from_environment("HOME").empty()
             ? default_runtime_folder()
             : state_folder("marco-procman");
}

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
  const std::string folder = default_runtime_folder() + "/" + file_name_of(deputy_id);
  const Descriptor lock(open(lock_path(folder).c_str(), O_RDONLY | O_CLOEXEC));
  return lock.is_open() && flock(lock.get(), LOCK_SH | LOCK_NB) != 0;
}

}  // namespace marco::procman
