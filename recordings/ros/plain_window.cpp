#include "recordings/ros/plain_window.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace marco::ros {
namespace {

// Small enough for a processor's cache, large enough for a scan.
constexpr std::size_t kPiece = std::size_t{1} << 22;

}  // namespace

void PlainWindow::begin(Unpacker& unpacker, bool with_crc) {
  constexpr std::size_t kMostKept = 16 * kPiece;  // one large message is no reason to stay large
  if (buffer_.size() > kMostKept) buffer_ = {};
  unpacker_ = &unpacker;
  from_ = held_ = 0;
  unpacked_ = 0;
  with_crc_ = with_crc;
  crc_ = 0;
}

bool PlainWindow::skip(uint64_t count) {
  while (count > held_) {
    count -= held_;
    from_ = 0;
    held_ = unpack(buffer_.resize(std::max(kPiece, buffer_.size())));
    if (held_ == 0) return false;
  }
  from_ += static_cast<std::size_t>(count);
  held_ -= static_cast<std::size_t>(count);
  return true;
}

// The buffer grows as the bytes come: a damaged length may ask for more than there is.
void PlainWindow::fill(std::size_t count) {
  if (from_ > 0)
    std::memmove(buffer_.resize(buffer_.size()).data(), buffer_.bytes().data() + from_, held_);
  from_ = 0;
  while (held_ < count) {
    const std::size_t wanted = std::min(count, 2 * held_);
    const auto room = buffer_.resize(std::max({kPiece, buffer_.size(), wanted})).subspan(held_);
    const std::size_t got = unpack(room);
    if (got == 0) return;
    held_ += got;
  }
}

std::size_t PlainWindow::unpack(std::span<uint8_t> into) {
  const std::size_t got = unpacker_->read(into);
  if (with_crc_) crc_ = static_cast<uint32_t>(::crc32_z(crc_, into.data(), got));
  unpacked_ += got;
  return got;
}

}  // namespace marco::ros
