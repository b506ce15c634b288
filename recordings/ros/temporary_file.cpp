#include "recordings/ros/temporary_file.hpp"

#include <fcntl.h>   // O_CLOEXEC
#include <stdlib.h>  // mkostemp
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace marco::ros {
namespace {

std::filesystem::path temporary_folder() {
  const char* named = std::getenv("TMPDIR");
  return named == nullptr ? "/tmp" : named;
}

}  // namespace

TemporaryFile::TemporaryFile(std::string what, uint64_t left_to_others)
    : what_(std::move(what)), folder_(temporary_folder()), left_to_others_(left_to_others) {
  std::string name = (folder_ / "marco_XXXXXX").string();
  fd_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (fd_ < 0) refuse(std::strerror(errno));
  ::unlink(name.c_str());
}

TemporaryFile::~TemporaryFile() { ::close(fd_); }

void TemporaryFile::append(std::span<const uint8_t> bytes) {
  constexpr uint64_t kBetweenLooks = uint64_t{64} << 20;
  if (bytes.size() > may_write_) {
    const uint64_t available = std::filesystem::space(folder_).available;
    if (available < left_to_others_ + bytes.size()) refuse("there is too little space");
    may_write_ =
        std::max<uint64_t>(bytes.size(), std::min(kBetweenLooks, available - left_to_others_));
  }
  may_write_ -= bytes.size();
  while (!bytes.empty()) {
    const auto wrote = ::write(fd_, bytes.data(), bytes.size());
    if (wrote <= 0) refuse(std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(wrote));
  }
}

void TemporaryFile::refuse(const std::string& why) const {
  throw std::runtime_error("no temporary file in " + folder_.string() + " " + what_ + ": " + why +
                           "; set TMPDIR to another folder");
}

}  // namespace marco::ros
