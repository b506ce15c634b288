#include "lcm_tools/files/readable.hpp"

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

std::string name_of(uid_t user) {
  const passwd* found = ::getpwuid(user);
  return found == nullptr ? std::to_string(user) : found->pw_name;
}

std::string permission_text(const std::filesystem::path& path) {
  std::string text = "permission denied to " + name_of(::geteuid());
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return text + " by a parent folder";
  return text + ": it belongs to " + name_of(status.st_uid) + ", who can permit it with `chmod +r`";
}

}  // namespace

std::string why_not_readable(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) {
    const char* kind = S_ISFIFO(status.st_mode)   ? "pipe"
                       : S_ISSOCK(status.st_mode) ? "socket"
                                                  : "device";
    return std::string("it is a ") + kind + ", not a file";
  }
  // One that has become a FIFO is not waited for.
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file >= 0) {
    ::close(file);
    return {};
  }
  if (errno == EACCES || errno == EPERM) return permission_text(path);
  if (errno == ENOENT) return "there is no such file or folder";
  return std::strerror(errno);
}

void require_readable(const std::filesystem::path& path) {
  const std::string why = why_not_readable(path);
  require(why.empty(), path.string() + ": " + why);
}

std::ifstream open_readable(const std::filesystem::path& path) {
  require_readable(path);
  return std::ifstream(path, std::ios::binary);
}

int64_t next_data(int file, int64_t offset) {
  const off_t data = ::lseek(file, offset, SEEK_DATA);
  if (data >= 0) return data;
  return errno == ENXIO ? std::max<int64_t>(offset, ::lseek(file, 0, SEEK_END)) : offset;
}

std::string first_bytes(const std::filesystem::path& path, std::size_t most) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return "";
  std::ifstream file(path, std::ios::binary);
  std::string bytes(most, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(most));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  return bytes;
}

}  // namespace marco::files
