#include "tools/log/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "common/check.hpp"

namespace marco::logs {
namespace {

constexpr std::size_t kBufferBytes = 256 << 10;

}  // namespace

void check_output_path(const std::filesystem::path& path,
                       Existing existing,
                       const std::vector<std::filesystem::path>& inputs) {
  std::error_code none;
  for (const auto& input : inputs) {
    require(!std::filesystem::equivalent(path, input, none),
            path.string() + ": is the input itself; give another name");
  }
  require(existing == Existing::replace || !std::filesystem::exists(path, none),
          path.string() + ": exists already; --force replaces it");
}

OutputFile::OutputFile(std::filesystem::path path,
                       Existing existing,
                       const std::vector<std::filesystem::path>& inputs)
    : path_(std::move(path)), part_path_(path_.string() + ".part") {
  check_output_path(path_, existing, inputs);
  constexpr mode_t kEverybodyReads = 0666;
  descriptor_ = open(part_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kEverybodyReads);
  if (descriptor_ < 0) {
    throw std::runtime_error(path_.string() + ": cannot be created: " + std::strerror(errno));
  }
  buffer_.reserve(kBufferBytes);
}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  unlink(part_path_.c_str());
}

void OutputFile::fail() const {
  throw std::runtime_error(path_.string() + ": cannot be written: " + std::strerror(errno));
}

void OutputFile::write_through(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail();
    written_ += done;
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
}

void OutputFile::flush() {
  write_through(buffer_);
  buffer_.clear();
}

void OutputFile::write(std::span<const uint8_t> bytes) {
  if (buffer_.size() + bytes.size() > kBufferBytes) flush();
  if (bytes.size() >= kBufferBytes) {
    write_through(bytes);
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
}

void OutputFile::write(std::string_view text) {
  write(std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
}

void OutputFile::copy_from(int descriptor, int64_t offset, int64_t count) {
  flush();
  off64_t from = offset;
  while (count > 0) {
    const ssize_t done = copy_file_range(descriptor, &from, descriptor_, nullptr,
                                         static_cast<std::size_t>(count), 0);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) break;  // other file systems, old kernels: copied by hand below
    written_ += done;
    count -= done;
  }
  offset = from;
  while (count > 0) {
    if (buffer_.size() == kBufferBytes) flush();
    const std::size_t old_size = buffer_.size();
    const std::size_t step = std::min(static_cast<std::size_t>(count), kBufferBytes - old_size);
    buffer_.resize(old_size + step);
    const ssize_t got = pread(descriptor, buffer_.data() + old_size, step, offset);
    buffer_.resize(old_size + static_cast<std::size_t>(std::max<ssize_t>(0, got)));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw std::runtime_error(path_.string() + ": its source shrank while it was read");
    offset += got;
    count -= got;
  }
}

void OutputFile::finish() {
  flush();
  if (close(std::exchange(descriptor_, -1)) != 0) {
    unlink(part_path_.c_str());
    fail();
  }
  std::error_code failure;
  std::filesystem::rename(part_path_, path_, failure);
  if (failure) {
    unlink(part_path_.c_str());
    throw std::runtime_error(path_.string() + ": cannot be written: " + failure.message());
  }
}

}  // namespace marco::logs
