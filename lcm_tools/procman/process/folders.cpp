#include "lcm_tools/procman/process/folders.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>

#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::procman {
namespace {

constexpr std::size_t kMaxFileName = 200;

std::string from_environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
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

std::string default_output_folder() {
  const std::string state = from_environment("XDG_STATE_HOME");
  if (!state.empty()) return state + "/marco-procman";
  const std::string home = from_environment("HOME");
  return home.empty() ? default_runtime_folder() : home + "/.local/state/marco-procman";
}

std::string lock_path(const std::string& runtime_folder) { return runtime_folder + "/lock"; }

bool deputy_is_at_work(const std::string& deputy_id) {
  const std::string folder = default_runtime_folder() + "/" + file_name_of(deputy_id);
  const Descriptor lock(open(lock_path(folder).c_str(), O_RDONLY | O_CLOEXEC));
  return lock.is_open() && flock(lock.get(), LOCK_SH | LOCK_NB) != 0;
}

}  // namespace marco::procman
