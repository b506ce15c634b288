#include "drivers/transport/port_claim.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace marco::drivers {
namespace {

std::filesystem::path lock_of(const std::filesystem::path& link) {
  return link.parent_path() / ("." + link.filename().string() + ".lock");
}

struct flock whole_file() {
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  return whole;
}

/// Asks without taking the lock, which would disturb a simulator that starts just now.
bool is_held(int fd) {
  struct flock found = whole_file();
  return fcntl(fd, F_OFD_GETLK, &found) == 0 && found.l_type != F_UNLCK;
}

bool names_terminal(const std::filesystem::path& lock, int fd) {
  std::string name;
  std::getline(std::ifstream(lock), name);
  struct stat named {
  }, open{};
  return stat(name.c_str(), &named) == 0 && fstat(fd, &open) == 0 && S_ISCHR(named.st_mode) &&
         named.st_rdev == open.st_rdev;
}

}  // namespace

FileHandle claim_port(const std::string& link, const std::string& terminal) {
  FileHandle claim(::open(lock_of(link).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  struct flock whole = whole_file();
  if (!claim.valid() || fcntl(claim.get(), F_OFD_SETLK, &whole) != 0) {
    throw std::runtime_error(
        link + ": another simulator runs there; end it, or choose another folder (--ports)");
  }
  const std::string text = terminal + "\n";
  const bool written =
      ftruncate(claim.get(), 0) == 0 &&
      pwrite(claim.get(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
  if (!written) throw std::runtime_error(lock_of(link).string() + " cannot be written");
  return claim;
}

void give_up_port(const std::string& link, FileHandle& claim) {
  if (!claim.valid()) return;
  unlink(lock_of(link).c_str());
  claim.reset();
}

std::string why_no_device(const std::string& path, int fd) {
  if (!is_pseudo_terminal(fd)) return "";
  std::error_code ignored;
  std::filesystem::path link = path;
  constexpr int kMostLinks = 40;
  for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(link, ignored); ++i) {
    const std::filesystem::path lock = lock_of(link);
    const FileHandle file(::open(lock.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.valid() && !(is_held(file.get()) && names_terminal(lock, fd))) {
      return "the simulator that made this link has ended, and another program may own the "
             "terminal now: restart the simulator";
    }
    if (file.valid()) return "";
    link = link.parent_path() / std::filesystem::read_symlink(link, ignored);
  }
  if (!takes_keys(fd)) return "";
  return "this is a user's terminal, not a device. If your program is behind it, let it first set "
         "the terminal to raw mode";
}

}  // namespace marco::drivers
