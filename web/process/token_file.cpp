#include "web/process/token_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "lcm_tools/process/state_folder.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "web/access.hpp"

namespace marco::web {
namespace {

namespace fs = std::filesystem;
using procman::Descriptor;

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw std::runtime_error("the token's file " + file.string() + " " + why);
}

/// Whole or not at all, though two pages begin at once.
void make(const fs::path& file) {
  const std::string part = file.string() + "." + std::to_string(getpid()) + ".part";
  unlink(part.c_str());
  const Descriptor out(open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!out.is_open())
    procman::throw_errno("the token's file " + file.string() + " cannot be created");
  const std::string line = new_token() + "\n";
  const bool is_written = write(out.get(), line.data(), line.size()) == ssize_t(line.size()) &&
                          fsync(out.get()) == 0 &&
                          (link(part.c_str(), file.c_str()) == 0 || errno == EEXIST);
  const int failure = errno;
  unlink(part.c_str());
  errno = failure;
  if (!is_written) procman::throw_errno("the token's file " + file.string() + " cannot be created");
}

void require_own(const fs::path& file, const Descriptor& in) {
  struct stat status = {};
  if (fstat(in.get(), &status) != 0) procman::throw_errno(file.string());
  if (!S_ISREG(status.st_mode)) refuse(file, "is no regular file");
  if (status.st_uid != geteuid()) refuse(file, "belongs to another user");
  if ((status.st_mode & 077U) != 0) refuse(file, "can be read by others: chmod 600 it");
}

}  // namespace

std::string token_in(const fs::path& file) {
  constexpr int kHow = O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC;
  Descriptor in(open(file.c_str(), kHow));
  if (!in.is_open() && errno == ENOENT) {
    make(file);
    in.reset(open(file.c_str(), kHow));
  }
  if (!in.is_open() && errno == ELOOP) refuse(file, "is a link");
  if (!in.is_open()) procman::throw_errno("the token's file " + file.string());
  require_own(file, in);
  std::array<char, 1024> text;
  const ssize_t size = read(in.get(), text.data(), text.size());
  if (size < 0) procman::throw_errno("the token's file " + file.string());
  std::string token(text.data(), static_cast<std::size_t>(size));
  token.resize(token.find_last_not_of(" \t\r\n") + 1);
  const std::string weak = why_weak(token);
  if (!weak.empty()) refuse(file, "holds a token that " + weak);
  return token;
}

fs::path page_folder() {
  const fs::path folder = process::state_folder("marco-page");
  std::error_code error;
  fs::create_directories(folder.parent_path(), error);
  struct stat status = {};
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    procman::throw_errno("the folder " + folder.string() + " cannot be created");
  }
  const bool is_own =
      lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid();
  if (!is_own) throw std::runtime_error(folder.string() + " is not a folder of this user");
  chmod(folder.c_str(), 0700);
  return folder;
}

}  // namespace marco::web
