#include "recordings/ros/temporary_file.hpp"

#include <stdlib.h>  // mkstemp
#include <unistd.h>

#include <cstring>
#include <stdexcept>
#include <utility>

namespace marco::ros {
namespace {

// A disk that is full stops recorders and desktops: a small file may unpack to any size.
constexpr uint64_t kLeftToOthers = uint64_t{1} << 30;
constexpr uint64_t kBetweenLooks = uint64_t{64} << 20;

}  // namespace

TemporaryFile::TemporaryFile(std::string what) : what_(std::move(what)) {
  std::string name = (std::filesystem::temp_directory_path() / "marco_XXXXXX").string();
  fd_ = ::mkstemp(name.data());
  path_ = name;
  if (fd_ < 0) refuse("cannot be made: " + std::string(std::strerror(errno)));
}

TemporaryFile::~TemporaryFile() {
  if (fd_ < 0) return;
  ::close(fd_);
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void TemporaryFile::append(std::span<const uint8_t> bytes) {
  if (bytes.size() > may_write_) {
    const auto space = std::filesystem::space(path_);
    if (space.available < kLeftToOthers + bytes.size()) refuse("there is too little space");
    may_write_ =
        bytes.size() + std::min(kBetweenLooks, space.available - kLeftToOthers - bytes.size());
  }
  may_write_ -= bytes.size();
  while (!bytes.empty()) {
    const auto wrote = ::write(fd_, bytes.data(), bytes.size());
    if (wrote <= 0) refuse(std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(wrote));
  }
}

void TemporaryFile::refuse(const std::string& why) const {
  throw std::runtime_error(path_.string() + ", " + what_ + ": " + why + "; TMPDIR says where to");
}

}  // namespace marco::ros
