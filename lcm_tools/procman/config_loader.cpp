// A procman file with all that it includes.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/group_index.hpp"

namespace marco::procman {
namespace {

class Loader {
 public:
  explicit Loader(const FileReader& read_file) : read_file_(read_file) {}

  /// @param depth 0 for the file that nobody includes.
  void load(const std::string& path, int depth) {
    const std::string text = read_file_(path);
    bytes_ += text.size();
    if (bytes_ > kMaxConfigBytes) {
      throw std::runtime_error(path + " makes all files together longer than " +
                               std::to_string(kMaxConfigBytes >> 20) + " MB");
    }
    const Config file = parse_config(text, path);
    begun_.insert(identity(path));
    open_.insert(identity(path));
    for (const Include& include : file.includes) load_included(path, include, depth + 1);
    open_.erase(identity(path));
    merge(merged.root, file.root, "");
    merged.scripts.insert(merged.scripts.end(), file.scripts.begin(), file.scripts.end());
  }

  Config merged;

 private:
  /// The same for all ways to write a path.
  static std::string identity(const std::string& path) {
    std::error_code unknown;
    const auto real = std::filesystem::weakly_canonical(path, unknown);
    return unknown ? std::filesystem::path(path).lexically_normal() : real;
  }

  void load_included(const std::string& from, const Include& include, int depth) {
    const std::string path =
        (std::filesystem::path(from).parent_path() / include.path).lexically_normal();
    const std::string known = identity(path);
    if (open_.contains(known)) {
      throw ConfigError(include.place, "expected a file that does not include itself, got " + path);
    }
    if (begun_.contains(known)) return;
    if (depth > kMaxIncludeDepth || begun_.size() >= kMaxConfigFiles) {
      throw ConfigError(include.place, "expected at most " + std::to_string(kMaxConfigFiles) +
                                           " files, included at most " +
                                           std::to_string(kMaxIncludeDepth) +
                                           " deep, got one more: " + path);
    }
    try {
      load(path, depth);
    } catch (const ConfigError&) {
      throw;
    } catch (const std::runtime_error& failure) {
      throw ConfigError(include.place, failure.what());
    }
  }

  // Recursive as the groups are.
  void merge(GroupConfig& into, const GroupConfig& from, const std::string& path) {
    into.commands.insert(into.commands.end(), from.commands.begin(), from.commands.end());
    for (const GroupConfig& group : from.groups) {
      const std::string inner = group_path(path, group.name);
      merge(groups_.open(into, group.name, inner), group, inner);
    }
  }

  const FileReader& read_file_;
  GroupIndex groups_;
  std::set<std::string> begun_;
  std::set<std::string> open_;  ///< those that are being read now
  std::size_t bytes_ = 0;
};

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw std::runtime_error("cannot read the procman file " + path + ": " + why);
}

// A device would never end, a pipe without a writer would never open.
std::string read_regular_file(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  if (fd < 0) refuse(path, std::strerror(errno));
  struct stat status = {};
  std::string text;
  std::string why;
  if (fstat(fd, &status) != 0) {
    why = std::strerror(errno);
  } else if (!S_ISREG(status.st_mode)) {
    why = std::string("it is ") + kind_of(status.st_mode) + ", not a file";
  }
  char bytes[65536];
  for (ssize_t size = 1; why.empty() && size > 0;) {
    size = read(fd, bytes, sizeof bytes);
    if (size < 0) why = std::strerror(errno);
    if (size > 0) text.append(bytes, static_cast<std::size_t>(size));
    if (text.size() > kMaxConfigBytes) {
      why = "it is longer than " + std::to_string(kMaxConfigBytes >> 20) + " MB";
    }
  }
  close(fd);
  if (!why.empty()) refuse(path, why);
  return text;
}

}  // namespace

Config load_config(const std::string& path, const FileReader& read_file) {
  Loader loader(read_file);
  loader.load(path, 0);
  return std::move(loader.merged);
}

Config load_config(const std::string& path) { return load_config(path, read_regular_file); }

}  // namespace marco::procman
