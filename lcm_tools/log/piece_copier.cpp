#include "lcm_tools/log/piece_copier.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"

namespace marco::logs {
namespace {

// Small enough that what was just scanned is still in the page cache, and that progress moves.
constexpr int64_t kLargestPiece = 16 << 20;
constexpr int64_t kLargePiece = 64 << 10;  // worth a system call of its own
constexpr std::size_t kWindowBytes = 256 << 10;

}  // namespace

PieceCopier::PieceCopier(const std::filesystem::path& in, OutputFile& out)
    : source_(open(in.c_str(), O_RDONLY | O_CLOEXEC)), out_(out) {
  require(source_ >= 0, in.string() + ": cannot be read: " + std::strerror(errno));
}

PieceCopier::~PieceCopier() { close(source_); }

void PieceCopier::add(int64_t from, int64_t to) {
  if (from != to_ || to_ - from_ > kLargestPiece) {
    copy();
    from_ = from;
  }
  to_ = to;
}

void PieceCopier::copy() {
  if (to_ - from_ >= kLargePiece) {
    out_.copy_from(source_, from_, to_ - from_);
  } else if (to_ > from_) {
    copy_small();
  }
  from_ = to_;
}

// Small pieces lie close together: one reading serves many.
void PieceCopier::copy_small() {
  if (from_ < window_start_ || to_ > window_start_ + static_cast<int64_t>(window_.size())) {
    window_.resize(kWindowBytes);
    ssize_t got = -1;
    do got = pread(source_, window_.data(), window_.size(), from_);
    while (got < 0 && errno == EINTR);
    window_.resize(static_cast<std::size_t>(std::max<ssize_t>(0, got)));
    window_start_ = from_;
    if (got < to_ - from_) throw std::runtime_error("the log shrank while it was read");
  }
  out_.write(std::span(window_).subspan(static_cast<std::size_t>(from_ - window_start_),
                                        static_cast<std::size_t>(to_ - from_)));
}

}  // namespace marco::logs
