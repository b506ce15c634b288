#include "recordings/ros/byte_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>

#include "lcm_tools/files/readable.hpp"

namespace marco::ros {

ByteFile::ByteFile(const std::filesystem::path& path) {
  files::require_readable(path);
  fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);  // NOLINT(cppcoreguidelines-pro-type-vararg)
  size_ = fd_ < 0 ? 0 : static_cast<int64_t>(::lseek(fd_, 0, SEEK_END));
}

ByteFile::~ByteFile() {
  if (fd_ >= 0) ::close(fd_);
}

std::size_t ByteFile::read(int64_t offset, std::span<uint8_t> into) const {
  std::size_t done = 0;
  while (done < into.size()) {
    const auto got = ::pread(fd_, into.data() + done, into.size() - done,
                             static_cast<off_t>(offset) + static_cast<off_t>(done));
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::span<const uint8_t> ByteFile::peek(int64_t offset, std::size_t size) {
  constexpr std::size_t kWindow = 1 << 16, kMostKept = 1 << 20;
  const auto held = static_cast<int64_t>(window_.size());
  const bool is_held =
      offset >= window_at_ && offset + static_cast<int64_t>(size) <= window_at_ + held;
  if (!is_held) {
    if (window_.size() > kMostKept) window_ = {};
    window_.resize(std::max(kWindow, size));
    window_at_ = offset;
    window_.resize(read(offset, window_));
  }
  const auto from = static_cast<std::size_t>(offset - window_at_);
  return std::span<const uint8_t>(window_).subspan(from, std::min(size, window_.size() - from));
}

void ByteFile::read(int64_t offset, int64_t size, ByteBuffer& into) const {
  const int64_t there = std::clamp<int64_t>(size_ - offset, 0, std::max<int64_t>(0, size));
  into.resize(read(offset, into.resize(static_cast<std::size_t>(there))));
}

std::vector<uint8_t> ByteFile::bytes(int64_t offset, int64_t size) const {
  ByteBuffer buffer;
  read(offset, size, buffer);
  return {buffer.bytes().begin(), buffer.bytes().end()};
}

}  // namespace marco::ros
