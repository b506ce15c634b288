#include "lcm_tools/process/state_folder.hpp"

#include <unistd.h>

#include <cstdlib>
#include <functional>

namespace marco::process {
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

std::string state_folder(const std::string& program) {
  const std::string state = from_environment("XDG_STATE_HOME");
  if (!state.empty()) return state + "/" + program;
  const std::string home = from_environment("HOME");
  return home.empty() ? "/tmp/" + program + "-" + std::to_string(getuid())
                      : home + "/.local/state/" + program;
}

}  // namespace marco::process
